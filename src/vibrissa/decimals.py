"""Exact decimals: a grid value is what the user wrote, not the binary number next to it.

A value is a number, or a polynomial in the arc length s: the coefficients of its powers, lowest
first.
"""

from collections.abc import Sequence
from decimal import Decimal
from functools import lru_cache
from typing import TypeAlias

Value: TypeAlias = Decimal | tuple[Decimal, ...]

# Texts whose value is remembered: keys of curves have few that differ.
SPELLINGS = 4096


def exact(value: Decimal | float | int | str) -> Decimal:
    """Return the decimal number that a value was written as, in its shortest form.

    Parameters
    ----------
    value : Decimal, float, int or str
        A float stands for the shortest decimal that reads back as it.

    Returns
    -------
    Decimal
        Without trailing zeros, so that equal values have one spelling.

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


def polynomial(coefficients: Sequence[Decimal]) -> Value:
    """Shortest form of a polynomial: its highest coefficient is not zero; a constant is a number.

    Parameters
    ----------
    coefficients : sequence of Decimal
        At least one, lowest power first.

    Returns
    -------
    Decimal or tuple of Decimal
    """
    constant, *powers = coefficients
    while powers and not powers[-1]:
        powers.pop()
    return (constant, *powers) if powers else constant


def coefficients_of(value: Value) -> tuple[Decimal, ...]:
    """Coefficients of a value, lowest power first: the number itself, or those of a polynomial."""
    return value if isinstance(value, tuple) else (value,)


def spell(value: Value) -> str:
    """Plain spelling without exponent: ``0.001``, never ``1E-3``; of a polynomial ``0.1, -0.3``."""
    return ", ".join(format(number, "f") for number in coefficients_of(value))


@lru_cache(SPELLINGS)
def read_value(text: str) -> Value:
    """Inverse of `spell`; a `ValueError` where a part is not a finite number."""
    return polynomial([exact(part) for part in text.split(",")])


def order_of(value: Value) -> tuple[Decimal, str]:
    """Return what values are sorted by: the constant, then the other coefficients as a text."""
    return (value[0], spell(value[1:])) if isinstance(value, tuple) else (value, "")
