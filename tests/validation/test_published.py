"""Numbers that others published: what is compared, that it agrees, and that it need not."""

from decimal import Decimal

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import OptimizeResult, brentq

from validation import published, published_quantities, records
from validation.published import bounds, compare
from validation.published_quantities import dead_load

SOURCES = {source.title: source for source in published.read_sources()}
NUMBERS = [number for source in SOURCES.values() for number in source.numbers]

pytestmark = pytest.mark.slow


# The others have 78 numbers each; tests/nightly compares all.
FEW = [title for title, source in SOURCES.items() if len(source.numbers) < 30]


@pytest.mark.parametrize("title", FEW)
def test_published_numbers_are_ours_and_doctored_ones_are_not(title):
    for number in SOURCES[title].numbers:
        assert compare(number).expected, number
        value = Decimal(number.value)
        last = Decimal(number.digit or Decimal(1).scaleb(value.as_tuple().exponent))
        change = 2 * last if number.argument_rounding == "exact" else value / 10
        for doctored in (value + change, value - change):
            wrong = number._replace(value=str(doctored), digit=str(last))
            assert not compare(wrong).agrees, wrong


def test_the_numbers_that_differ_are_named():
    differ = {number.value: number for number in NUMBERS if number.known_difference}
    assert set(differ) == {"1.202", "23.289", "165.23"}
    number = differ["1.202"]
    assert (number.quantity, number.argument) == ("conical_column", "0.1")
    assert compare(number).difference == pytest.approx(0.00102, abs=5e-6)


@pytest.fixture
def one_source(tmp_path, monkeypatch):
    """A copy of the smallest source; the record goes into the same folder."""
    folder = tmp_path / "sources"
    folder.mkdir()
    copy = folder / "clamped_hinged_column.csv"
    copy.write_text((published.SOURCES / copy.name).read_text())
    monkeypatch.setattr(published, "SOURCES", folder)
    monkeypatch.setattr(records, "FOLDER", folder)
    return copy


def test_the_command_writes_the_page(one_source):
    assert published.main() == 0
    assert "| 1 | 20.19 | 20.1907 |" in (records.FOLDER / "published.md").read_text()


def test_the_command_fails_and_names_a_number_that_differs(one_source, capsys):
    one_source.write_text(one_source.read_text().replace("20.19,,", "20.18,,"))
    assert published.main() == 1
    assert "differs: clamped_hinged_column | 1 | 20.18 |" in capsys.readouterr().err
    assert "**differs**" in (records.FOLDER / "published.md").read_text()


def test_the_command_fails_if_a_known_difference_is_none(one_source, capsys):
    one_source.write_text(one_source.read_text().replace("13-10d,", "13-10d,misprinted"))
    assert published.main() == 1
    assert "agrees, which was not expected" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "rounding", "low", "high"),
    [
        ("1.20", "nearest", 1.195, 1.205),
        ("1.20", "nearest or cut", 1.195, 1.21),
        ("-1.20", "nearest or cut", -1.21, -1.195),
        ("1.20", "twice", 1.1945, 1.2055),
        ("1.20", "exact", 1.2, 1.2),
        ("4.2E-06", "nearest", 4.15e-6, 4.25e-6),
    ],
)
def test_the_last_digit_says_what_is_allowed(text, rounding, low, high):
    assert bounds(text, rounding) == pytest.approx((low, high), rel=1e-12)


def test_a_rounded_argument_widens_what_is_allowed(monkeypatch):
    monkeypatch.setattr(published_quantities, "conical_column", lambda x: 3.0 * float(x))
    number = NUMBERS[0]._replace(
        quantity="conical_column",
        argument="2.0",
        argument_rounding="nearest",
        value="6.1",
        rounding="nearest",
        digit="",
    )
    assert compare(number).allowed == pytest.approx((-0.2, 0.2))
    exact = number._replace(argument_rounding="exact")
    assert compare(exact).allowed == pytest.approx((-0.05, 0.05))


# --- Our side of the comparison. ---


def test_a_dead_load_that_is_not_found_is_an_error(monkeypatch):
    lost = OptimizeResult(x=np.array([0.1, 0.6]), fun=np.array([0.0, 1e-3]), message="no progress")
    monkeypatch.setattr(published_quantities, "root", lambda *_, **__: lost)
    with pytest.raises(ArithmeticError, match=r"load 0\.123 at 90\.0°: no progress"):
        dead_load(1.0, Decimal("0.123"), 90.0)


@pytest.mark.parametrize("ratio", ["0.1", "0.5", "0.9"])
def test_conical_column_is_a_root_of_the_linear_beam(ratio):
    theta = float(ratio) ** -0.25

    def slope_at_clamp(load):
        # B·y'' = m and m'' = −P·y'', from the tip, where m = 0, to the clamp, where y' = −m'/P = 0.
        def beam(s, values):
            moment, derivative = values
            return derivative, -load * moment / (1.0 - (1.0 - 1.0 / theta) * s) ** 4

        return solve_ivp(beam, (1.0, 0.0), (0.0, 1.0), rtol=1e-11, atol=1e-13).y[1, -1]

    load = brentq(slope_at_clamp, 0.8, 2.6, xtol=1e-12)
    assert published_quantities.conical_column(Decimal(ratio)) == pytest.approx(load, abs=1e-9)


def test_small_forces_are_linear_beam_theory():
    # Radius 0.1 m at the clamp, 0.05 m at the tip, L = 1 m, E = 2e11 Pa, 100 N.
    def curvature(s):
        return 100.0 * (1.0 - s) / (2e11 * np.pi * (0.1 - 0.05 * s) ** 4 / 4.0)

    rotation = quad(curvature, 0.0, 1.0, epsabs=0.0, epsrel=1e-12)[0]
    deflection = quad(lambda s: (1.0 - s) * curvature(s), 0.0, 1.0, epsabs=0.0, epsrel=1e-12)[0]
    assert published_quantities.small_rotation(Decimal(100)) == pytest.approx(rotation, rel=1e-8)
    assert published_quantities.small_deflection(Decimal(100)) == pytest.approx(
        deflection, rel=1e-8
    )
    assert published_quantities.small_stress(Decimal(100)) == pytest.approx(
        2e11 * 0.1 * curvature(0.0), rel=1e-8
    )
