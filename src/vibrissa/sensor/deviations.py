"""Set-ups that deviate from the stated one, and the readings of a scan with such a set-up.

The stated set-up has tolerances. The true one deviates from it by one number for each
`vibrissa.sensor.identification.parameters.Parameter`, as `identify` fits them. Drawn from the
tolerances, such a number is a normal deviate with the tolerance as its standard deviation; a value
beyond the bounds of its parameter, such as a negative compliance, is mirrored at the bound. The
slope of the surface is random along the scan.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.interpolate import CubicSpline

from vibrissa.errors import ArgumentError
from vibrissa.numerics.arrays import FloatArray
from vibrissa.quantities.units import Quantity
from vibrissa.scanning.cycles import StageMaker
from vibrissa.scanning.scan import Scan
from vibrissa.scanning.surfaces import Surface
from vibrissa.scanning.textures import Texture, splined
from vibrissa.sensor.identification.derivatives import moved, scale_of
from vibrissa.sensor.identification.parameters import (
    SLOPE,
    Parameter,
    ScanRows,
    parameters_of,
)
from vibrissa.sensor.identification.slope import Slope
from vibrissa.sensor.identification.task import slope_length
from vibrissa.sensor.tolerances import assumed_tolerances, read_tolerances
from vibrissa.sensor.transducer import Transducer
from vibrissa.sensor.whisker import Whisker

TIP_RADIUS = "tip_radius"
# Number of waves that make a random slope.
WAVES = 40
# Number of points of the surface in the correlation length of its slope.
POINTS = 32
# Length of the surface before the clamp's first position and beyond its last one (L): the tip is
# not further away than the length of a rod.
BEYOND = 1.0


def drawn(
    deviation: FloatArray, low: FloatArray, high: FloatArray, generator: np.random.Generator
) -> FloatArray:
    """Draw normal deviates with given standard deviations, mirrored at their bounds."""
    deviates = generator.normal(0.0, deviation)
    deviates = np.where(deviates < low, 2.0 * low - deviates, deviates)
    return np.where(deviates > high, 2.0 * high - deviates, deviates)


class SlopeWaves(NamedTuple):
    """Waves that add up to a random slope: amplitude (rad), numbers (rad/L) and phases (rad)."""

    amplitude: float
    numbers: FloatArray
    phases: FloatArray


def slope_waves(slope: Slope, generator: np.random.Generator) -> SlopeWaves:
    """Draw waves whose sum has the covariance that `Slope` assumes.

    Wave numbers from the spectrum of the covariance, and random phases, add up to a Gaussian
    process as the number of waves grows.
    """
    return SlopeWaves(
        amplitude=slope.deviation * float(np.sqrt(2.0 / WAVES)),
        numbers=np.abs(generator.normal(0.0, 1.0 / slope.length, WAVES)),
        phases=generator.uniform(0.0, 2.0 * np.pi, WAVES),
    )


def sloped(
    slope: Slope, start: float, stop: float, level: float, generator: np.random.Generator
) -> Texture:
    """Draw the heights of a surface with a random slope.

    Parameters
    ----------
    start, stop : float
        Ends of the surface (L).
    level : float
        Place at which the height is 0 (L).
    """
    waves = slope_waves(slope, generator)
    x = np.linspace(start, stop, 1 + int(np.ceil((stop - start) / slope.length * POINTS)))

    def rise(place: FloatArray) -> FloatArray:
        parts = np.sin(place[:, None] * waves.numbers + waves.phases) / waves.numbers
        return np.asarray(waves.amplitude * parts.sum(axis=1))

    return splined(CubicSpline(x, rise(x) - rise(np.array([level]))))


@dataclass(frozen=True, kw_only=True)
class Deviations:
    """Deviations of the true set-up from the stated one.

    Attributes
    ----------
    parameters : tuple of Parameter
    size : ndarray, shape (k,)
        Deviation of each parameter.
    slope : Slope
        Standard deviation and correlation length of the random slope of the surface.
    """

    parameters: tuple[Parameter, ...]
    size: FloatArray
    slope: Slope

    @property
    def sizes(self) -> dict[str, float]:
        """Deviations by the names of their parameters."""
        names = (parameter.name for parameter in self.parameters)
        return dict(zip(names, self.size.tolist(), strict=True))


@dataclass(frozen=True, kw_only=True)
class Prior:
    """What is known of a set-up before a recording: the stated values and their tolerances.

    Attributes
    ----------
    whisker : Whisker
        The stated rod, in SI units.
    transducer : Transducer
    tolerances : mapping of str to float
        Standard deviations by name, as `identify` assumes them; without those that are 0.
    """

    whisker: Whisker
    transducer: Transducer
    tolerances: Mapping[str, float]

    @classmethod
    def of(cls, whisker: Whisker, transducer: Transducer, assume: bool = True) -> "Prior":
        """Collect the tolerances of a set-up; `assume`: the others have their defaults.

        Raises
        ------
        ArgumentError
            If the radius of the tip has a tolerance.
        """
        units = whisker.units
        if whisker.tolerances.get(TIP_RADIUS, 0.0):
            raise ArgumentError(
                f"recordings are simulated with a sharp tip: state no tolerance of {TIP_RADIUS}"
            )
        noise = transducer.deviation / units.channels
        assumed = assumed_tolerances(units, noise) if assume else {}
        return cls(
            whisker=whisker,
            transducer=transducer,
            tolerances={**assumed, **whisker.tolerances},
        )

    def slope(self, deviation: float) -> Slope:
        """Return a random slope of the surface with a standard deviation (rad)."""
        return Slope(deviation=deviation, length=slope_length(self.whisker.units))

    def _parameters(self, sizes: Mapping[str, float]) -> tuple[Parameter, ...]:
        full_scale = np.array(self.transducer.limit) / self.whisker.units.channels
        return parameters_of(sizes, frozenset(), full_scale, self.whisker)

    def draw(self, generator: np.random.Generator) -> Deviations:
        """Draw the deviations of a set-up within the tolerances."""
        parameters = self._parameters(self.tolerances)
        deviation, low, high = np.array(
            [(parameter.deviation, parameter.low, parameter.high) for parameter in parameters]
        ).T
        return Deviations(
            parameters=parameters,
            size=drawn(deviation, low, high, generator),
            slope=self.slope(self.tolerances.get(SLOPE, 0.0)),
        )

    def stated(self, errors: Mapping[str, Quantity]) -> Deviations:
        """Return deviations of given sizes, as in ``{"eta": "-0.1 mm"}``; all others are 0.

        The six parts of a crosstalk are equal, a drift is a line, and the size of `surface_slope`
        is the standard deviation of a random slope.

        Raises
        ------
        ArgumentError
            If a name or a size is not allowed.
        """
        stated = {}
        for name, written in errors.items():
            text = str(written).strip()
            size = read_tolerances(
                self.whisker.units, {name: text.removeprefix("-")}, self.whisker.values
            )[name]
            stated[name] = -size if text.startswith("-") else size
        parameters = self._parameters({})
        sizes = [
            stated.get(parameter.of, 0.0) if not parameter.wave else 0.0 for parameter in parameters
        ]
        for parameter, size in zip(parameters, sizes, strict=True):
            if size and not parameter.low <= size <= parameter.high:
                raise ArgumentError(
                    f"an error of {parameter.name} by {errors[parameter.of]} is not possible"
                )
        if (steep := stated.get(SLOPE, 0.0)) < 0.0:
            raise ArgumentError(f"the error of {SLOPE} must not be negative, got {steep:g} rad")
        return Deviations(parameters=parameters, size=np.array(sizes), slope=self.slope(steep))


class Moves(Protocol):
    """Scans over a surface, with all lengths in units of the true rod."""

    def __call__(self, make_stage: StageMaker, surface: Surface, scale: float) -> Scan:
        """Return the scan; the stage moves by `scale` times the steps that are stated."""
        ...


class Recorded(NamedTuple):
    """A scan with a true set-up, and what its transducer reads.

    Attributes
    ----------
    scan : Scan
        The scan, in units of the true rod.
    whisker : Whisker
        The true rod; its units are those of the stated one.
    scale : float
        True travel in lengths of the true rod, over stated travel in lengths of the stated one.
    readings : ndarray, shape (n, 3)
        Readings of force_x, force_y and moment_z in SI units.
    """

    scan: Scan
    whisker: Whisker
    scale: float
    readings: FloatArray


def recorded(
    prior: Prior,
    deviations: Deviations,
    surface: Surface,
    way: Sequence[float],
    moves: Moves,
    generator: np.random.Generator,
) -> Recorded:
    """Simulate a recording with a true set-up that deviates from the stated one.

    Parameters
    ----------
    surface : Surface
        Surface in units of the stated rod.
    way : sequence of float
        Least and largest position of the clamp (L), between which the slope of the surface is
        needed.
    moves : callable
        Moves the clamp; see `Moves`.
    generator : numpy.random.Generator
        Source of the slope of the surface and of the noise.

    Raises
    ------
    ArgumentError
        If the scan is not possible; see `vibrissa.scanning.cycles.move`.
    """
    size = deviations.sizes
    stated = prior.whisker
    length = 1.0 + size["length"]
    whisker = moved(stated, size)
    if deviations.slope.deviation:
        texture = sloped(
            deviations.slope,
            min(way) - BEYOND,
            max(way) + BEYOND,
            float(stated.curve.x1_init),
            generator,
        )
        own = surface.texture
        surface = surface.with_texture(texture if own is None else own + texture)
    scale = scale_of(size)
    scan = moves(whisker.stage, surface.in_lengths(length), scale)
    loads = scan.reactions * np.array([length**-2, length**-2, 1.0 / length])
    exact = transduced(deviations, loads) * stated.units.channels
    return Recorded(
        scan=scan,
        whisker=whisker,
        scale=scale,
        readings=prior.transducer.measured(exact, generator),
    )


def transduced(deviations: Deviations, loads: FloatArray) -> FloatArray:
    """Return what a transducer with errors reads of n loads, without noise, shape (n, 3).

    The loads scale with the stiffness of the rod; it creeps; the moment is that about the true
    origin; then the axes of the transducer turn, and crosstalk and zeros are added. Each effect is
    that of `Parameter.effect`, but a turn, and the power of the diameter, are exact.
    """
    size = deviations.sizes
    turn = size["transducer_angle"]
    axes = np.array(
        [[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    zeros = [parameter.of for parameter in deviations.parameters if parameter.of_zero]
    shown = loads * ((1.0 + size["modulus"]) * (1.0 + size["diameter"]) ** 4)
    shown = _with_effects(shown, deviations, ["creep"])
    shown = _with_effects(shown, deviations, ["moment_origin_x", "moment_origin_y"])
    shown = _with_effects(shown @ axes.T, deviations, ["crosstalk"])
    return _with_effects(shown, deviations, zeros)


def _with_effects(
    readings: FloatArray, deviations: Deviations, quantities: Sequence[str]
) -> FloatArray:
    """Add to n readings their change by the deviations of these quantities, shape (n, 3)."""
    rows = ScanRows.of(np.arange(len(readings)), len(readings))
    change = np.zeros_like(readings)
    for parameter, size in zip(deviations.parameters, deviations.size.tolist(), strict=True):
        if parameter.of in quantities and parameter.effect is not None and size:
            change = change + size * parameter.effect(readings, rows)
    return readings + change
