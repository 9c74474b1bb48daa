"""Run studies of growing size through the whole workflow: time, memory and table size.

Usage: python benchmarks/growth.py [--sizes 20 46 100]

A size n is a grid of n tapers (1 to 4), n heights (0.7 to 0.95) and n friction coefficients (up to
0.45): n³ points on n² curves, from an empty results folder to stiction.parquet.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pandas as pd
import yaml

ROOT = Path(__file__).resolve().parent.parent
LARGEST_BLOCK = 500


def axis(low: float, high: float, n: int) -> list[float]:
    """Equally spaced values of at most six digits."""
    return [round(low + (high - low) * i / (n - 1), 6) for i in range(n)]


def run(n: int, cores: int) -> dict[str, object]:
    """Run a study of n³ points and say what it took."""
    study = {
        "study": "growth",
        "block_size": min(LARGEST_BLOCK, max(16, n * n // (4 * cores))),
        "grids": {
            "g": {
                "theta": axis(1.0, 4.0, n),
                "mu0": axis(0.01, 0.45, n),
                "eta": axis(0.7, 0.95, n),
                "dx0": [0.001],
            }
        },
    }
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name in ("Snakefile", "config.yaml", "workflow", "src"):
            (root / name).symlink_to(ROOT / name)
        (root / "growth.yaml").write_text(yaml.safe_dump(study))
        command = [sys.executable, "workflow/run.py", "--cores", str(cores)]
        start = time.perf_counter()
        subprocess.run(
            [*command, "--configfile", "growth.yaml"], cwd=root, check=True, capture_output=True
        )
        seconds = time.perf_counter() - start
        results = root / "results/growth"
        jobs = {
            rule: pd.concat([pd.read_csv(p, sep="\t") for p in paths])
            for rule in ("curves", "points", "stiction")
            if (paths := sorted(results.glob(f"benchmarks/{rule}/*.tsv")))
            or (paths := sorted(results.glob(f"benchmarks/{rule}.tsv")))
        }
        size = (results / "tables/stiction.parquet").stat().st_size
    return {
        "points": n**3,
        "curves": n**2,
        "jobs": sum(map(len, jobs.values())),
        "wall / s": round(seconds, 1),
        **{f"{rule} / s": round(float(table["s"].sum()), 1) for rule, table in jobs.items()},
        "memory of the largest process / MB": round(
            resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        ),
        "table / MB": round(size / 1e6, 1),
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[20, 46, 100])
    parser.add_argument("--cores", type=int, default=2)
    given = parser.parse_args()
    header = None
    for size in given.sizes:
        row = run(size, given.cores)
        if header is None:
            header = list(row)
            print("| " + " | ".join(header) + " |\n" + "| --- " * len(header) + "|")
        print("| " + " | ".join(str(row[name]) for name in header) + " |", flush=True)
