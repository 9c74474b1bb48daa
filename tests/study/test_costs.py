from decimal import Decimal

import pytest

from vibrissa.outcomes import Contact, Solver
from vibrissa.study import costs
from vibrissa.study.grid import Grid
from vibrissa.study.model import default_block_size


def curves_of(*thetas):
    return {"theta": tuple(map(Decimal, thetas)), "eta": (Decimal("0.8"),)}


def test_curves_cost_more_the_stronger_the_taper_in_tip_contact_alone():
    tip = [costs.curve_seconds(curves_of(t), Solver.COLLOCATION, Contact.POINT) for t in (1, 2, 20)]
    line = [costs.curve_seconds(curves_of(t), Solver.COLLOCATION, Contact.LINE) for t in (1, 20)]
    assert tip == pytest.approx([0.12, 0.24, 1.0])
    assert line == pytest.approx([0.3, 0.3])
    assert costs.curve_seconds(curves_of(1, 2), Solver.SHOOTING, Contact.POINT) == 240


@pytest.mark.parametrize(
    ("seconds", "minutes"), [(0, 5), (1, 10), (150, 10), (151, 15), (600, 25), (3600, 125)]
)
def test_a_job_asks_for_its_start_and_twice_its_work(seconds, minutes):
    assert costs.minutes(seconds) == minutes


@pytest.mark.parametrize("theta", [1, 4, 20])
@pytest.mark.parametrize("contact", Contact)
@pytest.mark.parametrize("curves", [100, 10_000, 1_000_000])
def test_a_block_of_the_default_size_fits_half_an_hour(theta, contact, curves):
    one = costs.curve_seconds(curves_of(theta), Solver.COLLOCATION, contact)
    size = default_block_size(Solver.COLLOCATION, curves, one * curves)
    points = 100 * size
    assert costs.minutes(one * size) + costs.minutes(costs.POINT * points) <= 35
    assert costs.megabytes(size) <= 5000


def test_a_scan_and_a_comparison():
    grid = Grid(
        theta=(Decimal(1), Decimal(2)),
        mu0=(Decimal("0.3"),),
        eta=(Decimal("0.8"),),
        dx0=(Decimal("0.001"), Decimal("0.01")),
    )
    assert costs.scan_seconds(grid, 9) == pytest.approx(250e-6 * 2 * 9 * 1100)
    assert costs.comparison_seconds(grid.theta, grid.eta) == pytest.approx(0.12 + 0.24 + 2 * 0.3)


def test_what_curves_usually_take():
    usual = costs.usual_curve_seconds
    assert usual(curves_of(1, 2), Solver.COLLOCATION, Contact.POINT) == pytest.approx(5 * 0.7e-3)
    assert usual(curves_of(1, 2), Solver.COLLOCATION, Contact.LINE) == pytest.approx(2 * 0.02)
    assert usual(curves_of(1, 2), Solver.SHOOTING, Contact.POINT) == 20


@pytest.mark.parametrize(("curves", "megabytes"), [(0, 800), (1, 900), (1000, 900), (1001, 1000)])
def test_a_job_asks_for_memory_for_its_processes_and_its_curves(curves, megabytes):
    assert costs.megabytes(curves) == megabytes


def test_a_long_table_alone_is_collected_in_threads():
    assert [costs.collecting_threads(n, 8) for n in (0, 20_000_000, 20_000_001)] == [1, 1, 8]
