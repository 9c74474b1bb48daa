"""Reference solutions that share no code with the package.

A state is shot from the contact point to the clamp with DOP853 at 1e-13, in its own formulation:
the moment and slope at the contact point are known, the clamp conditions are met by a root search.
"""

import math

import numpy as np
from scipy.integrate import ode
from scipy.optimize import root
from scipy.special import ellipe, ellipk

TOLERANCE = 1e-13


def derivative(r, state, theta, s_c, p, q):
    """Change with r = s_c - s, the distance from the contact point, which is the origin."""
    _, _, phi, m = state
    d = 1 - (1 - 1 / theta) * (s_c - r)
    cos, sin = math.cos(phi), math.sin(phi)
    return [-cos, -sin, -m / d**4, -(p * cos + q * sin)]


def integrated(theta, s_c, phi1, p, q, r):
    """Integrate from the contact point s_c under the force (q, -p); states at growing r."""
    # The compiled DOP853: `solve_ivp` has the method in Python, and takes five times as long.
    solver = ode(derivative).set_integrator("dop853", rtol=TOLERANCE, atol=TOLERANCE, nsteps=10_000)
    solver.set_initial_value([0.0, 0.0, phi1, 0.0]).set_f_params(theta, s_c, p, q)
    states = [solver.y if at == 0.0 else solver.integrate(at) for at in r]
    return np.transpose(states)


def shoot(theta, s_c, phi1, p, q):
    """Integrate from the contact point s_c to the clamp under the force (q, -p)."""
    x, y, phi, m = integrated(theta, s_c, phi1, p, q, [s_c])[:, -1]
    # Offset of the tip, which lies 1 - s_c further on, height, clamp slope and clamp moment
    return -x + 1 - s_c, -y, phi, m


def shoot_from_contact(theta, phi1, p, q):
    """Point contact: the tip touches with slope phi1."""
    return shoot(theta, 1.0, phi1, p, q)


def shoot_from_line(theta, s_c, p, q):
    """Line contact: the rod is tangential at s_c."""
    return shoot(theta, s_c, 0.0, p, q)


def solve_offset(theta, eta, offset, guess):
    """State with a given offset of the contact point; guess and result are (phi1, p, q)."""

    def misfit(unknowns):
        x, y, phi, _ = shoot_from_contact(theta, *unknowns)
        return [x - offset, y - eta, phi - np.pi / 2]

    return _root(misfit, guess)


def solve_inclination(theta, eta, tan_alpha, guess):
    """State with a given force inclination; guess and result are (phi1, p)."""

    def misfit(unknowns):
        phi1, p = unknowns
        _, y, phi, _ = shoot_from_contact(theta, phi1, p, p * tan_alpha)
        return [y - eta, phi - np.pi / 2]

    return _root(misfit, guess)


def onset(theta, mu0, eta, first_guess, slip_guess):
    """Exact x0_slip: difference of the offsets at alpha = 0 and at tan(alpha) = -mu0."""
    phi1, p = solve_inclination(theta, eta, 0.0, first_guess)
    x1_init = shoot_from_contact(theta, phi1, p, 0.0)[0]
    phi1, p = solve_inclination(theta, eta, -mu0, slip_guess)
    return x1_init - shoot_from_contact(theta, phi1, p, -mu0 * p)[0]


def solve_line_offset(theta, eta, offset, guess):
    """Line contact with a given offset of the tip; guess and result are (s_c, p, q)."""

    def misfit(unknowns):
        x, y, phi, _ = shoot_from_line(theta, *unknowns)
        return [x - offset, y - eta, phi - np.pi / 2]

    return _root(misfit, guess)


def elastica(modulus):
    """Closed form of the cylinder at alpha = 0 by its modulus k: (eta, f, x1)."""
    k, e = ellipk(modulus**2), ellipe(modulus**2)
    return 2 * e / k - 1, k**2, 2 * modulus / k


def _root(misfit, guess):
    result = root(misfit, guess, method="hybr", options={"xtol": 1e-14})
    assert np.abs(misfit(result.x)).max() < 1e-12
    return result.x
