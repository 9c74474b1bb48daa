"""Damaged recordings, never a traceback nor a wrong number; more by `python -m validation fuzz`."""

import csv
import io
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from validation import fuzzing
from vibrissa.sensor.response import branch

RESPOND = cache(branch.respond)


@pytest.fixture
def known_rod(monkeypatch):
    """The rod is solved once."""
    monkeypatch.setattr(branch, "respond", RESPOND)


def fine(verdict):
    return verdict.outcome not in (fuzzing.SILENT, fuzzing.BROKEN)


@pytest.mark.slow
@pytest.mark.parametrize("damage", fuzzing.DAMAGE, ids=lambda damage: damage.__name__)
def test_damage_is_named_or_does_no_harm(damage, tmp_path, known_rod):
    verdict = fuzzing.tried(damage, 0, tmp_path / "recording.csv")
    assert fine(verdict), verdict
    verdict = fuzzing.on_the_command_line(damage, 1, tmp_path)
    assert fine(verdict), verdict


@pytest.mark.parametrize(
    ("damage", "number"),
    [(fuzzing.monstrous, 182), (fuzzing.monstrous, 203), (fuzzing.spikes, 109)],
)
def test_a_position_far_off_is_named(damage, number, tmp_path, known_rod):
    verdict = fuzzing.tried(damage, number, tmp_path / "recording.csv")
    assert verdict.outcome in ("right", "warned, right", "refused"), verdict


@pytest.mark.slow
@pytest.mark.parametrize("number", [84, 144])
def test_periods_without_an_error_of_their_own_are_summed_up(number, tmp_path, known_rod):
    verdict = fuzzing.on_the_command_line(fuzzing.stuck, number, tmp_path)
    assert fine(verdict), verdict


def test_each_kind_of_damage_says_what_it_is():
    assert all(damage.__doc__ for damage in fuzzing.DAMAGE)
    assert len(fuzzing.DAMAGE) * fuzzing.CASES >= 10_000


def test_a_wrong_number_is_wrong():
    at = np.array([0.5, 0.6])
    truth, deviation = fuzzing.SURFACE(at), np.array([1e-3, 1e-3])
    assert fuzzing.judged(["slip", "slip"], at, truth + 4e-3, deviation)[0]
    assert not fuzzing.judged(["slip", "slip"], at, truth + np.array([0, 6e-3]), deviation)[0]
    assert fuzzing.judged(["slip", "open"], at, truth + np.array([0, 6e-3]), deviation)[0]
    assert not fuzzing.judged(["slip", "slip"], at, truth * [1, np.nan], deviation)[0]


@pytest.mark.slow
@settings(max_examples=30)
@given(
    st.integers(0, 400),
    st.integers(0, 3),
    st.floats(allow_nan=True).map(repr) | st.text(max_size=12),
)
def test_one_cell_of_anything_is_named_or_does_no_harm(tmp_path_factory, row, column, cell):
    def one_cell(case):
        case.rows[row % len(case.rows)][column - 4] = cell
        file = io.StringIO()
        csv.writer(file).writerows([case.header, *case.rows])
        return file.getvalue().encode("utf-8", errors="surrogatepass")

    file = tmp_path_factory.mktemp("fuzz") / "recording.csv"
    verdict = fuzzing.tried(one_cell, 3 * row + column, file)
    assert fine(verdict), verdict
