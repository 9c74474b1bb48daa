"""Paths: the states along smooth pieces of branches.

A piece has one kind of contact and is counted by one parameter. A *path* is a batch of states with
two leading axes: the first counts states along the pieces, the second pieces.
"""

from dataclasses import dataclass, replace

import numpy as np

from vibrissa.mechanics.equations import Closure
from vibrissa.mechanics.newton import solve
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import FloatArray, IntArray, SingleArray
from vibrissa.numerics.spectral import interpolation
from vibrissa.outcomes import Contact, Parameter, RodSection
from vibrissa.sticking.solving.branches import Branches


@dataclass(frozen=True, eq=False, kw_only=True)
class Pieces(Branches):
    """Smooth pieces of a batch of branches, all with the same kind of contact and parameter.

    Attributes
    ----------
    contact : Contact
    parameter : Parameter
    part : ndarray of int, shape (n,)
        Which part of the paths a piece belongs to.
    start, length : ndarray, shape (n,)
        First value of the parameter and how far the piece goes (x0 in L).
    direction : ndarray, shape (n, 4)
        Along which it is counted, if not by the displacement.
    section : RodSection
        A round rod has a margin out of the plane, too.
    """

    contact: Contact
    parameter: Parameter
    part: IntArray
    start: FloatArray
    length: FloatArray
    direction: FloatArray
    section: RodSection = RodSection.PLANAR

    def value(self, position: FloatArray) -> FloatArray:
        """Parameter at fractions of the pieces' length, shape (positions, n)."""
        return self.start + position[:, None] * self.length

    def repeated(self, count: int) -> "Pieces":
        """All pieces, again and again."""
        return self.take(np.tile(np.arange(len(self)), count))

    def closure_at(self, position: FloatArray) -> Closure:
        """Conditions at fractions of the pieces' length, as one batch."""
        pieces, value = self.repeated(len(position)), self.value(position).ravel()
        if self.parameter is Parameter.X0:
            return pieces.at_x0(value, self.contact)
        return pieces.at_advance(value, pieces.direction, self.contact)


def of_pieces(path: RodStates, rows: IntArray) -> RodStates:
    """Part of a path that belongs to some pieces."""
    return path.take((slice(None), rows))


def flat(path: RodStates) -> RodStates:
    """All states of a path as one batch."""
    return path.each(lambda values: values.reshape(-1, *values.shape[2:]))


def folded(states: RodStates, count: int) -> RodStates:
    """Inverse of `flat` for `count` states along each piece."""
    return states.each(lambda values: values.reshape(count, -1, *values.shape[1:]))


def combined(matrix: FloatArray, path: RodStates) -> RodStates:
    """Combine the states along each piece linearly.

    Parameters
    ----------
    matrix : ndarray, shape (new, old) or (pieces, new, old)
        Weights, which add up to 1; of all pieces, or of each.
    path : RodStates
        With `old` states along each piece.

    Returns
    -------
    RodStates
    """

    def along(values: FloatArray) -> FloatArray:
        if matrix.ndim == 2:
            return np.tensordot(matrix, values, 1)
        return np.einsum("cab,bc...->ac...", matrix, values, optimize=True)

    def same(values: FloatArray) -> FloatArray:
        return np.broadcast_to(values[0], (matrix.shape[-2], *values.shape[1:])).copy()

    # A sum with weights is the same theta up to rounding alone.
    mounting = None if path.mounting is None else path.mounting.each(same)
    return replace(path.each(along), theta=same(path.theta), mounting=mounting)


def interpolated(
    count: int, position: FloatArray, path: RodStates, inverse: SingleArray
) -> tuple[RodStates, SingleArray]:
    """Interpolate states, and what corrects them, from Chebyshev points to other places.

    Parameters
    ----------
    count : int
        Number of Chebyshev points.
    position : ndarray, shape (places,)
        Fractions of the pieces' length.
    path : RodStates
        With `count` states along each piece.
    inverse : ndarray, shape (count, pieces, k, k)
        What corrects them.

    Returns
    -------
    path : RodStates
    inverse : ndarray, shape (places, pieces, k, k)
    """
    matrix = interpolation(count, position)
    flat = matrix.astype(np.float32) @ inverse.reshape(len(inverse), -1)
    return combined(matrix, path), flat.reshape(-1, *inverse.shape[1:])


def solve_at(
    guess: RodStates, pieces: Pieces, position: FloatArray, inverse: SingleArray | None = None
) -> tuple[RodStates, SingleArray]:
    """Solve states at fractions of the pieces' length, all together.

    Parameters
    ----------
    guess : RodStates
        Path with a state at each place.
    pieces : Pieces
    position : ndarray, shape (places,)
        The fractions.
    inverse : ndarray, shape (places, pieces, k, k), optional
        What corrects the states (`coarse_inverse`), where it is known.

    Returns
    -------
    path : RodStates
        NaN where a state was not found.
    inverse : ndarray, shape (places, pieces, k, k)
    """
    count = len(position)
    known = None if inverse is None else inverse.reshape(-1, *inverse.shape[2:])
    height = np.tile(pieces.height, count)
    states, _, used = solve(flat(guess), height, pieces.closure_at(position), known)
    return folded(states, count), used.reshape(count, len(pieces), *used.shape[1:])
