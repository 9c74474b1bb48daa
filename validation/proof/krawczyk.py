"""Proved solutions of a system of equations: Newton's method, then Krawczyk's test."""

from collections.abc import Callable, Sequence

from flint import arb, arb_mat

from validation.proof import NotProvedError

# Maps a point or a box, shape (n, 1), to values of F, shape (n, 1), and derivatives of F, shape
# (n, n): balls that contain them everywhere in the box.
System = Callable[[arb_mat], tuple[arb_mat, arb_mat]]

# Half-widths of a box in units of Newton's last correction.
REACH = 2
# Largest number of Newton's corrections: if they do not suffice, the start was too far away.
CORRECTIONS = 10


def solution(system: System, near: Sequence[arb | float]) -> arb_mat:
    """Find a solution, and prove that it is the only one in a box around it.

    Parameters
    ----------
    system : callable
    near : sequence of float, length n
        Start of Newton's method; the proof does not depend on it.

    Returns
    -------
    arb_mat, shape (n, 1)
        Enclosure of the solution.

    Raises
    ------
    NotProvedError
        If Newton's method does not converge, or Krawczyk's test fails.
    """
    centre = arb_mat([[arb(value)] for value in near])
    for _ in range(CORRECTIONS):
        values, slopes = system(centre)
        correction = middle_inverse(slopes) * values
        # The correction is within the errors of the integration.
        if all(change.contains(0) for change in correction.entries()):
            return krawczyk(system, centre, reached(correction))
        centre = (centre - correction).mid()
    raise NotProvedError("Newton's method does not converge")


def reached(correction: arb_mat) -> list[arb]:
    """Return half-widths for a box, given Newton's correction at its centre."""
    sizes = [abs(change).upper() for change in correction.entries()]
    # A component that happens to change little is not more accurate than the others.
    least = max(sizes, key=float) / 8
    return [REACH * max(size, least, key=float) for size in sizes]


def krawczyk(system: System, centre: arb_mat, reach: Sequence[arb | float]) -> arb_mat:
    """Prove that F(z) = 0 has exactly one solution in a box, and enclose it.

    If Krawczyk's operator, the box K that `operator` returns, lies in the interior of the box Z,
    then F has exactly one zero in Z, and K holds it [1]_, [2]_.

    Parameters
    ----------
    system : callable
        F and F'.
    centre : arb_mat, shape (n, 1)
        Middle of the box.
    reach : sequence of float, length n
        Half-widths of the box.

    Returns
    -------
    arb_mat, shape (n, 1)
        The box K.

    Raises
    ------
    NotProvedError
        If K does not lie in the interior of Z. There may be a solution nevertheless.

    References
    ----------
    .. [1] R. Krawczyk, *Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken*,
       Computing 4, 187-201 (1969), doi:10.1007/BF02234767.
    .. [2] S. M. Rump, *Verification methods: Rigorous results using floating-point arithmetic*,
       Acta Numerica 19, 287-449 (2010), doi:10.1017/S096249291000005X.
    """
    more = arb_mat([[arb(0, one)] for one in reach])
    values, _ = system(centre)
    _, slopes = system(centre + more)
    image = operator(values, more, slopes)
    if not inside(image, more):
        raise NotProvedError("Krawczyk's test fails")
    return centre + image


def operator(values: arb_mat, more: arb_mat, slopes: arb_mat) -> arb_mat:
    """Return Krawczyk's operator for the box c + more, less c.

    With any matrix A, here the inverse of the middle of the slopes, it is

        K − c = −A·F(c) + (I − A·F'(Z))·(Z − c).

    Parameters
    ----------
    values : arb_mat, shape (n, 1)
        F(c), or balls that hold it.
    more : arb_mat, shape (n, 1)
        Z − c: balls around zero.
    slopes : arb_mat, shape (n, n)
        Balls that hold F'(z) for every z of the box Z.
    """
    inverse = middle_inverse(slopes)
    unity = arb_mat(slopes.nrows(), slopes.ncols(), 1)
    return (unity - inverse * slopes) * more - inverse * values


def inside(image: arb_mat, box: arb_mat) -> bool:
    """Whether a box lies in the interior of another."""
    pairs = zip(image.entries(), box.entries(), strict=True)
    return all(whole.contains_interior(part) for part, whole in pairs)


def middle_inverse(slopes: arb_mat) -> arb_mat:
    """Return an approximate inverse of the midpoint of a matrix.

    Raises
    ------
    NotProvedError
        If the midpoint is singular.
    """
    try:
        return slopes.mid().inv().mid()
    except (ZeroDivisionError, ValueError):
        raise NotProvedError("the equations are singular") from None
