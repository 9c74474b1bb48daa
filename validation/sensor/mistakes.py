"""Set-up errors of a bench.

A laboratory states a set-up: the rod, its height, an upright and rigid clamp, a level surface, a
transducer whose axes are those of the stage. The true set-up differs by one error, or by all at
once. Sizes are in units of the rod, in rad, or relative to a value. They are drawn by the code that
draws them in studies of the sensor; what they do to a recording is the bench's own.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from validation.sensor.bench import Bench, Friction, crosstalk, moved, stiffer, turned
from vibrissa.sensor.deviations import drawn, slope_waves
from vibrissa.sensor.identification.slope import Slope

# The rod: E (Pa), diameter and length (m), taper; units of its loads (N, N, N·m).
MODULUS, DIAMETER, LENGTH, THETA = 2.1e11, 1e-3, 0.1, 2.0
_STIFFNESS = MODULUS * np.pi * DIAMETER**4 / 64.0
UNITS = np.array([_STIFFNESS / LENGTH**2, _STIFFNESS / LENGTH**2, _STIFFNESS / LENGTH])
# Largest loads of a scan, to which crosstalk is relative.
FULL_SCALE = np.array([0.6, 1.9, 0.48])
# Correlation length of the slope of a surface (L).
SLOPE_LENGTH = 0.05


@dataclass(frozen=True, kw_only=True)
class Mistake:
    """A set-up error.

    Attributes
    ----------
    made : callable
        Maps a bench and the sizes of the error's parts to the bench with the error.
    parts : int
        Number of independent parts of the error.
    positive : bool
        Whether the error cannot be negative.
    """

    made: Callable[[Bench, np.ndarray], Bench]
    parts: int = 1
    positive: bool = False

    def fixed(self, bench, size):
        """Return the bench with an error of a given size."""
        return self.made(bench, np.full(self.parts, abs(size) if self.positive else size))

    def drawn(self, bench, deviation, generator):
        """Return the bench with an error whose size is drawn as studies of the sensor draw it."""
        low = np.full(self.parts, 0.0 if self.positive else -np.inf)
        high = np.full(self.parts, np.inf)
        return self.made(bench, drawn(np.full(self.parts, deviation), low, high, generator))


def _of_rod(name):
    def made(bench, sizes):
        value = getattr(bench.rod, name) + float(sizes[0])
        return replace(bench, rod=replace(bench.rod, **{name: value}))

    return made


def _of_bench(name):
    def made(bench, sizes):
        return replace(bench, **{name: getattr(bench, name) + float(sizes[0])})

    return made


def _of_loads(matrix):
    """Return the error that multiplies the transducer's readings by a matrix."""

    def made(bench, sizes):
        return replace(bench, transducer=matrix(*sizes.tolist()) @ bench.transducer)

    return made


def _of_zero(name, channel):
    def made(bench, sizes):
        return replace(bench, **{name: getattr(bench, name) + sizes[0] * np.eye(3)[channel]})

    return made


def _inclined(bench, sizes):
    """Incline the surface against clamp, stage and transducer."""
    return replace(bench, incline=bench.incline + float(sizes[0]))


def _oblique(bench, sizes):
    """Turn the stage alone against surface, clamp and transducer."""
    (angle,) = sizes.tolist()
    rod = replace(bench.rod, clamp_angle=bench.rod.clamp_angle - angle)
    return replace(
        bench, rod=rod, incline=bench.incline + angle, transducer=turned(-angle) @ bench.transducer
    )


def _wavy(bench, sizes):
    """Make the surface's slope a wave with this root mean square, nearly constant over 5 mm."""
    (size,) = sizes.tolist()
    return replace(bench, slope=np.sqrt(2.0) * size, slope_phase=bench.friction.phase + 1.0)


def random_slope(bench, deviation, generator):
    """Make the surface's slope random, with the waves of a study of the sensor."""
    waves = slope_waves(Slope(deviation=deviation, length=SLOPE_LENGTH), generator)
    return replace(
        bench,
        slope=np.full(len(waves.numbers), waves.amplitude),
        slope_length=2.0 * np.pi / waves.numbers,
        slope_phase=waves.phases,
    )


def _longer(bench, sizes):
    """Make the rod longer: the bench has the units of the true rod, readings those stated."""
    ratio = 1.0 + float(sizes[0])
    return replace(
        bench,
        eta=bench.eta / ratio,
        scale=(1.0 + bench.scale) / ratio - 1.0,
        friction=replace(bench.friction, length=bench.friction.length / ratio),
        slope_length=bench.slope_length / ratio,
        transducer=bench.transducer @ np.diag([ratio**-2, ratio**-2, ratio**-1]),
    )


def _mixed(*sizes):
    parts = np.zeros((3, 3))
    for (to, source), size in zip(permutations(range(3), 2), sizes, strict=True):
        parts[to, source] = size * FULL_SCALE[to] / FULL_SCALE[source]
    return crosstalk(parts)


# Errors by the names of their tolerances.
MISTAKES = {
    "theta": Mistake(made=_of_rod("theta")),
    "eta": Mistake(made=_of_bench("eta")),
    "clamp_angle": Mistake(made=_of_rod("clamp_angle")),
    "clamp_compliance": Mistake(made=_of_rod("compliance"), positive=True),
    "curvature": Mistake(made=_of_rod("curvature")),
    "stage_angle": Mistake(made=_oblique),
    "surface_slope": Mistake(made=_wavy),
    "modulus": Mistake(made=_of_loads(stiffer)),
    "diameter": Mistake(made=_of_loads(lambda part: stiffer((1.0 + part) ** 4 - 1.0))),
    "length": Mistake(made=_longer),
    "tip_radius": Mistake(made=_of_rod("radius"), positive=True),
    "zero_force_x": Mistake(made=_of_zero("zero", 0)),
    "zero_force_y": Mistake(made=_of_zero("zero", 1)),
    "zero_moment_z": Mistake(made=_of_zero("zero", 2)),
    "drift_force_x": Mistake(made=_of_zero("drift", 0)),
    "drift_force_y": Mistake(made=_of_zero("drift", 1)),
    "drift_moment_z": Mistake(made=_of_zero("drift", 2)),
    "transducer_angle": Mistake(made=_of_loads(turned)),
    "crosstalk": Mistake(made=_of_loads(_mixed), parts=6),
    "moment_origin_x": Mistake(made=_of_loads(lambda x: moved(x, 0.0))),
    "moment_origin_y": Mistake(made=_of_loads(lambda y: moved(0.0, y))),
    "stage_scale": Mistake(made=_of_bench("scale")),
    "creep": Mistake(made=_of_bench("creep")),
}
# A single cause that amounts to several of these errors.
SURFACE = Mistake(made=_inclined)


def bench_of(seed):
    """Return a bench without errors, on a surface whose friction varies slowly about 0.30."""
    phase = np.random.default_rng([seed, 1]).uniform(0.0, 2.0 * np.pi)
    return Bench(friction=Friction(mean=0.3, wave=0.02, length=0.3, phase=phase))


def everything(bench, deviations: Mapping[str, float], generator):
    """Return the bench with all errors at once, each drawn with its standard deviation.

    The slope is random along the surface.
    """
    deviations = dict(deviations)
    bench = random_slope(bench, deviations.pop("surface_slope", 0.0), generator)
    # The length comes last: it changes the units, and thereby rescales all other values.
    for name in sorted(deviations, key=lambda name: name == "length"):
        bench = MISTAKES[name].drawn(bench, deviations[name], generator)
    return bench
