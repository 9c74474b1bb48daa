"""Reading by the model of the rod: one fit of set-up and contacts to all recorded channels."""

from dataclasses import dataclass, replace

import numpy as np

from vibrissa.errors import NoResponseError, WrongRodError
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.sensor.identification.adjusted import far_of
from vibrissa.sensor.identification.blocks import condensed
from vibrissa.sensor.identification.checks import Check, Grade, checks_of_spans
from vibrissa.sensor.identification.fit import Fit, Noise, fitted, started
from vibrissa.sensor.identification.forward import Ends, Forward
from vibrissa.sensor.identification.friction import read_periods
from vibrissa.sensor.identification.goodness import Cause, Goodness, causes_of
from vibrissa.sensor.identification.guide import MISFIT, Guide
from vibrissa.sensor.identification.parameters import Parameter
from vibrissa.sensor.identification.periods import Periods
from vibrissa.sensor.identification.ratio import Lag
from vibrissa.sensor.identification.recording import noise_of
from vibrissa.sensor.identification.settling import Settling, middles, settling, unsettled
from vibrissa.sensor.identification.slips import Slipped, speed_of
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.transducer import CHANNELS
from vibrissa.sensor.whisker import Whisker

# A sample is no state of the rod if its readings differ by more than this part of them, and by more
# than noise. If more than this part of the samples is none, it is another rod or has a bias.
MOST_MISFIT, MOST_OFF = 0.1, 0.2
# So many causes are named for a recording that is refused, if each explains this part of χ².
NAMED, EXPLAINS = 3, 0.9
# Standard deviations by which a contact has surely moved.
CERTAIN = 6.0


@dataclass(frozen=True, eq=False, kw_only=True)
class Model:
    """What is known of a recording before it is read with a rod.

    Attributes
    ----------
    whisker : Whisker
    guide : Guide
    parameters : tuple of Parameter
    noise : ndarray, shape (3,)
        Standard deviation of one reading.
    noise_is_given : bool
        Otherwise it was estimated from the recording.
    delay, delay_error : float
        By how much the readings lag, and its standard deviation, in samples.
    delay_is_known : bool
        Whether the delay was told, or that slips take a while, so that the readings do not lag.
    units : Units
    """

    whisker: Whisker
    guide: Guide
    parameters: tuple[Parameter, ...]
    noise: FloatArray
    noise_is_given: bool
    delay: float
    delay_is_known: bool
    units: Units
    delay_error: float = 0.0

    def started(self, slipped: Slipped) -> Fit:
        """Fit the contacts of what was given."""
        recording, spans = slipped.recording, slipped.spans
        blocks = condensed(recording, spans)
        step = speed_of(recording.clamp)
        ends = Ends(
            clamp=recording.clamp[spans.ends],
            gap=recording.clamp[spans.after] - recording.clamp[spans.ends],
            speed=step[spans.ends],
        )
        parameters = self.parameters
        if self.delay_error:
            name = "delay"
            late = Parameter(name=name, of=name, deviation=self.delay_error, stated=False)
            parameters = (*parameters, late)
        forward = Forward(
            whisker=self.whisker,
            parameters=parameters,
            blocks=blocks,
            speed=step[blocks.row.astype(int)],
            ends=ends,
            rows=len(recording),
            delay=self.delay,
        )
        used = self.guide.used
        noise = Noise(used=used, reading=self.noise[used], position=slipped.position)
        return started(forward, noise, self.guide)

    @property
    def lag_note(self) -> tuple[str, ...]:
        """Say by how much the readings lag."""
        if not self.delay:
            return ()
        low, high = self.delay - self.delay_error, self.delay + self.delay_error
        text = f"{low:.3g} to {high:.3g}" if self.delay_error else f"{self.delay:.3g}"
        return (f"the readings lag behind the clamp by {text} samples",)

    def lagging(self, found: Settling) -> "Model":
        """Let the readings lag as the slips show, or not at all: either is as likely."""
        if self.delay_is_known:
            return self
        half = 0.5 * found.delay
        return replace(self, delay=half, delay_error=half)

    def check_states(self, fit: Fit, slipped: Slipped) -> None:
        """Refuse a recording most of whose samples are no states of the rod, and tell why."""
        count = fit.forward.blocks.count
        squares = (fit.residuals**2).sum(axis=1) / count
        size = (self.guide.weighted(fit.forward.blocks.readings) ** 2).sum(axis=1)
        off = squares > np.maximum(MISFIT, MOST_MISFIT**2 * size)
        part = float(count[off].sum() / count.sum())
        if part <= MOST_OFF:
            return
        try:
            causes = causes_of(fit, self.goodness(fit))
        except NoResponseError:
            causes = ()
        likely = [one.spelled(self.units) for one in causes[:NAMED] if one.explained > EXPLAINS]
        first = slipped.recording.line[int(fit.forward.blocks.row[off][0])]
        text = (
            f"{part:.0%} of the samples are no state of this rod, first in line {first}: check "
            "rod, height, units, zero and noise"
        )
        raise WrongRodError(f"{text}. Likely: {', or '.join(likely)}" if likely else text)

    def goodness(self, fit: Fit) -> Goodness:
        """Test the recording as a whole."""
        return Goodness.of(fit, self.noise_is_given)


@dataclass(frozen=True, eq=False, kw_only=True)
class Modelled:
    """What the model of the rod reads from a recording.

    Attributes
    ----------
    fit : Fit
    slipped : Slipped
        The periods, without samples that have not settled.
    periods : Periods
    goodness : Goodness
    causes : tuple of Cause
        What may be other than it was given, the likeliest first; none where the recording fits.
    lag : Lag
    """

    fit: Fit
    slipped: Slipped
    periods: Periods
    goodness: Goodness
    causes: tuple[Cause, ...]
    lag: Lag


def read_model(model: Model, slipped: Slipped) -> Modelled:
    """Read the friction of the periods of a recording.

    Raises
    ------
    WrongRodError
        If most samples are no states of the rod.
    NoResponseError
        If the rod has no response.
    """
    start = model.started(slipped)
    model.check_states(start, slipped)
    together = _together(start, slipped)
    if together.any():
        slipped = slipped.joined(together)
        start = model.started(slipped)
    fit = fitted(start)
    if unsettled(fit, slipped.spans):
        middle = fitted(model.started(replace(slipped, spans=middles(slipped.spans))))
        found = settling(middle, slipped.recording, slipped.spans)
        if found.early or found.late:
            slipped = slipped.trimmed(found.early, found.late)
            model = model.lagging(found)
            fit = fitted(model.started(slipped))
    notes = (*slipped.recording.notes, *model.lag_note)
    slipped = replace(slipped, recording=replace(slipped.recording, notes=notes))
    goodness = model.goodness(fit)
    goodness = goodness.with_scatter(noise_of(slipped.recording.readings), model.noise)
    checks = [
        *checks_of_spans(slipped.clamp, slipped.spans),
        *_checks_of_fit(fit, slipped, goodness),
    ]
    return Modelled(
        fit=fit,
        slipped=slipped,
        periods=read_periods(fit, slipped).doubted(*checks),
        goodness=goodness,
        causes=() if goodness.fits else causes_of(fit, goodness),
        lag=Lag(delay=model.delay, error=model.delay_error),
    )


def _way(fit: Fit, slipped: Slipped) -> tuple[FloatArray, FloatArray]:
    """Way of the contact from each period to the next, in the direction of the clamp.

    Returns
    -------
    way, deviation : ndarray, shape (p − 1,)
        In L.
    """
    contact = fit.forward.contact(fit.p, fit.u, fit.heights)
    own = np.hypot(fit.known**-0.5, slipped.position)
    return np.diff(contact) * slipped.signs[:-1], np.hypot(own[1:], own[:-1])


def _together(fit: Fit, slipped: Slipped) -> BoolArray:
    """Tell after which periods the tip has not moved: no slip lies between.

    Past the lock a load may turn back, and samples may be missing.
    """
    way, deviation = _way(fit, slipped)
    same = (np.abs(way) < CERTAIN * deviation) & ~slipped.spans.passes[:-1]
    return np.append(same, False)


def _gains_energy(fit: Fit) -> BoolArray:
    """Tell after which periods the rod is bent more than before the slip, by the energy."""
    states, x0 = fit.forward.states(fit.p, fit.u, fit.heights)
    at = states.clip(x0)
    energy, push = states.energy(at), np.abs(states(at)[:, 0])
    after = fit.forward.blocks.starts[1:]
    error = CERTAIN * fit.known**-0.5 + np.abs(fit.forward.ends.gap)
    return np.asarray(energy[after] - energy[after - 1] > push[after] * error[1:])


def _checks_of_fit(fit: Fit, slipped: Slipped, goodness: Goodness) -> list[Check]:
    """Check whether the readings fit the rod, and the slips go with the clamp."""
    squares = fit.forward.blocks.sums(fit.residuals**2)
    worst, off = squares.argmax(axis=1), ~fit.fits_alone
    every = np.ones(len(off), dtype=bool)
    way, deviation = _way(fit, slipped)
    against = (way < CERTAIN * deviation) | _gains_energy(fit)
    backward = np.append(against & ~slipped.spans.passes[:-1], False)
    found = [
        Check(
            name="misfit",
            grade=Grade.WRONG,
            periods=off & (worst == number),
            sentence=f"{CHANNELS[channel]} does not fit a tip that stays where it is",
        )
        for number, channel in enumerate(fit.noise.used)
    ]
    found.append(
        Check(
            name="backward",
            grade=Grade.WRONG,
            periods=backward,
            sentence="no slip goes that way",
        )
    )
    found.append(
        Check(
            name="whole",
            grade=Grade.DOUBTFUL,
            periods=every & (not goodness.fits),
            sentence="the recording as a whole does not fit the rod",
        )
    )
    found.append(
        Check(
            name="not fitted",
            grade=Grade.DOUBTFUL,
            periods=every & (not fit.settled),
            sentence="the recording is too far from what was given to be fitted",
        )
    )
    found += [
        Check(
            name="far",
            grade=Grade.DOUBTFUL,
            periods=every,
            sentence=f"{one.name} ({one.surprise:.1f} standard deviations) is by the recording "
            "far from what was given, for its tolerance",
        )
        for one in far_of(fit)
    ]
    return found
