"""Conversion of balls to decimal numbers that enclose them."""

from decimal import ROUND_CEILING, ROUND_HALF_EVEN, Decimal, localcontext

from flint import arb

# Largest number of digits of a midpoint.
DIGITS = 32


def decimals(ball: arb) -> tuple[Decimal, Decimal]:
    """Enclose a ball by a decimal midpoint and radius.

    Parameters
    ----------
    ball : arb
        A finite ball.

    Returns
    -------
    midpoint, radius : Decimal
        The radius has two digits, and the midpoint ends at the same place.
    """
    middle, radius, exponent = (int(part) for part in ball.mid_rad_10exp(DIGITS))
    with localcontext(prec=4 * DIGITS, rounding=ROUND_HALF_EVEN) as context:
        exact, error = Decimal(middle).scaleb(exponent), Decimal(radius).scaleb(exponent)
        last = error.adjusted() - 1 if error else min(exponent, 0)
        place = Decimal(1).scaleb(max(last, exact.adjusted() - DIGITS))
        # Zero has no sign.
        midpoint = exact.quantize(place) + 0
        context.rounding = ROUND_CEILING
        return midpoint, (error + abs(exact - midpoint)).quantize(place)
