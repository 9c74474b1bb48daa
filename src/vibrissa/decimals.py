"""Exact decimals: a grid value is the decimal in the study file, not the nearest double."""

from decimal import Decimal


def exact(value: Decimal | float | int | str) -> Decimal:
    """Convert a number to an exact decimal without trailing zeros.

    A float becomes the shortest decimal that reads back as the same float.

    Raises
    ------
    ValueError
        If the value is not a finite number.

    Examples
    --------
    >>> exact(0.1), exact("0.30")
    (Decimal('0.1'), Decimal('0.3'))
    """
    try:
        # float(), because the repr of NumPy's numbers contains the name of their type
        number = Decimal(value if isinstance(value, Decimal | int | str) else repr(float(value)))
    except ArithmeticError as error:
        raise ValueError(f"not a number: {value!r}") from error
    if not number.is_finite():
        raise ValueError(f"not a finite number: {value!r}")
    return number.normalize() + 0  # + 0 turns -0 into 0


def spell(value: Decimal) -> str:
    """Format a decimal without an exponent: ``0.001``, never ``1E-3``."""
    return format(value, "f")
