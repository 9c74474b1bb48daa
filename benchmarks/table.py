"""Run the benchmarks, and print what pytest-benchmark found as one table."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

NAMES = {
    "test_states_on_random_curves": "states at 200 steps of 256 curves, residual <= 1e-12",
    "test_collocation_random_curves": "256 whole curves: and critical state, end, stability",
    "test_collocation_one_curve": "one whole curve",
    "test_auto": "AUTO-07p along one curve, 15 x 4 nodes, 1e-9",
    "test_solve_bvp": "scipy solve_bvp, tol 1e-8",
    "test_paper": "the paper's method (Python)",
    "test_octave": "the paper's method (GNU Octave)",
}


def measured() -> dict[str, dict]:
    """Run the benchmarks; return what was found by their names."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "found.json")
        command = [sys.executable, "-m", "pytest", "benchmarks/bench_states.py", "-q"]
        options = [f"--benchmark-json={path}", "--benchmark-disable-gc"]
        subprocess.run([*command, *options], check=True, stdout=subprocess.DEVNULL)
        return {one["name"]: one for one in json.loads(path.read_text())["benchmarks"]}


def main() -> None:
    """Print states per second, their spread, the ratio to the first row and the accuracy."""
    found = measured()
    table = Table(
        "method", "states/s and core", "quartiles", "rounds", "first row is", "error of f"
    )
    fastest = None
    for name, title in NAMES.items():
        if name not in found:
            table.add_row(title, "skipped", "", "", "", "")
            continue
        stats, info = found[name]["stats"], found[name]["extra_info"]
        rates = [info["states"] / stats[key] for key in ("median", "q3", "q1")]
        fastest = fastest or rates[0]
        table.add_row(
            title,
            f"{rates[0]:,.4g}",
            f"{rates[1]:,.4g} to {rates[2]:,.4g}",
            str(stats["rounds"]),
            f"{fastest / rates[0]:,.3g} x faster",
            f"{info['error']:.1e}",
        )
    Console(width=130).print(table)
