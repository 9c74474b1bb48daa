"""What a study will take."""

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from known import Known
from vibrissa.pipeline.blocks import partition
from vibrissa.pipeline.effort import effort
from vibrissa.study import costs
from vibrissa.study.parsing import parse_study

STUDY = """
study: a
grids:
  main:
    theta: {start: 1, stop: 4.7, step: 0.1}
    mu0: {start: 0.1, stop: 0.49, step: 0.01}
    eta: [0.7, 0.75, 0.8, 0.85, 0.9]
    dx0: [0.001]
"""
LINE = "contact: line\n"
KNOWN = Known(__file__)


def estimate(more="", solved=(), cores=2):
    study = parse_study(yaml.safe_load(STUDY + more))
    blocks = partition(study.curves, study.curves_per_job, {})
    names = [list(blocks)[i] for i in solved]
    return effort(study, blocks, names.__contains__, cores)


def test_the_line_says_what_will_be_done():
    assert str(estimate()) == "7,600 points, 190 curves (190 new), 5 jobs, about 10 s, 3 MB"
    assert (
        str(estimate(solved=[0])) == "7,600 points, 190 curves (152 new), 4 jobs, about 9 s, 3 MB"
    )
    assert str(estimate(solved=range(5))) == "7,600 points, 190 curves (all solved), 3 MB"


def test_the_effort_of_a_study_with_all_that_there_is():
    text = (Path(__file__).parents[2] / "config.yaml").read_text(encoding="utf-8")
    for changed in ({}, {"method": "shooting"}, {"contact": "line", "claims": None}):
        paper = yaml.safe_load(text) | changed
        study = parse_study({key: value for key, value in paper.items() if value is not None})
        blocks = partition(study.curves, 9, {})
        for name, solved in (("none", []), ("one", list(blocks)[:1]), ("all", blocks)):
            found = effort(study, blocks, solved.__contains__, 3)
            KNOWN.check(f"{study.contact}, {study.method}, {name} solved", found)


def test_one_is_singular():
    one = "study: a\ngrids: {g: {theta: [1], mu0: [0.1], eta: [0.7], dx0: [0.001]}}"
    study = parse_study(yaml.safe_load(one))
    blocks = partition(study.curves, study.curves_per_job, {})
    text = str(effort(study, blocks, lambda name: False, 2))
    assert text.startswith("1 point, 1 curve (1 new), 1 job, ")


def test_strong_taper_and_line_contact_take_longer():
    weak = "study: a\ngrids: {g: {theta: {start: 1, stop: 3, step: 0.001}, mu0: [0.1], eta: [0.7]"
    weak += ", dx0: [0.001]}}\n"
    seconds = []
    for text in (weak, weak.replace("start: 1, stop: 3", "start: 8, stop: 10"), weak + LINE):
        study = parse_study(yaml.safe_load(text))
        blocks = partition(study.curves, study.curves_per_job, {})
        seconds.append(effort(study, blocks, lambda name: False, 1).seconds)
    # 2,001 curves: 3 ms each, 20 ms in line contact, 57 ms of θ near 9.
    assert seconds[2] - seconds[0] == pytest.approx(2001 * 17e-3, rel=0.05)
    assert seconds[1] - seconds[0] == pytest.approx(2001 * 54e-3, rel=0.05)


def test_points_of_two_grids_count_once():
    twice = "  again: {theta: [1, 9], mu0: [0.1], eta: [0.7], dx0: [0.001]}\n"
    assert estimate(twice).points == 7601


def test_figures_scans_shooting_and_few_cores_take_longer():
    figure = "figures: {f: {kind: locking, grid: main}}\n"
    scan = "scans: {s: {theta: [1], mu0: [0.3], eta: [0.7], dx0: [0.0001], cycles: 9}}\n"
    for more in (figure, scan, "method: shooting\n"):
        assert estimate(more).seconds > estimate().seconds + 0.5
    assert estimate(figure).size == estimate().size + costs.FIGURE_BYTES
    assert estimate(cores=1).seconds > estimate().seconds + 2
    assert "about 38 min" in str(estimate("method: shooting\n", cores=1))


def test_a_million_points_take_what_was_measured():
    """docs/speed.md: 37 to 40 s on two cores, 253 MB."""
    study = parse_study(
        yaml.safe_load(
            "study: a\ngrids: {g: {theta: {start: 1, stop: 2.99, step: 0.01}, mu0: {start: 0.01, "
            "stop: 1, step: 0.01}, eta: {start: 0.5, stop: 0.99, step: 0.01}, dx0: [0.001]}}"
        )
    )
    blocks = partition(study.curves, study.curves_per_job, {})
    found = effort(study, blocks, lambda name: False, 2)
    assert (found.points, found.curves, found.jobs) == (1_000_000, 10_000, 9)
    assert 30 < found.seconds < 50
    assert 200e6 < found.size < 350e6


def test_scans_take_their_steps_and_a_job_and_leave_their_rows():
    scan = "scans: {s: {theta: [1], mu0: [0.3], eta: [0.7], dx0: [0.0001], cycles: 9}}\n"
    more, less = estimate(scan), estimate()
    # Cycles of a tenth of the rod's length or so; the curve is one of the study's already.
    steps = 9 * 0.1 / 0.0001
    assert more.seconds - less.seconds == pytest.approx((1 + 0.5e-3 * steps) / 2, rel=0.5)
    assert more.size - less.size == pytest.approx(4_500 * steps, rel=0.5)


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (119.4, "119 s"),
        (120.0, "2 min"),
        (7_199.0, "120 min"),
        (7_200.0, "2 h"),
        (172_799.0, "48 h"),
        (172_800.0, "2 d"),
    ],
)
def test_a_time_is_said_in_the_unit_that_suits(seconds, said):
    assert f"about {said}," in str(replace(estimate(), seconds=seconds))


@pytest.mark.parametrize(
    ("size", "said"),
    [(1.0, "1 MB"), (9.994e8, "999 MB"), (1e9, "1.0 GB"), (2.55e10, "25.5 GB"), (3e12, "3.0 TB")],
)
def test_a_size_is_said_in_the_unit_that_suits(size, said):
    assert str(replace(estimate(), size=size)).endswith(f", {said}")
