"""Studies of the sensor: equal tables however they are run, and the border of a design."""

import os
import signal
import subprocess
import sys
import time
from itertools import product

import numpy as np
import pytest

from runs import Folder
from vibrissa.design.candidate import CLEARLY, limits_of
from vibrissa.design.pairs import survey
from vibrissa.design.requirements import Requirements
from vibrissa.outcomes import Method, ReadingStatus
from vibrissa.readings.reading import Bench, generator_of, read_once
from vibrissa.scanning.slip_model import FREE_SLIP
from vibrissa.scanning.surfaces import constant
from vibrissa.sensor import Setup
from vibrissa.tables import schemas, store

MU0, LENGTH, PERIODS = 0.3, 0.1, 12
STEPS = 24  # of a period
PAIRS = list(product((1.0, 1.5, 2.0, 3.0, 4.0), (0.8, 0.9)))
STATED = {"transducer": "nano17-si-12-0.12", "modulus": "200 GPa", "length": "100 mm"}


def diameter_of(pair, seen):
    """Diameter at which the fall of a slip is `seen` times the least that is taken for a slip."""
    at = 5e-4
    asked = {"mu0": f"{MU0}", "step": "1 um", "yield_strain": 1.0, **STATED}
    shape = {"theta": f"{pair.curve.theta}", "eta": f"{pair.curve.eta}", "diameter": "0.5 mm"}
    limits = limits_of(Requirements.read(**asked, **shape), pair, at, LENGTH)
    (found,) = (float(one.value) for one in limits if one.name == "slips")
    # Forces and moments grow with the fourth power of the diameter.
    return at * (seen / found) ** 0.25


def part_found(pair, seen):
    """Part of the slips of a recording that the model of the rod finds; 0 if it is refused."""
    theta, eta, x0 = pair.curve.theta, pair.curve.eta, pair.shortest
    diameter = f"{1e3 * diameter_of(pair, seen)!r} mm"
    setup = Setup.read(theta=theta, eta=eta, diameter=diameter, assume=False, **STATED)
    dx0 = x0 / STEPS
    bench = Bench(
        setup=setup,
        surface=constant(MU0),
        dx0=dx0,
        to=[PERIODS * x0],
        cycles=None,
        model=FREE_SLIP,
        tip_radius=0.0,
        errors={},
    )
    point = {"theta": theta, "eta": eta, "seen": seen}
    (found,) = read_once(bench, [Method.MODEL], generator_of(point, 1, 1))
    assert found.periods_true >= PERIODS - 2
    if found.status is not ReadingStatus.READ:
        return 0.0
    return found.periods_read / found.periods_true


@pytest.fixture(scope="module")
def pairs():
    theta, eta = np.array(PAIRS).T
    return survey(theta, eta, np.array([MU0]), "point")


def test_slips_of_ten_rods_at_the_border_are_found(pairs):
    found = [part_found(pair, CLEARLY) for pair in pairs]
    assert min(found) > 0.8 and np.mean(found) > 0.97


def test_slips_of_ten_rods_far_below_the_border_are_missed(pairs):
    found = [part_found(pair, CLEARLY / 4.0) for pair in pairs]
    assert max(found) < 0.8 and np.mean(found) < 0.3


STUDY = """
study: tiny
scans:
  runs: {theta: 1, eta: 0.85, dx0: 0.001, mu0: 0.3, to: 0.04}
readings:
  wire:
    scan: runs
    transducer: nano17-si-12-0.12
    rod: {modulus: 210 GPa, diameter: 0.8 mm, length: 100 mm}
    recordings: 3
"""


def friction_in(folder):
    return store.read(folder.root / "results/tiny/tables/friction.parquet", schemas.FRICTION)


def test_chunks_cores_and_a_stopped_run_do_not_change_the_table(tmp_path):
    tables = []
    for size, cores, stopped in ((7, 1, False), (1, 2, False), (1, 1, True)):
        root = tmp_path / f"{size}-{cores}-{stopped}"
        root.mkdir()
        folder = Folder(root)
        folder.write("tiny.yaml", f"{STUDY}chunk: {{recordings: {size}}}\n")
        if stopped:
            stop_after_a_chunk(folder)
        folder.run("--cores", str(cores))
        tables.append(friction_in(folder))
    assert len(tables[0]) == 3
    assert all(table.equals(tables[0]) for table in tables)
    assert (
        "wire, by model: 3 recordings, 0% without"
        in (root / "results/tiny/summary.txt").read_text()
    )


def stop_after_a_chunk(folder):
    """Run the study, and stop it when its first chunk is there."""
    command = [sys.executable, "-m", "vibrissa.pipeline", "--cores", "1"]
    environment = os.environ | {"PYTHONPATH": str(folder.home / "src")}
    run = subprocess.Popen(
        [*command, "--configfile", "tiny.yaml"], cwd=folder.root, env=environment
    )
    while not (chunks := list(folder.root.glob("results/tiny/reading_chunks/*/*/[1-9].parquet"))):
        assert run.poll() is None
        time.sleep(0.1)
    run.send_signal(signal.SIGINT)
    assert run.wait() != 0
    assert len(chunks) == 1
    assert not (folder.root / "results/tiny/tables/friction.parquet").exists()
