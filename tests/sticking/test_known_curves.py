"""Whole curves: no number of them changes unnoticed.

That they are right is tested elsewhere, against other methods.
"""

import numpy as np
import pytest

from known import WITHIN, Known
from vibrissa import Mounting, solve_curve
from vibrissa.outcomes import Status

KNOWN = Known(__file__)
TOGETHER = Mounting(
    clamp_angle=-0.05, clamp_compliance=0.1, curvature=(-0.1, -0.2), stage_angle=0.05
)
CASES = {
    "cylinder": {"theta": 1.0, "eta": 0.85},
    "paper": {"theta": 2.0, "eta": 0.85},
    "strong taper": {"theta": 4.0, "eta": 0.7},
    "very strong taper": {"theta": 12.0, "eta": 0.8},
    "lies down": {"theta": 3.0, "eta": 0.8, "contact": "line"},
    "lies from the start": {"theta": 3.0, "eta": 0.7, "contact": "line"},
    "planar": {"theta": 2.0, "eta": 0.85, "section": "planar"},
    "planar and lies down": {"theta": 3.0, "eta": 0.85, "contact": "line", "section": "planar"},
    "low": {"theta": 1.5, "eta": 0.35},
    "dips": {"theta": 1.0, "eta": 0.3126},
    "dips and is planar": {"theta": 1.0, "eta": 0.3126, "section": "planar"},
    "crosses itself": {"theta": 2.489, "eta": 0.3042, "section": "planar"},
    "crosses itself before it locks": {"theta": 2.0, "eta": 0.15, "section": "planar"},
    "nearly upright": {"theta": 1.5, "eta": 0.98},
    "leans back": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(clamp_angle=0.1)},
    "yields": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(clamp_compliance=0.2)},
    "curved": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(curvature=(0.05, 0.1, -0.5))},
    "oblique": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(stage_angle=0.1)},
    "mounted": {"theta": 3.0, "eta": 0.8, "contact": "line", "mounting": TOGETHER},
    "mounted and planar": {"theta": 2.0, "eta": 0.85, "mounting": TOGETHER, "section": "planar"},
    "swings before its lock": {"theta": 25.0, "eta": 0.93},
    "does not swing before its lock": {"theta": 25.0, "eta": 0.93, "section": "planar"},
    "lifts off": {"theta": 1.0, "eta": 0.18},
    "lifts off in its plane": {"theta": 1.0, "eta": 0.18, "section": "planar"},
    "far away": {"theta": 3.1, "eta": 0.25},
    "very far away": {"theta": 20.0, "eta": 0.3, "contact": "line"},
    "locks in a kink": {"theta": 2.3877, "eta": 0.8215, "contact": "line"},
    "slips back": {"theta": 3.0, "eta": 0.7, "contact": "line", "section": "planar"},
    "cylinder that lies down": {"theta": 1.0, "eta": 0.7, "contact": "line", "section": "planar"},
    "leaves the surface": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(stage_angle=-0.1)},
    "towards the surface": {
        **{"theta": 2.5, "eta": 0.85, "contact": "line"},
        "mounting": Mounting(curvature=0.2),
    },
    "mounted, swings before its lock": {
        **{"theta": 3.8, "eta": 0.79},
        "mounting": Mounting(clamp_angle=-0.48, curvature=(1.1, 1.1)),
    },
    "leaves its plane": {
        **{"theta": 2.3, "eta": 0.85},
        "mounting": Mounting(clamp_angle=0.06, curvature=(1.13, 1.34)),
    },
    "springs": {"theta": 4.0, "eta": 0.95, "mounting": Mounting(curvature=2.0)},
    "leaves": {"theta": 2.0, "eta": 0.85, "mounting": Mounting(curvature=-2.0)},
}


def seen(curve):
    """What one can ask of a curve."""
    result = {
        name: getattr(curve, name)
        for name in (
            *("status", "message", "end", "end_message", "method", "section", "x1_init"),
            *("x0_lock", "mu_lock", "x0_touch", "x0_end"),
        )
    }
    if not curve.pieces:
        return result
    x0 = np.array([0.0, 0.123, 0.456, 0.789, 1.0]) * curve.x0_end
    lock = curve.mu_lock if np.isfinite(curve.mu_lock) else 1.0
    result |= {
        "states": curve.state(x0),
        "contact": " ".join(curve.contact(x0)),
        "onsets": curve.onset(lock * np.array([0.01, 0.5, 0.99])),
    }
    if curve.pulled:
        result["pulled"] = curve.state(0.9 * curve.x0_pull * np.array([1.0, 0.7, 0.2]))
        result["trails"] = curve.trailing_end(lock * np.array([1.001, 1.2, 2.0]))
    if curve.status is Status.SOLVED and np.isfinite(curve.mu_lock):
        result["past"] = curve.motion_end(lock * np.array([1.001, 1.5, 4.0]))
    return result


SLOW = ("springs", "crosses itself", "crosses itself before it locks", "very far away")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in CASES]
)
def test_a_curve_is_the_known_one(name):
    curve = solve_curve(**CASES[name])
    assert not curve.residual > 1e-11
    # Where the branch turns back a place is known to half of the digits.
    relative = 1e-5 if curve.section == "planar" else WITHIN
    KNOWN.check(name, seen(curve), relative)
