"""How a rod is made and mounted: its stiffness and natural curvature, its clamp and its stage.

The paper's mounting is *ideal*: clamp upright and rigid, rod straight, stage along the surface.
Other mountings may differ from it in four ways:

- The clamp is inclined by β: without load φ(0) = π/2 + β.
- The clamp yields to the moment of the rod: φ(0) grows by c·m(0).
- The rod is curved without load: B·(φ' − κ0(s)) = m.
- The stage moves at an angle δ to the surface, so that the height falls by x0·sin δ.

The paper's rod is solid and of one material. Other rods have a modulus that changes along them, or
a bore (`vibrissa.mechanics.taper.stiffness_factor`).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any, NamedTuple, Self

import numpy as np

from vibrissa.errors import ArgumentError
from vibrissa.limits import MOST_POWERS, check_bore, check_stiffening
from vibrissa.mechanics.taper import Making
from vibrissa.numerics.arrays import FloatArray
from vibrissa.numerics.spectral import gauss_rule

# Slope of the ideal clamp (rad).
CLAMP_SLOPE = np.pi / 2
# Number of Gauss nodes for the integration of a natural shape.
TAIL_NODES = 16
# Bound on the magnitudes of the clamp and stage angles (rad).
RIGHT_ANGLE = np.pi / 2


@dataclass(frozen=True, kw_only=True)
class Mounting:
    """Mounting of a rod: clamp, natural curvature, stiffness and stage; ideal by default.

    Attributes
    ----------
    clamp_angle : float
        Inclination β of the clamp against the normal of the surface (rad), positive
        counter-clockwise: the rod then leans back, against the motion of the clamp.
    clamp_compliance : float
        Rotational compliance c of the clamp, in L/(E·I0); not negative.
    curvature : float or tuple of float
        Natural curvature κ0·L of the rod: a constant, or the coefficients of the powers of s,
        lowest first. Where it is negative the rod turns away from the surface, towards +x.
    stiffening : float or tuple of float
        Change of Young's modulus along the rod, E(s)/E(0) = 1 + c1·s + c2·s² + …: c1, or the
        coefficients c1, c2, …. The modulus must be positive on the whole rod.
    bore : float
        Diameter of a bore, the same along the rod (d0): below 1/θ, the diameter of the tip.
    stage_angle : float
        Angle δ between the clamp's path and the surface (rad); positive if the clamp approaches the
        surface.

    Raises
    ------
    ArgumentError
        If a value is out of range.

    Examples
    --------
    >>> Mounting(clamp_angle=np.radians(2)).is_ideal_rod
    False
    >>> Mounting(curvature=[-0.1, 0.3]).coefficients
    (-0.1, 0.3)
    >>> Mounting(stiffening=0.15).making.powers
    (0.15,)
    """

    clamp_angle: float = 0.0
    clamp_compliance: float = 0.0
    curvature: float | tuple[float, ...] = 0.0
    stiffening: float | tuple[float, ...] = 0.0
    bore: float = 0.0
    stage_angle: float = 0.0

    def __post_init__(self) -> None:
        """Check all values."""
        for name in ("clamp_angle", "stage_angle"):
            value = _number(name, getattr(self, name))
            if not abs(value) < RIGHT_ANGLE:
                raise ArgumentError(f"{name} must lie between -pi/2 and pi/2 (rad), got {value!r}")
        compliance = _number("clamp_compliance", self.clamp_compliance)
        if compliance < 0.0:
            raise ArgumentError(
                f"clamp_compliance must not be negative, got {compliance!r} L/(E I0)"
            )
        # Lists and arrays become tuples.
        for name in ("curvature", "stiffening"):
            object.__setattr__(self, name, _listed(name, getattr(self, name)))
            for value in _tupled(getattr(self, name)):
                _number(name, value)
        check_stiffening(_tupled(self.stiffening))
        check_bore(_number("bore", self.bore), 1.0)

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Coefficients of κ0·L, lowest power first."""
        return _tupled(self.curvature)

    @property
    def making(self) -> Making:
        """Bore, and coefficients of the modulus along the rod."""
        return Making(bore=self.bore, powers=_tupled(self.stiffening))

    def shifted(self, **steps: float) -> Self:
        """Add to some values; of a polynomial, to its first coefficient."""
        shifted: dict[str, Any] = {}
        for name, step in steps.items():
            first, *others = np.atleast_1d(getattr(self, name)).tolist()
            shifted[name] = (first + step, *others) if others else first + step
        return replace(self, **shifted)

    @property
    def is_solid(self) -> bool:
        """Whether the rod is solid and of one material, as in the paper."""
        return not (self.bore or any(_tupled(self.stiffening)))

    @property
    def is_ideal_rod(self) -> bool:
        """Whether the clamp is upright and rigid and the rod straight."""
        return not (self.clamp_angle or self.clamp_compliance or any(self.coefficients))

    @property
    def is_ideal(self) -> bool:
        """Whether `is_ideal_rod` holds and the stage moves along the surface, as in the paper."""
        return self.is_ideal_rod and self.stage_angle == 0.0


def _number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, Real) or not np.isfinite(float(value)):
        unit = " (rad)" if name.endswith("angle") else ""
        raise ArgumentError(f"{name} must be a finite number{unit}, got {value!r}")
    return float(value)


def _tupled(polynomial: float | tuple[float, ...]) -> tuple[float, ...]:
    return polynomial if isinstance(polynomial, tuple) else (polynomial,)


def _listed(name: str, polynomial: object) -> object:
    if isinstance(polynomial, Real):
        return polynomial
    # An array of dimension 0 is no list.
    is_list = isinstance(polynomial, Iterable) and getattr(polynomial, "ndim", True)
    values: list[object] = list(polynomial) if is_list else []  # type: ignore[call-overload]
    if not values:
        raise ArgumentError(f"{name} must be a number or a list of numbers, got {polynomial!r}")
    first, *powers = values
    while powers and powers[-1] == 0:
        powers.pop()
    return (first, *powers) if powers else first


IDEAL = Mounting()
# Columns of `rod_columns`: the coefficients of κ0 come last, as many as there are.
THETA, CLAMP_ANGLE, CLAMP_COMPLIANCE, BORE = range(4)
POWERS = slice(4, 4 + MOST_POWERS)
CURVATURE = slice(POWERS.stop, None)


def rod_columns(theta: FloatArray, mountings: Sequence[Mounting]) -> FloatArray:
    """Tabulate the properties of n rods.

    Returns
    -------
    ndarray, shape (n, 12 + k)
        θ, β (rad), c (L/(E·I0)), the bore (d0), eight coefficients of the modulus, and k
        coefficients of κ0 in each row; k = 0 if all rods are straight.
    """
    count = max((len(one.coefficients) for one in mountings if any(one.coefficients)), default=0)
    columns = np.zeros((len(mountings), CURVATURE.start + count))
    columns[:, THETA] = theta
    for row, one in zip(columns, mountings, strict=True):
        row[CLAMP_ANGLE], row[CLAMP_COMPLIANCE] = one.clamp_angle, one.clamp_compliance
        row[BORE] = one.bore
        row[POWERS.start : POWERS.start + len(one.making.powers)] = one.making.powers
        if any(one.coefficients):
            row[CURVATURE.start : CURVATURE.start + len(one.coefficients)] = one.coefficients
    return columns


class Tail(NamedTuple):
    """Ends of naturally shaped parts of rods, as seen from their beginnings.

    Attributes
    ----------
    along, up : ndarray, shape (n, points)
        Position of the end, along the tangent at the beginning and normal to it (L).
    turn : ndarray, shape (n, points)
        Slope at the end minus slope at the beginning (rad).
    """

    along: FloatArray
    up: FloatArray
    turn: FloatArray


def tail(curvature: FloatArray, start: FloatArray, stop: FloatArray) -> Tail:
    """Natural shapes of n rods from `start` to `stop`, as seen from `start`.

    Parameters
    ----------
    curvature : ndarray, shape (n, k)
        Coefficients of κ0 (1/L), lowest power of s first.
    start, stop : ndarray, shape (n, points)
        Arc lengths at the beginning and at the end of each shape (L).
    """
    integral = curvature / np.arange(1, curvature.shape[1] + 1)
    begin, length = start * polynomial(integral, start), stop - start
    rule = gauss_rule(TAIL_NODES)
    # 1 − cos is integrated, so that a straight rod stays straight exactly.
    shortening, up = np.zeros_like(length), np.zeros_like(length)
    for node, weight in zip(rule.nodes, rule.weights, strict=True):
        s = start + node * length
        turn = s * polynomial(integral, s) - begin
        shortening += weight * 2.0 * np.sin(0.5 * turn) ** 2
        up += weight * np.sin(turn)
    turn = stop * polynomial(integral, stop) - begin
    return Tail(along=length * (1.0 - shortening), up=length * up, turn=turn)


def polynomial(coefficients: FloatArray, s: FloatArray) -> FloatArray:
    """Evaluate n polynomials, each at its own row of `s`, shape (n, points).

    Parameters
    ----------
    coefficients : ndarray, shape (n, k)
        Coefficients, lowest power first.
    """
    value = np.zeros_like(s)
    for coefficient in coefficients.T[::-1]:
        value = value * s + coefficient[:, None]
    return value
