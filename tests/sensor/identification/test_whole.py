"""Whole results of some recordings, as stored texts: what a change of one number changes."""

import numpy as np
import pandas as pd
import pytest

from recordings import recorded
from responses import respond
from steel import NOISE, ROD, identified
from vibrissa.sensor import Whisker

RIGHT = {"theta": 2.0, "eta": 0.85}
TOLERANCES = {"eta": 0.003, "theta": 0.05, "crosstalk": 0.01, "zero_force_x": 0.02}
# The law of slipping, the rod that is given, and what is known of the set-up.
CASES = {
    "all is exact": ("free", RIGHT, {"assume": False}),
    "usual tolerances": ("free", RIGHT | {"rod": ROD}, {}),
    "tolerances of the beginning": ("kinetic", RIGHT, {"tolerances": TOLERANCES}),
    "another distance": ("free", RIGHT | {"eta": 0.87}, {}),
    "no rod": ("free", None, {"assume": False}),
    "no rod, usual tolerances": ("kinetic", None, {}),
    "no rod, tolerances": ("energy", None, {"tolerances": TOLERANCES}),
}


@pytest.fixture(scope="module")
def response():
    return respond(2.0, 0.85)


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=pytest.mark.nightly) if case == "another distance" else case
        for case in CASES
    ],
)
def test_a_result_is_as_before(response, case, snapshot):
    law, rod, stated = CASES[case]
    turns = ("0.15", "0.1", "0.25") if law == "kinetic" else ("0.4",)
    _, recording = recorded(response, 3, turns, law, step="0.002" if law == "energy" else "0.0005")
    found = identified(None if rod is None else Whisker(**rod), recording, noise=NOISE, **stated)
    columns = {name: one.values for name, one in found.columns().items()}
    rows = pd.DataFrame(columns).to_csv(index=False, float_format="%.4g")
    summary = str(found.summary())
    numbers = [(one.parameter.name, one.size, one.deviation) for one in found.estimates]
    each = "\n".join(f"{name} {size:.3g} ± {spread:.3g}" for name, size, spread in numbers)
    others = [f"{spread:.3g}" for spread in np.sqrt(np.diag(found.covariance))[len(numbers) :]]
    if found.goodness is not None:
        others.append(f"chi2 {found.goodness.chi2:.5g} of {found.goodness.degrees}")
    assert "\n\n".join([summary, rows, each, *others, *found.periods.notes]) == snapshot
