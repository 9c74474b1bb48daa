"""The onset of slip of a whisker, in the units of its rod, and the largest strain up to it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibrissa.mechanics.bending import Bending, measure
from vibrissa.outcomes import End, Status
from vibrissa.quantities.series import Column, Tabular
from vibrissa.quantities.units import Kind, Quantity
from vibrissa.sensor.ringing import DAMPING, OVER, Ringing, ringing_of
from vibrissa.sensor.whisker import Whisker
from vibrissa.sticking.api import onset_on
from vibrissa.sticking.curve import StickingCurve
from vibrissa.sticking.results import Onset

# Number of states of a period, both ends included, among which the largest strain is sought.
STATES_OF_PERIOD = 17


def strains_in(curves: Sequence[StickingCurve], x0: Sequence[ArrayLike]) -> Bending:
    """Measure the bending on each curve, at its own displacements in `x0` (L).

    All curves have the same mounting. Rows of the result are ordered by curve, then as in `x0`.
    """
    rows = []
    for curve, at in zip(curves, x0, strict=True):
        state = curve.state(at)
        x1, height = curve.contact_point(at)
        contact = x1 - (1.0 - state.s_c)
        values = (curve.theta, state.f, state.alpha, contact, height, state.s_c)
        rows.append(np.broadcast_arrays(*(np.atleast_1d(value) for value in values)))
    theta, f, alpha, x_c, y_c, s_c = np.concatenate(rows, axis=1)
    return measure(theta, f, alpha, x_c, y_c, s_c, curves[0].mounting)


def largest_strain(curve: StickingCurve, end: float, begin: float = 0.0) -> Bending:
    """Find the state of largest stress from x0 = `begin` to `end` (L); return its bending."""
    bending = strains_in([curve], [np.linspace(begin, end, STATES_OF_PERIOD)])
    return bending.take(np.atleast_1d(bending.stress.argmax()))


class _Shown(NamedTuple):
    """A quantity as it is shown: its column, nondimensional value, kind, and description."""

    name: str
    value: float
    kind: Kind
    what: str


@dataclass(frozen=True, eq=False, kw_only=True)
class WhiskerOnset(Tabular):
    """Onset of slip of a whisker, in the units of its rod.

    Attributes
    ----------
    onset : Onset
        Nondimensional onset of slip.
    most : Bending or None
        Largest strain in the period of sticking, and its place; None if the tip does not slip.
    whisker : Whisker
    ringing : Ringing or None
        Vibrations in Hz and s; None if the tip does not slip, or without a size or a density.
    """

    onset: Onset
    most: Bending | None
    whisker: Whisker
    ringing: Ringing | None = None

    def __repr__(self) -> str:
        """Return a line for each known quantity, in the user's units."""
        onset = self.onset
        units = self.whisker.units
        lines = {
            "status": onset.status.value,
            "meaning of the status": onset.message,
            "critical friction, mu_lock": f"{onset.mu_lock:.8g}",
        }
        lines |= {shown.what: units.spelled(shown.value, shown.kind, 8) for shown in self._known()}
        width = max(map(len, lines)) + 2
        return "\n".join(f"{what:<{width}}{text}" for what, text in lines.items())

    def columns(self) -> dict[str, Column]:
        """Columns of a table with one row: the onset of slip, or else lateral buckling."""
        onset = self.onset
        units = self.whisker.units
        return {
            "status": Column([onset.status.value], "", "status"),
            "message": Column([onset.message], "", "meaning of the status"),
            "mu_lock": Column([onset.mu_lock], "1", "critical friction, mu_lock"),
        } | {
            shown.name: Column(
                [shown.value * units.unit(shown.kind)], units.name(shown.kind), shown.what
            )
            for shown in self._known()
        }

    def _known(self) -> list[_Shown]:
        """Quantities whose value is known."""
        return [shown for shown in self._quantities() if np.isfinite(shown.value)]

    def _quantities(self) -> Iterator[_Shown]:
        """All quantities; unknown values are NaN."""
        onset = self.onset
        state = self.onset.slip
        when = ""
        if onset.end == End.SWINGS_ASIDE:
            state, when = onset.trail, " when the trailing tip slips"
            yield _Shown(
                "x0_swing", onset.ended.x0, Kind.LENGTH, "clamp travel at lateral buckling, x0"
            )
            yield _Shown("x0_trail", state.x0, Kind.LENGTH, f"clamp travel{when}")
        elif onset.status is Status.SLIP:
            yield _Shown(
                "x0_slip", onset.x0_slip, Kind.LENGTH, "clamp travel at the onset of slip, x0"
            )
        else:
            return
        yield _Shown("force_x", state.reaction_fx, Kind.FORCE, f"tangential clamp force{when}")
        yield _Shown("force_y", state.reaction_fy, Kind.FORCE, f"normal clamp force{when}")
        yield _Shown("moment_z", state.reaction_m, Kind.MOMENT, f"clamp moment{when}")
        if onset.n_steps is not None and not when:
            yield _Shown(
                "x0_max", onset.x0_max, Kind.LENGTH, "clamp travel at the last sticking step"
            )
        if self.most is not None:
            strain, place = self.most.strain[0], self.most.place[0]
            yield _Shown("strain_most", strain, Kind.STRAIN, "largest strain while sticking")
            yield _Shown(
                "strain_place", place, Kind.LENGTH, "place of the largest strain, from the clamp"
            )
        if self.ringing is not None:
            first, second = self.ringing.frequencies
            yield _Shown("frequency_1", first, Kind.RATE, "first natural frequency at the onset")
            yield _Shown("frequency_2", second, Kind.RATE, "second natural frequency at the onset")
            yield _Shown("slip_time", self.ringing.slip, Kind.TIME, "duration of a slip, about")
            ring = f"ringing after a slip, to {OVER:.0%} at a damping ratio of {DAMPING:g}"
            yield _Shown("ring_time", self.ringing.ring, Kind.TIME, ring)


def solve(
    whisker: Whisker, mu0: Quantity, step: Quantity | None = None, density: float | None = None
) -> WhiskerOnset:
    """Solve for the end of one period of sticking; the result prints in the user's units.

    Parameters
    ----------
    whisker : Whisker
    mu0 : str or number
        Coefficient of static friction.
    step : str or number, optional
        Step of the stage; without it, the last step at which the tip sticks is not known.
    density : float, optional
        Density of the rod (kg/m³); without it, its natural frequencies in Hz are not known.

    Returns
    -------
    WhiskerOnset
        If the tip is self-locking, this is no error: the status of `onset` is ``lock``.

    Raises
    ------
    ArgumentError
        If an argument is out of range.

    Examples
    --------
    >>> from vibrissa.sensor import Setup
    >>> steel = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
    >>> onset = solve(Setup.read(theta=2, eta="85 mm", **steel).whisker, mu0=0.4, step="20 um")
    >>> print(onset.onset.status, f"{onset.onset.x0_slip:.6f} L")
    slip 0.052838 L
    """
    units = whisker.units
    dx0 = None if step is None else units.read_positive(step, Kind.LENGTH, "step")
    friction = units.read_positive(mu0, Kind.NUMBER, "mu0")
    onset = onset_on(whisker.curve, friction, dx0, lambda x0: units.spelled(x0, Kind.LENGTH))
    slips = onset.status is Status.SLIP
    most = largest_strain(whisker.curve, onset.x0_slip) if slips else None
    rings = ringing_of(whisker, onset.x0_slip, density) if slips else None
    return WhiskerOnset(onset=onset, most=most, whisker=whisker, ringing=rings)
