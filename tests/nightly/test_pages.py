"""Code and commands of the pages run, and the tutorial can be followed."""

import os
import re
import shutil
import subprocess
import sys
from importlib import import_module

import pandas as pd
import pytest
from matplotlib import pyplot
from typer.testing import CliRunner

import small_study
from pages import blocks, commands
from runs import ROOT
from validation.browser import CHROMIUM, chromium
from vibrissa.cli.app import app
from vibrissa.tables import store

DOCS = ROOT / "docs"


# Such as matplotlib's where a legend has nothing to name.
@pytest.mark.filterwarnings("error::UserWarning")
@pytest.mark.slow
@pytest.mark.parametrize(("page", "code"), blocks("python"))
def test_python_runs(page, code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for study in ("paper", "mine"):
        folder = tmp_path / f"results/{study}/tables"
        folder.mkdir(parents=True)
        store.write(small_study.stiction(), folder / "stiction.parquet")
    for library in re.findall(r"^import (\w+)", code, re.MULTILINE):
        pytest.importorskip(library)
    # What an earlier block drew would hide what matplotlib warns of.
    pyplot.close("all")
    exec(compile(code, page, "exec"), {})
    printed = capsys.readouterr().out
    shown = re.findall(r"print\(.*\)  # (.*)$", code, re.MULTILINE)
    for line, expected in zip(printed.splitlines() if shown else [], shown, strict=True):
        # "0.528..." stands for the number's first digits
        assert re.fullmatch(re.escape(expected).replace(r"\.\.\.", r"\d*"), line)


@pytest.mark.slow
def test_commands_run_one_after_the_other(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    order = ("design", "solve", "scan", "import", "identify")
    # Of the designs, which take long, those that write a rod for other commands.
    wanted = [
        arguments
        for arguments in commands()
        if arguments[0] in order[1:] or (arguments[0] == "design" and "-o" in arguments)
    ]
    assert {arguments[0] for arguments in wanted} == set(order)
    # A rod and a recording are made before they are read.
    for arguments in sorted(wanted, key=lambda arguments: order.index(arguments[0])):
        result = CliRunner().invoke(app, arguments)
        assert result.exit_code == 0, result.output
    written = {arguments[arguments.index("-o") + 1] for arguments in wanted if "-o" in arguments}
    assert {path.name for path in tmp_path.iterdir()} - {"examples"} == written
    assert {"scan.csv", "friction.csv"} < written


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")
def test_equations_can_be_read_on_a_phone(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "site"))
    mathml = import_module("mathml")
    wide = "x(0) = x_0, " + " + ".join(["y(0)"] * 20)
    for name, latex in (("several", r"x(0) = x_0, \quad " * 6 + "y = 1"), ("wide", wide)):
        parts = "".join(mathml.mathml(part, "block") for part in mathml.lines(latex))
        style = (DOCS / "site/static/site.css").read_text()
        (tmp_path / f"{name}.html").write_text(
            "<!doctype html><meta name=viewport content='width=device-width'>"
            f"<style>{style}</style>"
            f'<div class="equation"><div class="parts">{parts}</div><a class="number">(1)</a></div>'
        )
    with chromium(tmp_path / "browser") as browser:
        for name, fits in (("several", True), ("wide", False)):
            browser.open((tmp_path / f"{name}.html").as_uri(), width=390)
            seen = browser.evaluate("""(() => {
                const equation = document.querySelector(".equation");
                const lefts = [...document.querySelectorAll("math")].map(
                    (math) => math.firstElementChild.getBoundingClientRect().left);
                return [Math.min(...lefts), equation.scrollWidth <= equation.clientWidth];
            })()""")
            assert seen[0] >= 0 and seen[1] == fits


@pytest.mark.slow
def test_the_tutorial_can_be_followed(tmp_path):
    for name in ("src", "workflow"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / name, tmp_path / name, ignore=ignored)
    for name in ("Snakefile", "config.yaml"):
        shutil.copy(ROOT / name, tmp_path)
    page = (DOCS / "tutorial.md").read_text()
    (study,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    (figure,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "src"), "MPLBACKEND": "agg"}

    def run(*arguments):
        command = [sys.executable, *arguments]
        return subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True
        )

    make = ("-m", "vibrissa.pipeline", "--cores", "2", "--configfile", "mine.yaml")
    table = tmp_path / "results/mine/tables/stiction.parquet"

    (tmp_path / "mine.yaml").write_text(study.replace("eta:", "etta:"))
    mistaken = run(*make)
    assert mistaken.returncode != 0
    assert "etta" in mistaken.stderr and "Traceback" not in mistaken.stderr

    (tmp_path / "mine.yaml").write_text(study)
    assert run(*make).returncode == 0
    assert len(pd.read_parquet(table)) == 45
    (tmp_path / "mine.py").write_text(figure)
    assert run("mine.py").returncode == 0
    assert (tmp_path / "mine.png").stat().st_size > 10_000

    grown = study.replace("mu0: [0.3]", "mu0: [0.3, 0.4]")
    assert grown != study
    (tmp_path / "mine.yaml").write_text(grown)
    assert run(*make).returncode == 0
    points = pd.read_parquet(table)
    assert len(points) == 90
    # What the page says of the results.
    locked = points["status"] == "lock"
    assert locked[points["eta"] == 0.95].all()
    assert (points["mu_lock"] < points["mu0"].astype(float))[locked].all()
    assert locked[points["mu0"] == 0.4].sum() > locked[points["mu0"] == 0.3].sum()
    first = points[points["mu0"] == 0.3].astype({"theta": float, "eta": float})
    below = {2.0: 0.7, 3.0: 0.8}
    wrong = first["eta"].round(9) < first["theta"].map(below).fillna(0.0)
    assert (first["penetrates"].fillna(False).astype(bool) == wrong).all()
    onsets = first[first["eta"] < 0.86].groupby("theta")["x0_slip"]
    assert (onsets.max() / onsets.min()).max() < 1.2
    assert 2.8 < onsets.min()[2.0] / onsets.min()[1.0] < 3.2
