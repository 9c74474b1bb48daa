"""Sizes of units."""

import subprocess
import sys

import pytest

from vibrissa.quantities import units
from vibrissa.quantities.units import USUAL, Kind, unit_size


@pytest.mark.parametrize("unit", [unit for sizes in USUAL.values() for unit in sizes])
def test_usual_units_have_the_kind_and_the_size_that_pint_finds(unit, monkeypatch):
    known = [unit_size.__wrapped__(unit, kind) for kind in Kind]
    monkeypatch.setattr(units, "USUAL", {})
    assert known == [unit_size.__wrapped__(unit, kind) for kind in Kind]
    assert sum(size != 0 for size in known) == 1


def test_usual_units_do_not_wait_for_pint():
    program = """
import sys
from vibrissa.quantities.units import Kind, in_si
print(float(in_si("5 mm", Kind.LENGTH, "eta")), "pint" in sys.modules)
print(float(in_si("5 inch", Kind.LENGTH, "eta")), "pint" in sys.modules)
"""
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert found.stdout.split() == ["0.005", "False", "0.127", "True"]
