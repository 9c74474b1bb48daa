"""Errors in the physics: does `make check` notice them in copies of the project.

The paper's study runs in each copy and is compared with the reference tables. Exit status 1 if a
mutation went unnoticed. Takes some minutes.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from validation.records import write_record

ROOT = Path(__file__).parents[1]
TABLES = [f"results/paper/tables/{name}.parquet" for name in ("stiction", "scans", "states")]


class Mutation(NamedTuple):
    """A text that stands once in a module, and what is put in its place."""

    module: str
    what: str
    old: str
    new: str


MUTATIONS = [
    Mutation(
        "mechanics/equations",
        "sign of the horizontal force in the equilibrium",
        "gradient = states.fx[:, None] * sin - states.fy[:, None] * cos",
        "gradient = -states.fx[:, None] * sin - states.fy[:, None] * cos",
    ),
    Mutation(
        "mechanics/equations",
        "sign of the clamp's moment",
        "moment = -(gradient @ weights)",
        "moment = gradient @ weights",
    ),
    Mutation(
        "mechanics/equations",
        "sign of the tip's turn",
        "states.clamp_compliance * moment + bend @ weights,",
        "states.clamp_compliance * moment - bend @ weights,",
    ),
    Mutation(
        "mechanics/stability",
        "sign of the load's part in the second variation",
        "return 1.0 + smallest_eigenvalue",
        "return 1.0 - smallest_eigenvalue",
    ),
    Mutation(
        "mechanics/newton",
        "the iteration ends at a correction of 0.01",
        "tolerance: float = 1e-12,",
        "tolerance: float = 1e-2,",
    ),
    Mutation(
        "mechanics/taper",
        "bending compliance of a weaker taper",
        "free / g**3 * square",
        "free / g**3 * np.sqrt(square)",
    ),
    Mutation(
        "mechanics/taper",
        "arc length by the diameter, not its square",
        "free * g / square,",
        "free * g / np.sqrt(square),",
    ),
    Mutation(
        "mechanics/elastica",
        "third power of the diameter in the integrated shapes",
        "flexibility = theta**4 / (theta * s - theta - s) ** 4",
        "flexibility = -(theta**3) / (theta * s - theta - s) ** 3",
    ),
    Mutation(
        "mechanics/elastica",
        "sign of the horizontal force in the integrated shapes",
        "moment = f * (cos_alpha * (x - x1) + sin_alpha * (y - y1))",
        "moment = f * (cos_alpha * (x - x1) - sin_alpha * (y - y1))",
    ),
    Mutation(
        "mechanics/elastica",
        "shapes integrated to 1e-6 instead of 1e-12",
        "SHAPE_TOLERANCE = 1e-12",
        "SHAPE_TOLERANCE = 1e-6",
    ),
    Mutation(
        "sticking/solving/beginning",
        "mirror image of the rod",
        "(bending_moment(states) < 0).all(axis=1)",
        "(bending_moment(states) > 0).all(axis=1)",
    ),
    Mutation(
        "sticking/reading",
        "slip where the sine, not the tangent, of α reaches μ0",
        'return {"reaction_fy": mu0, "reaction_fx": -1.0}',
        'return {"reaction_fy": mu0 / np.sqrt(1.0 - mu0**2), "reaction_fx": -1.0}',
    ),
    Mutation(
        "sticking/piece",
        "crossings taken from the nearest sample, not located",
        "found[inside] = bracketed_root(excess, low, high, index, value, *each, guess=guess)",
        "found[inside] = high",
    ),
    Mutation(
        "sticking/piece",
        "lock taken from the nearest sample, not located",
        "found[inside] = bracketed_root(sloped, low[inside], high[inside], index[inside])",
        "found[inside] = low[inside]",
    ),
    Mutation(
        "mechanics/states",
        "α counted clockwise",
        "return np.arctan2(self.reaction_fx, -self.reaction_fy)",
        "return np.arctan2(-self.reaction_fx, -self.reaction_fy)",
    ),
    Mutation(
        "numerics/steps",
        "first step of slip for the last of stiction",
        "    return step\n",
        "    return step + 1\n",
    ),
    Mutation(
        "sticking/stiction",
        "last state of stiction a step early",
        "n_steps[rows], x0_max[rows] = count, step_position(count, step)",
        "n_steps[rows], x0_max[rows] = count - 1, step_position(count - 1, step)",
    ),
    Mutation(
        "sticking/stiction",
        "penetration judged the other way round",
        "(x0_touch < sticks_until)",
        "~(x0_touch < sticks_until)",
    ),
    Mutation(
        "sticking/cycles",
        "slip a step earlier",
        "return int(last_step_within(np.array(self.end), dx0))",
        "return int(last_step_within(np.array(self.end), dx0)) - 1",
    ),
    Mutation(
        "sticking/cycles",
        "contact point on the other side of the clamp",
        "curve.contact_point(x0)",
        "curve.contact_point(-x0)",
    ),
    Mutation(
        "sticking/solving/offsets",
        "single state solved 1e-6 off its place",
        "closing = ClosingCondition.at_offset(offsets[rows], ",
        "closing = ClosingCondition.at_offset(offsets[rows] + 1e-6, ",
    ),
    Mutation(
        "numerics/spectral",
        "every Gauss weight a billionth too large",
        "weights = 0.5 * w\n",
        "weights = 0.5 * w * (1.0 + 1e-9)\n",
    ),
]


def mutate(mutation: Mutation, root: Path) -> None:
    """Put a mutation into a copy of the project."""
    path = root / f"src/vibrissa/{mutation.module}.py"
    text = path.read_text(encoding="utf-8")
    if text.count(mutation.old) != 1:
        sys.exit(f"{mutation.module}.py has {mutation.old!r} {text.count(mutation.old)} times")
    path.write_text(text.replace(mutation.old, mutation.new), encoding="utf-8")


def outcome(mutation: Mutation | None) -> tuple[int, list[str]]:
    """Exit status and lines of the check in a mutated copy; 2 where either breaks down."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name in ("src", "workflow", "tests/regression"):
            shutil.copytree(ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("Snakefile", "config.yaml"):
            shutil.copy(ROOT / name, root)
        if mutation:
            mutate(mutation, root)
        environment = os.environ | {
            "PYTHONPATH": str(root / "src"),
            "XDG_CACHE_HOME": str(root / ".cache"),
        }
        run = [sys.executable, "-m", "snakemake", "--cores", "all", "--scheduler", "greedy"]
        for command in ([*run, *TABLES], [sys.executable, "workflow/check.py"]):
            result = subprocess.run(
                command, cwd=root, env=environment, capture_output=True, text=True
            )
            # A check that breaks down has not noticed anything either.
            if result.returncode and (command[-1] in TABLES or not result.stdout):
                return 2, result.stderr.splitlines()
    return result.returncode, result.stdout.splitlines()


def main() -> int:
    status, lines = outcome(None)
    if status:
        print("Without a mutation the check is red already:", *lines, sep="\n")
        return 1
    rows, unnoticed = [], 0
    for number, mutation in enumerate(MUTATIONS, 1):
        status, lines = outcome(mutation)
        # The last two lines sum up; a column that moved may be refuted by its proofs as well.
        columns = list(dict.fromkeys(line.partition(":")[0] for line in lines[:-2]))
        shown = ", ".join(f"`{name}`" for name in columns[:3]) + (", ..." if columns[3:] else "")
        seen = {0: "**green**", 1: f"red: {shown} ({len(columns)})", 2: "no verdict"}
        unnoticed += status == 0
        rows.append(f"| {number} | `{mutation.module}` | {mutation.what} | {seen[status]} |")
        print(rows[-1], flush=True)
    # A run that fails counts as noticed: it must not have been for some other reason.
    status, lines = outcome(None)
    if status:
        print("Without a mutation the check is red in the end:", *lines, sep="\n")
        return 1
    head = ["| | module | what was broken | `make check` |", "| --- | --- | --- | --- |"]
    write_record("physics", __doc__, "\n".join([*head, *rows]))
    print(f"{len(MUTATIONS) - unnoticed} of {len(MUTATIONS)} mutations noticed")
    return 1 if unnoticed else 0
