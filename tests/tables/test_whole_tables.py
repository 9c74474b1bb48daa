"""Whole tables of a small study, and what reference tables hold of them: every column."""

from pathlib import Path

import numpy as np
import pytest

from known import Known
from small_study import columns, tables
from vibrissa.checking.condensing import condense

TABLES = Known(Path(__file__).with_name("tables.yaml"))


@pytest.mark.parametrize("name", ["stiction", "scans", "states"])
def test_a_table_is_the_known_one(name, tmp_path):
    shown = columns(tables()[name])
    # What is rounding says nothing more than that it is small.
    for rounding in [column for column in shown if "residual" in column]:
        assert not (np.array(shown.pop(rounding), dtype=float) > 1e-9).any()
    TABLES.compare(name, shown, tmp_path)


def test_what_is_compared_of_a_table_is_known(tmp_path):
    found = condense(tables())
    found["states"] = found["states"].drop(columns="residual", errors="ignore")
    found.pop("stiction")
    shown = {
        name: {column: list(frame[column]) for column in frame} for name, frame in found.items()
    }
    TABLES.compare("condensed", shown, tmp_path)
