"""The strip: the drawing shows each period and its doubt, and the page says the answer first."""

import re
from dataclasses import replace

import numpy as np
import pytest

from steel import recording_of
from vibrissa.quantities.units import Kind, Units
from vibrissa.sensor import Grade, Identification, Periods, PeriodStatus
from vibrissa.sensor.identification.periods import Check
from vibrissa.sensor.identification.result import Residuals
from vibrissa.sensor.identification.slope import Slope
from vibrissa.strip.drawing import MOST_POINTS, axis_of, draw, extremes
from vibrissa.strip.page import page

MU0 = np.array([0.3, 0.31, 0.29, 0.3])
WIDE = 0.02


def periods(**other):
    """Four periods: two slips, a doubtful one and a wrong one, and 25 samples in each."""
    first = np.arange(4) * 25
    none = np.zeros(4)
    known = {
        "status": np.full(4, PeriodStatus.SLIP, dtype="U8"),
        "first": first,
        "last": first + 24,
        "first_line": first + 2,
        "last_line": first + 26,
        "contact": 0.5 + 0.01 * first,
        "footpoint": 0.01 * (first + 24),
        "start": none,
        "mu0": MU0,
        "deviation": np.full(4, 0.5 * WIDE),
        "low": MU0 - WIDE,
        "high": MU0 + WIDE,
        "common": none,
        "by_step": none,
        "effects": np.zeros((4, 0)),
        "checks": (
            Check(Grade.DOUBTFUL, np.array([False, True, False, False]), "look at <this>"),
            Check(Grade.WRONG, np.array([False, False, True, False]), "not a tip"),
        ),
        "left_out": ("a value is missing in 1 row",),
    }
    return Periods(**(known | other))


def found(**other):
    clamp = 0.01 * np.arange(100)
    loads = -1.0 - 0.1 * np.sin(clamp)[:, None] * np.array([1.0, 2.0, 3.0])
    known = {
        "recording": recording_of(clamp, loads),
        "periods": periods(),
        "units": Units(),
        "by_model": True,
        "estimates": (),
        "covariance": np.zeros((0, 0)),
        "slope": Slope(),
        "residuals": Residuals(clamp, np.zeros((100, 3)), ("force_x", "force_y", "moment_z")),
    }
    return Identification(**(known | other))


def panels(one):
    return {panel.get_ylabel().partition(" /")[0]: panel for panel in draw(one).axes}


def test_each_period_is_drawn_with_its_interval_at_its_place():
    panel = panels(found())[r"$\mu_0$"]
    (bars,) = [one for one in panel.collections if len(one.get_segments()) == 2]
    assert [segment[0][0] for segment in bars.get_segments()] == pytest.approx([0.5, 1.25])
    assert [tuple(segment[:, 1]) for segment in bars.get_segments()] == [
        pytest.approx((mu0 - WIDE, mu0 + WIDE)) for mu0 in MU0[[0, 3]]
    ]
    names = {line.get_label(): list(line.get_xdata()) for line in panel.lines}
    assert names["doubtful"] == [0.75] and names["wrong: do not use"] == [1.0]
    assert panel.get_xlabel().startswith("position of the tip")


def test_doubtful_and_wrong_periods_are_shaded_over_the_positions_of_the_clamp():
    drawn = panels(found())
    load = drawn["$F_x$, $F_y$"]
    spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in load.patches]
    assert spans == [pytest.approx((0.25, 0.49)), pytest.approx((0.5, 0.74))]
    assert set(drawn) == {"$F_x$, $F_y$", "$M_z$", "residual", r"$\mu_0$"}


def test_what_was_not_recorded_has_no_panel():
    recording = found().recording
    loads = recording.readings.copy()
    loads[:, 2] = np.nan
    apart = replace(recording, readings=loads)
    unknown = replace(periods(), contact=np.full(4, np.nan))
    drawn = panels(found(recording=apart, residuals=None, periods=unknown))
    assert set(drawn) == {"$F_x$, $F_y$", r"$\mu_0$"}
    assert drawn[r"$\mu_0$"].get_xlabel().startswith("position of the clamp")


def test_a_period_without_a_slip_is_a_lower_bound():
    status = np.array([PeriodStatus.SLIP] * 3 + [PeriodStatus.OPEN])
    mu0 = np.append(MU0[:3], np.nan)
    panel = panels(found(periods=periods(status=status, mu0=mu0, high=mu0)))[r"$\mu_0$"]
    (bound,) = [line for line in panel.lines if "lower bound" in line.get_label()]
    assert bound.get_ydata().tolist() == pytest.approx([MU0[3] - WIDE])


def test_a_long_recording_keeps_its_extremes():
    values = np.sin(np.arange(50_000.0))
    values[[12_345, 23_456]] = 9.0, -9.0
    rows = extremes(values)
    assert len(rows) <= MOST_POINTS and {12_345, 23_456} <= set(rows.tolist())
    assert (np.diff(rows) > 0).all()
    assert extremes(values[:100]).tolist() == list(range(100))


@pytest.mark.parametrize(
    ("largest", "unit", "factor"), [(3.0, "N", 1.0), (0.3, "mN", 1e3), (3e-5, "µN", 1e6)]
)
def test_small_loads_have_a_prefix(largest, unit, factor):
    axis = axis_of(found(units=Units(si=True)), Kind.FORCE, np.array([-largest, np.nan]))
    assert axis == (factor, unit)


def test_the_page_says_the_answer_then_the_doubts_then_the_rest():
    text = page(found(), "a <recording>.csv", ["11 tolerances assumed"])
    order = [
        "μ<sub>0</sub> = 0.3",
        "1 period in doubt",
        "look at &lt;this&gt;",
        "<svg",
        "a value is",
    ]
    places = [text.index(part) for part in order]
    assert places == sorted(places) and text.index("11 tolerances") > places[-1]
    assert 'class="doubtful">doubtful: look at' in text and 'class="wrong">wrong: not a' in text
    assert "a &lt;recording&gt;.csv" in text and text.count("<tr>") == 5
    # It needs nothing from elsewhere, and no typeface.
    assert not re.search(r'(src|href)="(?!data:|#)', text) and "font-family" not in text.lower()
