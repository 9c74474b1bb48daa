"""Krawczyk's test whether a box holds exactly one solution of a system of equations."""

from flint import arb_mat

from vibrissa.errors import NotProvedError


def krawczyk(centre: arb_mat, values: arb_mat, box: arb_mat, slopes: arb_mat) -> arb_mat:
    """Prove that F(z) = 0 has exactly one solution in a box, and enclose it.

    If Krawczyk's operator, the box K that `operator` returns, lies in the interior of Z, then F has
    exactly one zero in Z, and K holds it [1]_, [2]_.

    Parameters
    ----------
    centre : arb_mat, shape (n, 1)
        Point c of the box.
    values : arb_mat, shape (n, 1)
        F(c), or balls that hold it.
    box : arb_mat, shape (n, 1)
        Z.
    slopes : arb_mat, shape (n, n)
        Balls that hold F'(z) for every z of the box.

    Returns
    -------
    arb_mat, shape (n, 1)
        K.

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
    image = operator(centre, values, box, slopes)
    if not inside(image, box):
        raise NotProvedError("Krawczyk's test fails")
    return image


def operator(centre: arb_mat, values: arb_mat, box: arb_mat, slopes: arb_mat) -> arb_mat:
    """Return Krawczyk's operator, whose arguments are those of `krawczyk`.

    With any matrix A, here the inverse of the middle of the slopes, it is

        K = c − A·F(c) + (I − A·F'(Z))·(Z − c).
    """
    inverse = middle_inverse(slopes)
    unity = arb_mat(slopes.nrows(), slopes.ncols(), 1)
    return centre - inverse * values + (unity - inverse * slopes) * (box - centre)


def inside(image: arb_mat, box: arb_mat) -> bool:
    """Whether a box lies in the interior of another."""
    pairs = zip(image.entries(), box.entries(), strict=True)
    return all(whole.contains_interior(part) for part, whole in pairs)


def middle_inverse(slopes: arb_mat) -> arb_mat:
    """Invert the middle of a matrix, about.

    Raises
    ------
    NotProvedError
        If it is singular.
    """
    try:
        return slopes.mid().inv().mid()
    except (ZeroDivisionError, ValueError):
        raise NotProvedError("the equations are singular") from None
