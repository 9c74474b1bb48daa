"""The rod as an initial value problem."""

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import reference
from vibrissa.mechanics.elastica import deformed_shape


def test_cylinder_follows_the_elliptic_elastica():
    # With k the modulus, cos(phi) = 2·k·cn(K(1-s))·dn(...) has no simple primitive, but the slope
    # itself is closed: sin((pi/2 - phi)/2) = k·sn(K·s) for the clamped-free column.
    modulus = 0.4
    eta, f, x1 = reference.elastica(modulus)
    s = np.linspace(0.0, 1.0, 21)
    x, y, phi = deformed_shape(1.0, f, 0.0, x1, eta, s)
    sn = ellipj(ellipk(modulus**2) * s, modulus**2)[0]
    assert phi == pytest.approx(np.pi / 2 - 2 * np.arcsin(modulus * sn), abs=1e-10)
    assert (x[-1], y[-1]) == pytest.approx((x1, eta), abs=1e-10)
