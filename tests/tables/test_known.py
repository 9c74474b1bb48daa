"""Whole tables of a small study, and what reference tables hold of them: every column."""

import numpy as np
import pytest

from known import Known
from small_study import columns, tables
from vibrissa.checking.condensing import condense

KNOWN = Known(__file__)


@pytest.mark.parametrize("name", ["stiction", "scans", "states"])
def test_a_table_is_the_known_one(name):
    shown = columns(tables()[name])
    # What is rounding says nothing more than that it is small.
    for rounding in [column for column in shown if "residual" in column]:
        assert not (np.array(shown.pop(rounding), dtype=float) > 1e-9).any()
    KNOWN.check(name, shown)


def test_what_is_compared_of_a_table_is_known():
    found = condense(tables())
    found["states"] = found["states"].drop(columns="residual", errors="ignore")
    found.pop("stiction")
    shown = {
        name: {column: list(frame[column]) for column in frame} for name, frame in found.items()
    }
    KNOWN.check("condensed", shown)
