"""The rod that a recording is read with: the given one, or adjusted to the recording."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.sensor.identification.adjusting.adjustment import Adjusted, Prior, adjusted
from vibrissa.sensor.identification.adjusting.priors import prior_of
from vibrissa.sensor.identification.adjusting.properties import Bench
from vibrissa.sensor.identification.adjusting.solving import Solver
from vibrissa.sensor.identification.misfit.doubts import Doubt
from vibrissa.sensor.identification.misfit.mixups import check_columns
from vibrissa.sensor.identification.part import before_swing
from vibrissa.sensor.identification.periods import JUMP, Channels, located
from vibrissa.sensor.identification.preparing.settling import LONG, Told, settled
from vibrissa.sensor.identification.recording import Recording, check_size, left_out, noise_of
from vibrissa.sensor.identification.setup import Setup
from vibrissa.sensor.stage import ObliqueStage
from vibrissa.sensor.transducer import Transducer
from vibrissa.sensor.whisker import Progress, Whisker


def _known(stage: ObliqueStage, recording: Recording) -> Recording:
    """Take the samples at heights at which the rod has a response, and note the others."""
    known = stage.covers(recording.clamp)
    why = "; ".join(filter(None, (stage.heights.below, stage.heights.above)))
    notes = recording.notes + left_out(
        recording.line[~known], f"no response at this height ({why})"
    )
    return replace(recording, notes=notes).take(known)


@dataclass(frozen=True, eq=False, kw_only=True)
class RodFit:
    """A recording, and the rod that it is read with: the given one, or adjusted to it.

    Attributes
    ----------
    whisker : Whisker
    solver : Solver
        Of rods like it.
    recording : Recording
        Without the errors of transducer and stage, as far as they were adjusted.
    noise : ndarray, shape (3,), or None
        Of its readings, if it was given.
    setup : Setup
        Of the rod.
    prior : Prior
        What could be adjusted.
    found : Adjusted, optional
        What was.
    """

    whisker: Whisker
    solver: Solver
    recording: Recording
    noise: FloatArray | None
    setup: Setup
    prior: Prior
    found: Adjusted | None = None

    @property
    def doubtful(self) -> tuple[tuple[Doubt, str], ...]:
        """Why all periods are in doubt, and what it concerns."""
        if self.found is None:
            return ()
        if not self.found.settled:
            return ((Doubt.NOT_ADJUSTED, ""),)
        return tuple(
            (Doubt.FAR, f"{one.name} ({one.surprise:.1f} standard deviations)")
            for one in self.found.far
        )

    def settled(self, given: Recording, told: Told) -> Recording:
        """Leave out of the recording that was given what belongs to slips.

        With the rod as it was given, its errors would look like readings that have not settled.
        """
        whole = self.recording
        if len(whole) <= LONG:
            return given
        noise = noise_of(whole.readings) if self.noise is None else self.noise
        channels = Channels.recorded(whole, noise)
        found = settled(self.setup.branch, whole, channels, told, self.whisker.units)
        if found is whole:
            return given
        kept = given.take(np.isin(given.line, found.line))
        return replace(kept, slipping=found.slipping, notes=found.notes)

    @property
    def result(self) -> dict[str, Any]:
        """What an `Identification` tells of it."""
        if self.found is None:
            return {"setup": self.setup}
        found = self.found
        return {
            "setup": found.setup,
            "tolerances": found.tolerances,
            "covariance": found.covariance,
            "far": found.far,
        }


def fit_rod(
    whisker: Whisker,
    recording: Recording,
    given: FloatArray | None,
    transducer: Transducer | None,
    assume: bool,
    progress: Progress,
) -> RodFit:
    """Adjust the rod to the recording, as far as it is not exact.

    Parameters
    ----------
    whisker : Whisker
        With its tolerances.
    recording : Recording
    given : ndarray, shape (3,), or None
        Noise of the readings, nondimensional; None if it is to be estimated.
    transducer : Transducer or None
        Which tells the tolerances that are assumed of its zeros.
    assume : bool
        Whether what nothing is stated about has the tolerance that is assumed for it.
    progress : callable

    Returns
    -------
    RodFit

    Raises
    ------
    MixedColumnsError
        If its columns are mixed up.
    NoResponseError
        If the rod has no response.
    """
    check_size(len(recording), recording.notes)
    clamp = recording.clamp
    solver = Solver(clamp=clamp, backward=bool((np.diff(clamp) < 0.0).any()), pulled=False)
    noise = noise_of(recording.readings) if given is None else given
    branch = solver.exact(whisker, progress)
    if isinstance(branch, ObliqueStage):
        recording = _known(branch, recording)
        check_size(len(recording), recording.notes)
    channels = Channels.recorded(recording, noise)
    if channels.used:
        check_columns(branch, recording, channels)
        recording = before_swing(branch, recording, channels)
        samples = located(branch, recording, channels)
        pulled = bool((samples.x0 < -JUMP * samples.deviation).any())
        solver = replace(solver, pulled=solver.backward or pulled)
    prior = prior_of(whisker, recording, noise, assume)
    same = RodFit(
        whisker=whisker,
        solver=solver,
        recording=recording,
        noise=given,
        setup=Setup(branch=branch),
        prior=prior,
    )
    if not (prior.tolerances and channels.used):
        return same
    bench = Bench.of(recording, transducer, whisker.units.channels)
    found = adjusted(whisker, recording, channels, prior, solver, bench)
    return replace(
        same,
        whisker=found.whisker,
        recording=found.recording,
        noise=None if given is None else found.noise_of(given),
        setup=found.setup,
        found=found,
    )
