"""States in retraction, from zero normal force to α = 0.

All rods are solved in one batch, as calls cost more than arithmetic.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from vibrissa.errors import NoResponseError
from vibrissa.mechanics.equations import ends
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray, IntArray
from vibrissa.numerics.roots import bracketed_root
from vibrissa.numerics.spectral import chebyshev_nodes, chebyshev_transform
from vibrissa.numerics.splines import joined
from vibrissa.outcomes import Contact
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.solving.offsets import StateSolution, solve_offsets

# States solved on each smooth stretch, the error allowed between them, and how often a stretch is
# halved until it is met.
NODES = 25
TOLERANCE = 1e-7
HALVINGS = 3
# s_c runs steeply towards the tip: there states stand more closely, by this power of equal steps.
GRADE = 4
# Where the normal force is looked at, as parts of the way to a straight rod: it vanishes before.
# Few at a time, as what lies behind takes long and need not be there.
PLACES = np.split(np.linspace(0.0, 0.95, 20), [4, 8, 14])
# How closely the place is sought where the rod has peeled off up to its tip (L), and by how many
# states at a time.
CLOSE, AT_ONCE = 1e-10, 15


class Stretch(NamedTuple):
    """A smooth stretch of the states of one rod, or a part of it.

    Attributes
    ----------
    start, stop : float
        Ends of the stretch, the lower first (L).
    """

    of: int
    start: float
    stop: float
    grade: int
    low: float = 0.0
    high: float = 1.0

    def x0(self, part: FloatArray) -> FloatArray:
        """Displacements at fractions of the path (L)."""
        at = self.low + (self.high - self.low) * part
        return self.start + (self.stop - self.start) * at**self.grade

    def halves(self) -> tuple["Stretch", "Stretch"]:
        """Both halves, the lower x0 first."""
        middle = 0.5 * (self.low + self.high)
        return self._replace(high=middle), self._replace(low=middle)


@dataclass(frozen=True, eq=False)
class Pulled:
    """States in which the clamps of some rods pull their tips."""

    curves: Sequence[StickingCurve]
    contact: Contact

    def splines(self, knots: int) -> list[list[PPoly]]:
        """Tabulate the reactions between x0 of no normal force and 0 for each rod.

        Returns
        -------
        list of list of PPoly
            fx, fy (E·I0/L²) and m (E·I0/L) over x0 on stretches one after the other.

        Raises
        ------
        NoResponseError
            If the normal force does not vanish, or a state on the way there is not found.
        """
        rods, end = np.arange(len(self.curves)), self._ends()
        peels = np.flatnonzero(self._lies(rods, 0.0 * end) & ~self._lies(rods, end))
        tip = np.zeros(len(rods))
        if len(peels):
            tip[peels] = self._tip_alone(peels, end[peels])
        stretches = [
            Stretch(of=rod, start=start, stop=stop, grade=grade)
            for rod in rods.tolist()
            for start, stop, grade in ((end[rod], tip[rod], 1), (tip[rod], 0.0, GRADE))
            if start < stop
        ]
        found = self._tabulated(stretches, knots, HALVINGS)
        return [
            [part for stretch, part in zip(stretches, found, strict=True) if stretch.of == rod]
            for rod in rods
        ]

    def _solutions(self, of: IntArray, x0: FloatArray) -> list[StateSolution]:
        """States of rods at displacements, found or not."""
        return solve_offsets(
            np.array([curve.theta for curve in self.curves]),
            np.array([curve.eta for curve in self.curves]),
            of,
            np.array([self.curves[rod].x1_init for rod in of]) - x0,
            self.contact,
            [curve.mounting for curve in self.curves],
        )

    def _solved(self, of: IntArray, x0: FloatArray) -> list[RodStates]:
        """States of rods at displacements, all of which must be found."""
        found = self._solutions(of, x0)
        return [_found(one, at) for one, at in zip(found, x0.tolist(), strict=True)]

    def _reactions(self, of: IntArray, x0: FloatArray) -> FloatArray:
        """Reactions fx, fy and m at the clamp, in rows."""
        states = self._solved(of, x0)
        return np.array([(one.fx[0], one.fy[0], ends(one).moment[0]) for one in states])

    def _lies(self, of: IntArray, x0: FloatArray) -> BoolArray:
        """Whether the rods lie along the surface behind the contact point."""
        if self.contact is Contact.POINT:
            return np.zeros(len(of), dtype=bool)
        return np.array([one.s_c[0] < 1.0 for one in self._solved(of, x0)])

    def _normal_forces(self) -> list[CubicSpline]:
        """Interpolate fy of each rod from α = 0 to its first zero."""
        straight = np.array([one.x1_init - np.sqrt(1.0 - one.eta**2) for one in self.curves])
        places: list[list[float]] = [[] for _ in self.curves]
        force: list[list[float]] = [[] for _ in self.curves]
        sought = np.arange(len(self.curves))
        for few in PLACES:
            if not len(sought):
                break
            of, x0 = np.repeat(sought, len(few)), np.outer(straight[sought], few).ravel()
            for rod, at, one in zip(of, x0, self._solutions(of, x0), strict=True):
                if not force[rod] or force[rod][-1] < 0.0:
                    force[rod].append(float(_found(one, at).fy[0]))
                    places[rod].append(float(at))
            sought = sought[[force[rod][-1] < 0.0 for rod in sought]]
        if len(sought):
            raise NoResponseError("pulling is not covered: the normal force does not vanish")
        return [CubicSpline(x[::-1], fy[::-1]) for x, fy in zip(places, force, strict=True)]

    def _ends(self) -> FloatArray:
        """Displacements at which the normal force of the pulled tips vanishes (L)."""
        splines = self._normal_forces()

        def force(x0: FloatArray, of: FloatArray) -> tuple[FloatArray, FloatArray]:
            rods = of.astype(int)
            value = np.array([one.fy[0] for one in self._solved(rods, x0)])
            slope = [float(splines[rod](at, 1)) for rod, at in zip(rods, x0, strict=True)]
            return value, np.array(slope)

        low, high = np.array([spline.x[:2] for spline in splines]).T
        guess = np.array([spline.solve(0.0, extrapolate=False)[0] for spline in splines])
        rods = np.arange(len(splines), dtype=float)
        return bracketed_root(force, low, high, rods, guess=guess)

    def _tip_alone(self, of: IntArray, end: FloatArray) -> FloatArray:
        """Displacements at which rods have peeled off up to their tips (L): kinks."""
        flat, peeled = 0.0 * end, end
        parts = np.arange(1, AT_ONCE + 1) / (AT_ONCE + 1)
        rows = np.arange(len(of))
        while np.max(flat - peeled) > CLOSE:
            x0 = flat[:, None] + np.outer(peeled - flat, parts)
            lies = self._lies(np.repeat(of, AT_ONCE), x0.ravel()).reshape(x0.shape)
            # How many from α = 0 on lie, one after the other.
            count = np.cumprod(lies, axis=1).sum(axis=1)
            x0 = np.column_stack([flat, x0, peeled])
            flat, peeled = x0[rows, count], x0[rows, count + 1]
        return peeled

    def _tabulated(self, stretches: Sequence[Stretch], knots: int, halvings: int) -> list[PPoly]:
        """Tabulate stretches through Chebyshev series that are verified."""
        nodes = chebyshev_nodes(NODES)
        # Between the nodes the series must agree with states that it has not seen.
        middle = NODES // 2
        unseen = 0.5 * (nodes[[0, middle, -2]] + nodes[[1, middle + 1, -1]])
        parts = np.append(nodes, unseen)
        of = np.repeat([stretch.of for stretch in stretches], len(parts))
        x0 = np.concatenate([stretch.x0(parts) for stretch in stretches])
        reactions = self._reactions(of, x0).reshape(len(stretches), len(parts), 3)
        found: dict[int, PPoly] = {}
        coarse = []
        for number, (stretch, values) in enumerate(zip(stretches, reactions, strict=True)):
            series = chebyshev_transform(NODES) @ values[:NODES]
            error = np.abs(_along(series, unseen) - values[NODES:]).max()
            if error <= TOLERANCE * np.abs(values).max():
                at = np.linspace(0.0, 1.0, knots)
                found[number] = CubicSpline(stretch.x0(at), _along(series, at))
            elif halvings:
                coarse.append(number)
            else:
                where = float(stretch.x0(unseen)[0])
                raise NoResponseError(f"pulling is not covered: not resolved near x0 = {where:.6g}")
        if coarse:
            halves = [half for number in coarse for half in stretches[number].halves()]
            finer = self._tabulated(halves, knots, halvings - 1)
            for number, both in zip(coarse, zip(finer[::2], finer[1::2], strict=True), strict=True):
                found[number] = joined(both)
        return [found[number] for number in range(len(stretches))]


def _found(solution: StateSolution, x0: float) -> RodStates:
    """State at a displacement, which must have been found."""
    if solution.state is None:
        raise NoResponseError(f"pulling is not covered: at x0 = {x0:.6g} {solution.message}")
    return solution.state


def _along(series: FloatArray, part: FloatArray) -> FloatArray:
    """Evaluate Chebyshev series over [0, 1], a row for each place."""
    return np.asarray(np.polynomial.chebyshev.chebval(2.0 * part - 1.0, series).T)
