"""Exact decimals: a grid value is the number in the file, not the nearest binary one."""

from decimal import Decimal


def exact(value: Decimal | float | int | str) -> Decimal:
    """Return the decimal number that a value was written as, without trailing zeros.

    A float was written as the shortest decimal that reads back equal.

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
        # float() for the sake of NumPy's numbers, whose repr names their type
        number = Decimal(value if isinstance(value, Decimal | int | str) else repr(float(value)))
    except ArithmeticError as error:
        raise ValueError(f"not a number: {value!r}") from error
    if not number.is_finite():
        raise ValueError(f"not a finite number: {value!r}")
    return number.normalize() + 0  # + 0 turns -0 into 0


def spell(value: Decimal) -> str:
    """Plain spelling without exponent: ``0.001``, never ``1E-3``."""
    return format(value, "f")
