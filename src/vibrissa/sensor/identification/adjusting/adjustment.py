"""What was given is adjusted to the recording within its tolerances, and what remains carried on.

The adjustments p minimise χ²(p) + Σ (p/σ)², where σ are the tolerances, and each period has its own
best contact. The recording may tell a quantity much better than its tolerance, or not at all: what
remains is the covariance (JᵀJ + 1/σ²)⁻¹, J = ∂(residuals)/∂p. This is Bayes' theorem for normal
errors, by Gauss-Newton steps. The derivatives are told anew only where the steps do not settle.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import lsq_linear
from scipy.special import chdtrc

from vibrissa.errors import NoResponseError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.given.tolerances import told
from vibrissa.sensor.identification.adjusting.properties import (
    OF_HEIGHT,
    Bench,
    Component,
    components_of,
    with_sizes,
    without_errors,
)
from vibrissa.sensor.identification.adjusting.solving import Solver
from vibrissa.sensor.identification.alternatives import (
    STEP,
    Alternative,
    alternative,
    inclined,
    step_in_height,
)
from vibrissa.sensor.identification.part import Part
from vibrissa.sensor.identification.periods import Channels, Placed, located
from vibrissa.sensor.identification.recording import Recording
from vibrissa.sensor.identification.seen import Seen
from vibrissa.sensor.identification.setup import Setup
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.response.branch import Branch
from vibrissa.sensor.response.height_range import HIGHEST, LOWEST
from vibrissa.sensor.stage import ObliqueStage
from vibrissa.sensor.whisker import Whisker

# Most steps, after how many the derivatives are told anew, and when they end: a step of this part
# of the deviation that remains.
ROUNDS, RENEWED, SETTLED = 12, 3, 0.1
# A derivative is a difference over this part of the tolerance at most.
PART = 0.1
# A stage that is level but for a change of the height by this much along the recording (L) is
# corrected to first order; otherwise the rod is solved at all heights.
NEARLY_LEVEL, LEVEL_AT_MOST = 4e-3, 1e-2
STAGE = "stage_angle"
# So many standard deviations are far from what was given, and an adjustment as a whole of a lower
# probability; and less of a variance than this is not told by a recording.
FAR, UNLIKELY, LITTLE = 3.0, 1e-3, 0.01
# What the recording tells at least this part of, by the variance, is tested as a whole.
TOLD = 0.5


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """Something that is known to a tolerance, and what the recording tells of it.

    Attributes
    ----------
    name : str
    of : str
        Name of the tolerance, which may have several parts.
    tolerance : float
        Standard deviation of what was given.
    adjusted, deviation : float
        By how much it is larger by the recording, and the standard deviation that remains.
    wave : int
        Number of the wave of a drift; 0 for all else.
    stated : bool
        Whether the tolerance was stated; otherwise it was assumed.
    """

    name: str
    of: str
    tolerance: float
    adjusted: float
    deviation: float
    wave: int = 0
    stated: bool = True

    @property
    def score(self) -> float:
        """The adjustment in tolerances."""
        return self.adjusted / self.tolerance

    @property
    def surprise(self) -> float:
        """How far the recording is from what was given, in standard deviations.

        An adjustment p has before the variance σ² − s², where s² is what remains of the tolerance
        σ². The sum that is minimised would fall by the square of this without the tolerance.
        """
        told_of = 1.0 - (self.deviation / self.tolerance) ** 2
        return abs(self.score) / np.sqrt(told_of) if told_of > LITTLE else 0.0

    def moved(self, units: Units) -> str:
        """Say by how much it is other than given, and how surprising that is."""
        size, unit = told(self.of, abs(self.adjusted), units)
        way = "larger" if self.adjusted > 0.0 else "smaller"
        by = f"{size:.3g} {unit}".rstrip()
        return f"{self.name} {way} by {by} than given ({self.surprise:.1f} standard deviations)"

    def spelled(self, units: Units) -> str:
        """Say it in a person's units."""
        adjusted, unit = told(self.of, self.adjusted, units)
        deviation, tolerance = (
            told(self.of, size, units)[0] for size in (self.deviation, self.tolerance)
        )
        return (
            (
                f"{self.name}: given to ± {tolerance:.3g} {unit}, by the recording "
                f"{adjusted:+.3g} ± {deviation:.2g} {unit} beside that"
            )
            .replace("  ", " ")
            .replace(" ,", ",")
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class Prior:
    """What is to be adjusted, and how much it may be.

    Attributes
    ----------
    tolerances : mapping of str to float
        Standard deviations, in units of the rod, rad, or relative; all above 0.
    stated : frozenset of str
        Names of those that were stated.
    """

    tolerances: Mapping[str, float]
    stated: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False, kw_only=True)
class Adjusted:
    """What was given, adjusted to a recording within its tolerances.

    Attributes
    ----------
    setup : Setup
        Of the adjusted rod.
    recording : Recording
        Without the errors of transducer and stage.
    whisker : Whisker
        The adjusted one.
    mixing : ndarray, shape (3, 3)
        By which the readings were multiplied, and their noise with them.
    tolerances : tuple of Tolerance
    covariance : ndarray, shape (k, k)
        Of what remains, in the order of the tolerances.
    chance : float
        Probability of such adjustments, or larger ones, of what is given to these tolerances.
    settled : bool
        Whether the steps have settled; otherwise nothing is adjusted, and all tolerances remain.
    """

    setup: Setup
    recording: Recording
    whisker: Whisker
    mixing: FloatArray
    tolerances: tuple[Tolerance, ...]
    covariance: FloatArray
    chance: float
    settled: bool = True

    def noise_of(self, noise: FloatArray) -> FloatArray:
        """Give the noise of the adjusted readings, from that of the readings."""
        return np.asarray(np.sqrt(self.mixing**2 @ noise**2))

    @property
    def far(self) -> tuple[Tolerance, ...]:
        """What is far from what was given for its tolerance, the farthest first."""
        known = [one for one in self.tolerances if not one.wave]
        known.sort(key=lambda one: -one.surprise)
        far = tuple(one for one in known if one.surprise > FAR)
        return far or tuple(known[:1] if self.chance < UNLIKELY else ())


def adjusted(
    whisker: Whisker,
    recording: Recording,
    channels: Channels,
    prior: Prior,
    solver: Solver,
    bench: Bench,
) -> Adjusted:
    """Adjust what was given to a recording, within its tolerances.

    Parameters
    ----------
    whisker : Whisker
        That was given.
    recording : Recording
    channels : Channels
        All that were recorded.
    prior : Prior
    solver : Solver
    bench : Bench

    Returns
    -------
    Adjusted
        With nothing adjusted where the steps do not settle: the recording is too far from what was
        given.
    """
    fit = _Fit(
        whisker=whisker,
        recording=recording,
        channels=channels,
        components=[one for name in prior.tolerances for one in components_of(name, bench)],
        prior=prior,
        solver=solver,
    )
    try:
        found = fit.settled()
    except NoResponseError:
        found = None
    return fit.as_given() if found is None else found


@dataclass(frozen=True, eq=False, kw_only=True)
class _Fit:
    """Adjusts k components of the tolerances. Inside, sizes are in tolerances: `scores`."""

    whisker: Whisker
    recording: Recording
    channels: Channels
    components: Sequence[Component]
    prior: Prior
    solver: Solver

    @cached_property
    def sigma(self) -> FloatArray:
        """Deviations that were given, shape (k,)."""
        tolerances = self.prior.tolerances
        return np.array([one.weight * tolerances[one.of] for one in self.components])

    @cached_property
    def reach(self) -> float:
        """How far the clamp goes (L)."""
        return float(np.abs(self.recording.clamp).max())

    def settled(self) -> Adjusted | None:
        """Find the best sizes; None if the steps do not settle."""
        scores = np.zeros(len(self.components))
        ranges = np.array([_range(self.whisker, one.name) for one in self.components])
        low, high = ranges.T / self.sigma
        changes: list[Alternative] = []
        level = True
        for number in range(ROUNDS):
            rod = self._rod(scores)
            (branch,) = self.solver.quick(rod)
            if number % RENEWED == 0 or level != isinstance(branch, Branch):
                level = isinstance(branch, Branch)
                changes = self._changes(rod, branch)
            seen = _seen(branch, self._undone(scores, branch, changes), self.channels)
            jacobian = np.stack([seen.effect_of(one).ravel() for one in changes], 1) * self.sigma
            information = jacobian.T @ jacobian + np.eye(len(scores))
            step = _step_to(
                information,
                jacobian.T @ seen.residuals.ravel() - scores,
                (low - scores, high - scores),
            )
            # Steps that go to and fro come nearer when they are halved.
            scores = scores + (step if number < ROUNDS // 2 else step / 2.0)
            remaining = np.asarray(np.linalg.inv(information), dtype=float)
            if (np.abs(step) <= SETTLED * np.sqrt(np.diag(remaining))).all():
                return self._result(scores, remaining, changes)
        return None

    def as_given(self) -> Adjusted:
        """Adjust nothing: what was given is uncertain by all of its tolerances."""
        none = np.zeros(len(self.components))
        (branch,) = self.solver.quick(self.whisker)
        found = self._result(none, np.eye(len(none)), self._changes(self.whisker, branch))
        assert found is not None  # a stage that is not adjusted is not turned too far
        return replace(found, settled=False)

    def _result(
        self, scores: FloatArray, covariance: FloatArray, changes: list[Alternative]
    ) -> Adjusted | None:
        """Solve the adjusted rod, and say what was adjusted; None if the recording is not of it."""
        rod = self._rod(scores)
        branch = self.solver.exact(rod)
        undone = self._undone(scores, branch, changes)
        sizes, scale = scores * self.sigma, np.outer(self.sigma, self.sigma)
        if (np.abs(sizes[self._leans(scores)]) * self.reach > LEVEL_AT_MOST).any():
            return None
        setup = Setup(
            branch=branch,
            displaced=tuple(changes),
            shared=covariance * scale,
            penalty=float((scores**2).sum()),
        )
        left = np.sqrt(np.diag(covariance)) * self.sigma
        prior = self.prior
        return Adjusted(
            setup=setup,
            recording=undone,
            whisker=rod,
            mixing=_mixing(self.components, sizes),
            tolerances=tuple(
                Tolerance(
                    name=one.name,
                    of=one.of,
                    tolerance=float(given),
                    adjusted=float(size),
                    deviation=float(deviation),
                    wave=one.wave,
                    stated=one.of in prior.stated,
                )
                for one, given, size, deviation in zip(
                    self.components, self.sigma, sizes, left, strict=True
                )
            ),
            covariance=covariance * scale,
            chance=self._chance(scores, covariance),
        )

    def _chance(self, scores: FloatArray, covariance: FloatArray) -> float:
        """Probability of such adjustments: before, their covariance is what the recording tells."""
        part, axes = np.linalg.eigh(np.eye(len(scores)) - covariance)
        along = axes.T @ scores
        told_of = part > TOLD
        squares = float((along[told_of] ** 2 / part[told_of]).sum())
        return float(chdtrc(max(int(told_of.sum()), 1), squares))

    def _rod(self, scores: FloatArray) -> Whisker:
        """Make the whisker of such scores; its stage stays level where it nearly is."""
        sizes = np.where(self._leans(scores), 0.0, scores * self.sigma)
        return with_sizes(self.whisker, self.components, sizes)

    def _leans(self, scores: FloatArray) -> BoolArray:
        """Which component is the angle of a stage that is nearly level."""
        if self.whisker.mounting.stage_angle:
            return np.zeros(len(scores), dtype=bool)
        angle = np.array([one.name == STAGE for one in self.components])
        rise = np.abs(scores * self.sigma) * self.reach
        return angle & (rise < NEARLY_LEVEL)

    def _undone(
        self, scores: FloatArray, branch: Placed, changes: Sequence[Alternative]
    ) -> Recording:
        """Take the errors of transducer and stage off the recording."""
        sizes, raw = scores * self.sigma, self.recording
        lost = np.isnan(raw.readings)
        filled = raw
        if lost.any():
            # What was not recorded is what the rod would show.
            samples = located(branch, raw, self.channels)
            states, _ = branch.above(samples.clamp)
            filled = replace(raw, readings=np.where(lost, states(samples.x0), raw.readings))
        undone = without_errors(filled, self.components, sizes)
        for number in np.flatnonzero(self._leans(scores) & (sizes != 0.0)).tolist():
            samples = located(branch, undone, self.channels)
            corrected = changes[number].corrected(samples, float(sizes[number]))
            undone = replace(
                undone,
                clamp=corrected.clamp,
                readings=corrected.readings,
                excess=corrected.excess,
            )
        return replace(undone, readings=np.where(lost, np.nan, undone.readings))

    def _changes(self, rod: Whisker, branch: Placed) -> list[Alternative]:
        """Make each component a little larger."""
        others: dict[int, Whisker] = {}
        steps = self._steps(rod)
        found: dict[int, Alternative] = {}
        for number, one in enumerate(self.components):
            other = one.property.whisker(rod, float(steps[number]))
            if one.name == STAGE and isinstance(branch, Branch):
                others[number] = replace(rod, eta=rod.eta + step_in_height(rod))
            elif other == rod:
                found[number] = alternative(one, float(steps[number]))
            elif one.name in OF_HEIGHT and isinstance(branch, ObliqueStage):
                # The rod is known at all heights near to its own.
                stage = replace(branch, eta=other.eta, angle=other.mounting.stage_angle)
                found[number] = alternative(one, float(steps[number]), stage, branch)
            else:
                others[number] = other
        for (number, _), solved in zip(
            others.items(), self.solver.quick(*others.values()), strict=True
        ):
            one = self.components[number]
            if isinstance(branch, Branch) and isinstance(solved, Branch) and one.name == STAGE:
                found[number] = inclined(branch, solved, step_in_height(rod))
            else:
                found[number] = alternative(one, float(steps[number]), solved, branch)
        return [found[number] for number in range(len(self.components))]

    def _steps(self, rod: Whisker) -> FloatArray:
        """How much larger each is made."""
        steps = np.minimum(STEP, PART * self.sigma)
        of_height = np.array([one.name == "eta" for one in self.components])
        return np.where(of_height, np.maximum(step_in_height(rod), -PART * self.sigma), steps)


def _step_to(
    information: FloatArray, gradient: FloatArray, bounds: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Of all steps within the bounds, the one with the least sum of squares."""
    best = np.asarray(np.linalg.solve(information, gradient), dtype=float)
    low, high = np.minimum(bounds[0], 0.0), np.maximum(bounds[1], 0.0)
    if ((low <= best) & (best <= high)).all():
        return best
    root = np.linalg.cholesky(information).T
    return np.asarray(lsq_linear(root, root @ best, (low, high)).x)


def _range(whisker: Whisker, name: str) -> tuple[float, float]:
    """Least and largest size that a property can take."""
    return {
        "theta": (1.0 - whisker.theta, np.inf),
        "eta": (LOWEST - whisker.eta, HIGHEST - whisker.eta),
        "clamp_compliance": (-whisker.mounting.clamp_compliance, np.inf),
    }.get(name, (-np.inf, np.inf))


def _mixing(components: Sequence[Component], sizes: FloatArray) -> FloatArray:
    """Matrix by which readings are multiplied where errors are taken off them."""
    readings = np.vstack([np.zeros(3), np.eye(3)])
    line = np.zeros(len(readings), dtype=np.int64)
    probe = Recording(clamp=np.zeros(len(readings)), readings=readings, line=line)
    undone = without_errors(probe, components, sizes).readings
    return np.asarray((undone[1:] - undone[0]).T)


def _seen(branch: Placed, recording: Recording, channels: Channels) -> Seen:
    """Periods of the samples that fit as well as most, ahead of the clamp."""
    seen = Part.of(branch, recording, channels).seen(channels)
    # At the largest moment, by the moment alone, no contact is told.
    return seen.only(np.isfinite(seen.contacts.place) & np.isfinite(seen.contacts.deviation))
