"""What the commands print and write, as texts that are stored.

After a change that was meant, `pytest tests/cli/test_screens.py --snapshot-update` stores them
anew; read the difference before you commit it.
"""

import shlex
from contextlib import chdir

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from runs import ROOT
from vibrissa.cli.app import app

STEEL = "--theta 2 --eta '85 mm' --modulus '210 GPa' --diameter '0.8 mm' --length '100 mm'"
NANO = "--transducer nano17-si-12-0.12"
MEASURED = "identify examples/measurement.csv -o out.csv"
SCAN = f"scan {STEEL} --step '50 um' -o out.csv"
SOLVE = "solve -o out.csv --mu0"
RIG = f"{STEEL} {NANO}"
LEANS = "--stage-angle '2 deg'"
NOISY = "--set noise='20 mN, 20 mN, 300 uN*m'"
CURVED = "--clamp-angle '3 deg' --set curvature='1 m^-1' --set clamp_compliance='0.1 rad/(N*m)'"
# Recordings that are simulated, then identified: options of scan, of both commands, of identify.
SIMULATED = {
    "texture": ("--texture '0.3, 0.05, 2 mm' --to '20 mm'", RIG, "--verbose"),
    "oblique": ("--mu0 0.3 --to '40 mm' --law energy", f"{RIG} {LEANS}", ""),
    "level": (f"--mu0 0.3 --to '20 mm' {LEANS}", RIG, "--tolerance exact"),
    "curved": (f"--mu0 0.2 --to '9 mm' {NANO}", f"{STEEL} {CURVED}", ""),
    "straight": (f"--mu0 0.2 --to '15 mm' {CURVED}", RIG, "--verbose"),
    "back": (f"--mu0 0.3 --to '12 mm' --to '1 mm' --to '14 mm' {NANO}", STEEL, "--method ratio"),
    "buckles": ("--mu0 0.6 --to '60 mm'", RIG, ""),
    "planar": ("--mu0 0.6 --to '40 mm'", f"{RIG} --set section=planar", ""),
    "lies": ("--mu0 0.5 --to '25 mm'", f"{RIG} --eta '55 mm' --contact line", "--tolerance exact"),
    "passes": ("--mu0 0.42 --to '12 mm'", f"{RIG} --eta '70 mm'", ""),
    "kinks": ("--mu0 0.2 --to '9 mm'", f"{RIG} --eta '80 mm' --contact line", "--tolerance exact"),
    "vanish": ("--mu0 0.2 --to '9 mm'", f"{RIG} --eta '83 mm' --contact line", "--tolerance exact"),
    "sticks": ("--mu0 0.4 --to '4 mm'", f"{STEEL} --set noise='0.2 mN, 0.2 mN, 2 uN*m'", ""),
    "coarse": (f"{STEEL} --patches '0 mm: 0.2, 45 mm: 0.4' --step '1 mm' --to '60 mm'", NANO, ""),
    "noisy": ("--mu0 0.3 --to '20 mm' --law kinetic", f"{STEEL} {NOISY}", ""),
}
COMMANDS = {
    "solve": f"{SOLVE} 0.3 --step '20 um' --material music-wire {STEEL}",
    "solve, yields": f"{SOLVE} 0.4 --theta 2 --eta '85 mm' --modulus '210 GPa' --diameter '2 mm' "
    "--length '100 mm'",
    "solve, locks": f"{SOLVE} 0.6 --theta 2 --eta 0.85 --set section=planar",
    "solve, buckles": f"{SOLVE} 0.6 --theta 2 --eta 0.85 --clamp-angle '-1 deg' --step 0.01",
    "solve, fails": f"{SOLVE} 0.6 --theta 2 --eta 0.05 --clamp-angle '60 deg' --set curvature=2",
    "scan, tapered": "scan --theta 10 --eta 0.5 --contact line --set curvature=-0.02 --mu0 0.2 "
    "--step 0.001 --to 0.05 -o out.csv",
    "scan, back": f"{SCAN} --mu0 0.3 --to '15 mm' --to '8 mm' --law kinetic {NANO}",
    "scan, pulled": "scan --theta 1 --eta '20 mm' --modulus '210 GPa' --diameter '0.4 mm' "
    "--length '100 mm' --mu0 2 --step '0.5 mm' --to '-4 mm' --clamp-angle '1 deg' -o out.csv",
    "scan, oblique": f"{SCAN} --mu0 0.6 --to '60 mm' --stage-angle '1 deg'",
    "scan, texture": f"{SCAN} --texture '0.3, 0.05, 2 mm' --seed 3 --to '20 mm' --law energy",
    "import": "import examples/laboratory.txt --settings examples/laboratory.toml -o out.csv",
    "identify": f"{MEASURED} --rod examples/setup.toml --verbose",
    "identify, ratio": f"{MEASURED} {NANO}",
    "identify, ratio beside": f"{MEASURED} {STEEL} --method ratio --tolerance eta=exact",
    "identify, wrong": f"{MEASURED} {STEEL} --set modulus='200 GPa' --tolerance exact",
    "identify, noisier": f"{MEASURED} {STEEL} --noise '1 mN, 1 mN, 5 uN*m'",
    **{
        f"identify, {name}": f"scan --step '50 um' {both} {scan} -o in.parquet && "
        f"identify in.parquet {both} {identify} -o out.csv"
        for name, (scan, both, identify) in SIMULATED.items()
    },
    "design": "design --rod examples/wire.toml --step '50 um' --mu0 '0.2 to 0.4' --theta '1, 2' "
    "--eta '0.85 to 0.9' --diameter '0.5 to 0.8 mm' -o out.toml",
}


def short(column):
    """Counts of texts, or number, mean and last of the numbers in a column, to four digits."""
    if column.dtype.kind not in "if":
        return {name: int(n) for name, n in column.fillna("").value_counts().sort_index().items()}
    some = np.round(column.dropna().to_numpy(float), 12) + 0.0
    return f"{some.size} {some.mean().round(12) + 0.0:.4g} {some[-1]:.4g}" if some.size else "none"


def table_of(path):
    """The lines above a table, and each column in short."""
    lines = path.read_text(encoding="utf-8").splitlines()
    above = [line for line in lines if line.startswith("#")]
    if path.suffix == ".toml":
        return lines[1:]
    frame = pd.read_csv(path, skiprows=len(above))
    return [*above, *(f"{title}: {short(frame[title])}" for title in frame)]


# The longest fits.
FITS = ("oblique", "curved", "straight", "planar", "passes", "noisier", "ratio beside")
LONG = ["design", *(f"identify, {name}" for name in FITS)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(one, marks=pytest.mark.nightly) if one in LONG else one for one in COMMANDS],
)
def test_a_command_prints_and_writes_as_before(name, snapshot, tmp_path):
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    text = []
    for command in COMMANDS[name].split(" && "):
        with chdir(tmp_path):
            found = CliRunner().invoke(app, shlex.split(command))
        text += [f"exit code {found.exit_code}", found.stdout, found.stderr]
    for path in tmp_path.glob("out.*"):
        text += table_of(path)
    assert "\n".join(text) == snapshot
