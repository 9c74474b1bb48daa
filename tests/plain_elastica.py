"""A whisker by SciPy's boundary value solver, and its slips: shares no code with the package.

Everything is in units of the rod. The clamp is at the origin, the surface at the height η above it.
The load of the rod on the clamp is the force (fx, fy) of the surface on its tip.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_bvp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

# Unit of force of a steel rod, 1 mm thick and 100 mm long (N).
FORCE = 210e9 * np.pi / 64 * 1e-3**4 / 0.1**2


@dataclass(frozen=True)
class Rod:
    """Forces (fx, fy) over the clamp displacement x0 from the state without tangential force."""

    forces: CubicSpline

    def demand(self, x0):
        fx, fy = self.forces(x0)
        return fx / fy


def rod(theta, eta, most, tilt=0.0, curvature=0.0):
    """Solve a rod up to x0 = `most`, its clamp tilted back, with a natural curvature."""

    def equations(s, y, fx, fy):
        phi, _, _, moment = y
        stiffness = (1.0 - (1.0 - 1.0 / theta) * s) ** 4
        along, across = np.cos(phi), np.sin(phi)
        return np.stack([moment / stiffness + curvature, along, across, across * fx - along * fy])

    def ends(a, b):
        return [a[0] - np.pi / 2 - tilt, a[1], a[2], b[3], b[2] - eta]

    s = np.linspace(0.0, 1.0, 41)
    guess = np.stack([np.pi / 2 - 1.2 * s, 0.4 * s**2, eta * s, -(1.0 - s)])
    free = solve_bvp(
        lambda s, y, p: equations(s, y, 0.0, p[0]), ends_with(ends), s, guess, [-1.2], tol=1e-8
    )
    assert free.success and free.y[1, -1] > 0.2
    x0, forces = np.linspace(0.0, most, 41), []
    mesh, y, p = free.x, free.y, np.array([0.0, free.p[0]])
    for each in x0:
        found = solve_bvp(
            lambda s, y, p: equations(s, y, *p),
            lambda a, b, p, each=each: np.array([*ends(a, b), b[1] - free.y[1, -1] + each]),
            mesh,
            y,
            p,
            tol=1e-8,
        )
        assert found.success
        mesh, y, p = found.x, found.y, found.p
        forces.append(p)
    return Rod(CubicSpline(x0, forces))


def ends_with(ends):
    return lambda a, b, p: np.array(ends(a, b))


def slips(rod, mu0, positions, ratio):
    """Push a tip over friction mu0(x), with slips that end at kinetic friction.

    Returns the forces in each position, shape (n, 2), and friction and number of the period.
    """
    place = 0.0  # of the clamp in the state x0 = 0 of this contact
    forces, friction, period = [], [], []
    number = 0
    for clamp in positions:
        x0 = clamp - place
        if rod.demand(x0) > mu0(place):
            number += 1
            goal = brentq(lambda x, at=clamp: rod.demand(x) - ratio * mu0(at - x), 0.0, x0)
            x0, place = goal, clamp - goal
        forces.append(rod.forces(x0))
        friction.append(mu0(place))
        period.append(number)
    return np.array(forces), np.array(friction), np.array(period)
