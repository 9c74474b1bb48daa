"""Run studies of growing size through the whole workflow: time, memory and size of the tables.

A study is a grid of tapers (1 to 4), heights (0.7 to 0.95) and 100 friction coefficients (up to
0.45), run from an empty results folder. --record adds it to validation/records/growth.csv, with
what other sizes took before. 10⁷ points need 4 GB of disk in TMPDIR, 10⁸ need 30 GB.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
import yaml

from vibrissa.files import write_atomically
from vibrissa.tables import query, schemas

ROOT = Path(__file__).resolve().parent.parent
RECORD = ROOT / "validation/records/growth.csv"
# Tapers and heights by the number of points.
SIZES = {
    10**4: (10, 10),
    10**5: (40, 25),
    10**6: (100, 100),
    10**7: (400, 250),
    10**8: (1000, 1000),
}
FRICTIONS = 100
# Processor time of a rule's jobs: the machine may have other work to do.
RULES = {
    "chunk": "solving and reading / core-s",
    "stiction": "one table / core-s",
}
MEMORY = "largest process / MB"


def axis(low: float, high: float, n: int) -> list[float]:
    """Equally spaced values of at most six digits."""
    return [round(low + (high - low) * i / (n - 1), 6) for i in range(n)]


def run(points: int, cores: int) -> dict[str, float]:
    """Run a study of so many points and say what it took."""
    thetas, etas = SIZES[points]
    axes = {
        "theta": axis(1.0, 4.0, thetas),
        "mu0": axis(0.01, 0.45, FRICTIONS),
        "eta": axis(0.7, 0.95, etas),
        "dx0": [0.001],
    }
    with folder_kept_on_failure() as root, (root / "log").open("w") as log:
        for name in ("Snakefile", "config.yaml", "workflow", "src"):
            (root / name).symlink_to(ROOT / name)
        study = {"study": "growth", "max_points": points, "grids": {"g": axes}}
        (root / "growth.yaml").write_text(yaml.safe_dump(study))
        command = [sys.executable, "-m", "vibrissa.pipeline", "--cores", str(cores)]
        environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
        started, start = time.time(), time.perf_counter()
        process = subprocess.Popen(
            [*command, "--configfile", "growth.yaml"],
            cwd=root,
            env=environment,
            stdout=log,
            stderr=subprocess.STDOUT,
        )
        # The usage is of the process and of all that it waited for: its jobs, too.
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - start
        results = root / "results/growth"
        if status:
            sys.exit(f"the study of {points} points failed; see {root / 'log'}")
        table = results / "tables/stiction.parquet"
        jobs = {rule: benchmarks(results, rule) for rule in RULES}
        every = benchmarks(results, "*")
        return {
            "points": points,
            "curves": thetas * etas,
            "jobs": sum(map(len, jobs.values())),
            "to stiction.parquet / s": round(table.stat().st_mtime - started, 1),
            "with the report / s": round(seconds, 1),
            "all / core-s": round(usage.ru_utime + usage.ru_stime, 1),
            **{
                column: round(float(jobs[rule]["cpu_time"].sum()), 1)
                for rule, column in RULES.items()
            },
            MEMORY: round(max(usage.ru_maxrss * 1024, every["max_rss"].max() * 1024**2) / 1e6),
            "chunks / MB": megabytes(*results.glob("chunks/*/*.parquet")),
            "table / MB": megabytes(table),
            "read for one (θ, η) / MB": bytes_read(table, axes["theta"][3], axes["eta"][5]),
        }


@contextmanager
def folder_kept_on_failure() -> Iterator[Path]:
    """Make a temporary folder and remove it, unless something fails."""
    folder = Path(tempfile.mkdtemp(prefix="growth-"))
    yield folder
    shutil.rmtree(folder)


def benchmarks(results: Path, rule: str) -> pd.DataFrame:
    """Snakemake's benchmark files of a rule; of chunks there are many."""
    folder = "chunks/**/" if rule == "chunk" else "**/" if rule == "*" else ""
    name = "*" if rule == "chunk" else rule
    paths = results.glob(f"benchmarks/{folder}{name}.tsv")
    return pd.concat([pd.read_csv(path, sep="\t") for path in paths])


def megabytes(*paths: Path) -> float:
    """Size of some files (MB)."""
    return round(sum(path.stat().st_size for path in paths) / 1e6, 1)


def bytes_read(path: Path, theta: float, eta: float) -> float:
    """Size of what is read for all of one rod and height by the file's statistics (MB)."""
    (fragment,) = query.opened(path, schemas.STICTION).get_fragments()
    here = fragment.subset(query.one_of("theta", [theta]) & query.one_of("eta", [eta]))
    metadata = pq.read_metadata(path)
    groups = [metadata.row_group(found.id) for found in here.row_groups]
    sizes = [
        group.column(i).total_compressed_size
        for group in groups
        for i in range(metadata.num_columns)
    ]
    return round((metadata.serialized_size + sum(sizes)) / 1e6, 2)


def record(found: dict[str, float]) -> None:
    """Add a size to the record."""
    rows = pd.DataFrame([found]).set_index("points")
    if RECORD.exists():
        rows = rows.combine_first(pd.read_csv(RECORD, index_col="points"))
    rows = rows[[name for name in found if name != "points"]].sort_index()
    with write_atomically(RECORD) as temporary:
        rows.to_csv(temporary)


def main() -> None:
    """Measure, and write what came out after each size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=float, nargs="+", default=[1e4, 1e5, 1e6])
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--record", action="store_true", help="add to the record")
    given = parser.parse_args()
    if unknown := [points for points in given.points if points not in SIZES]:
        parser.error(
            f"--points: {unknown[0]:g} is not there; allowed: {', '.join(map(str, SIZES))}"
        )
    for points in map(int, given.points):
        found = run(points, given.cores)
        print("; ".join(f"{name}: {value:,}" for name, value in found.items()), flush=True)
        if given.record:
            record(found)
