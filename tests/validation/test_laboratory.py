"""Recordings of the bench with mistakes: a few of those that `make laboratory` reads."""

import costs
import laboratory
import numpy as np
import pytest
from bench import Bench, Friction, scan
from laboratory import ROWS, Said, Score, of_entry, recorded
from mistakes import MISTAKES, UNITS, everything

from vibrissa.sensor import Method, Whisker, identify, surfaces
from vibrissa.sensor import scan as simulated

TITLES = [row.title for row in ROWS]


def entry(title, said, seed, method):
    """Score of one recording."""
    _, found = of_entry((TITLES.index(title), said, seed), [Method(method)])
    return found[Method(method)]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize(
    ("title", "method"),
    [("clamp inclined by 0.5°", "moment"), ("transducer turned by 1°", "forces")],
)
def test_a_mistake_within_its_tolerance_is_covered(title, method, seed):
    for said in (Said.ENOUGH, Said.DRAWN):
        score = entry(title, said, seed, method)
        assert score.accepted and not score.silent
        assert score.covered > 0.8


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(
    ("title", "method"),
    [
        ("clamp inclined by 2°", "moment"),
        ("E 5 % off", "moment"),
        ("transducer turned by 1°", "forces"),
        ("zeros of both forces drift by 20 mN", "forces"),
        ("κ 0.05 off", "spacing"),
    ],
)
def test_a_mistake_beyond_its_tolerance_is_noticed(title, method, seed):
    assert not entry(title, Said.LITTLE, seed, method).accepted


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_without_tolerances_a_wrong_rod_is_silently_wrong_by_no_method(seed, monkeypatch):
    # What the scores are for: a sensor that says nothing is found out.
    frame, truth = recorded(ROWS[TITLES.index("E 1 % off")], Said.NOTHING, seed)

    def blind(frame, row, said, method):
        found = identify(
            laboratory.believed(), frame, method=method, noise=laboratory.NOISE, assume=False
        )
        found.periods.grade[:] = ""
        return found

    monkeypatch.setattr(laboratory, "read", blind)
    score = laboratory.scored(frame, truth, ROWS[0], Said.NOTHING, Method.MOMENT)
    assert score.silent and score.covered < 0.1


def test_a_longer_rod_reads_what_the_package_says_of_it():
    longer = MISTAKES["length"].fixed(Bench(friction=Friction()), 0.01)
    found = scan(longer, 1e-3, [0.05], np.zeros(3), seed=0)
    whisker = Whisker.read(2, "85 mm", modulus="210 GPa", diameter="1 mm", length="101 mm")
    # A step further, so that the last position is not lost to rounding.
    theirs = simulated(whisker, surfaces.constant(0.3), step="0.1 mm", to=["5.1 mm"], law="kinetic")
    known = theirs.readings[: len(found.readings)]
    assert found.readings * UNITS == pytest.approx(known, abs=1e-7)


def test_everything_is_drawn_at_once():
    sizes = dict.fromkeys(MISTAKES, 1e-3)
    one, other = (everything(Bench(), sizes, np.random.default_rng(seed)) for seed in (1, 2))
    assert one.rod.compliance > 0.0 and one.rod != other.rod
    for name in ("eta", "incline", "kinetic_ratio", "scale"):
        assert 0.0 < abs(getattr(one, name) - getattr(Bench(), name)) < 0.01
    for name in ("transducer", "zero", "drift"):
        assert (getattr(one, name) != getattr(Bench(), name)).all()


def test_the_table_says_what_is_silently_wrong():
    good = Score(read=True, doubted=False, bias=1e-4, half=1e-3, covered=0.95)
    bad = Score(read=True, doubted=False, bias=-2e-3, half=1e-3, covered=0.0)
    doubted = Score(read=True, doubted=True, bias=-2e-3, half=1e-3, covered=0.0)
    refused = Score(read=False)
    number = TITLES.index("E 5 % off")
    scores = {
        (number, said, seed): {Method.MOMENT: one}
        for said, both in {
            Said.NOTHING: (bad, doubted),
            Said.ENOUGH: (good, good),
            Said.DRAWN: (good, bad),
            Said.LITTLE: (doubted, refused),
        }.items()
        for seed, one in enumerate(both)
    }
    counted, *_, line, _, pooled = laboratory.table(scores)
    assert counted.startswith("2 recordings for each entry, and 2 where")
    assert (
        "| E 5 % off | moment | +0.0000 | 0.0010 | 0 % | 1 doubted, **1 silently wrong** " in line
    )
    assert line.endswith("| 95 % | – | 48 % | **1 silently wrong** | 1 refused, 1 doubted |")
    assert "47.5 ± 33.6 %" in pooled and "1 of 2 (nothing said)" in pooled


@pytest.mark.slow
def test_a_cost_is_what_exact_knowledge_would_save():
    readings = costs.recording()
    each, total = costs.costs(readings, Method.MOMENT)
    exact = costs.costs(readings, Method.MOMENT, {"transducer_angle": "exact"})[1]
    saved = np.sqrt(total.after**2 - exact.after**2)
    assert each["transducer_angle"].after == pytest.approx(saved, rel=0.02)
    assert total.after < total.before
    assert max(one.after for one in each.values()) < total.after
