"""What the README promises can be typed."""

import re
from pathlib import Path

import pytest
import yaml

from vibrissa import tables
from vibrissa.study import parse_study

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("code", blocks("python"))
def test_python_examples_run(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "results/paper/tables"
    folder.mkdir(parents=True)
    tables.write(tables.STICTION.empty_table(), folder / "stiction.parquet")
    exec(compile(code, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    shown = re.findall(r"print\(.*\)  # (.*)$", code, re.MULTILINE)
    for line, expected in zip(printed.splitlines() if shown else [], shown, strict=True):
        # "0.528..." stands for the number's first digits
        assert re.fullmatch(re.escape(expected).replace(r"\.\.\.", r"\d*"), line)


def test_example_study_is_valid():
    schema = yaml.safe_load((ROOT / "workflow/schemas/study.schema.yaml").read_text())
    (example,) = blocks("yaml")
    study = parse_study(yaml.safe_load(example), schema)
    assert len(list(study.grids["strong_taper"].points())) == 15 * 3 * 3


@pytest.mark.parametrize("path", sorted((ROOT / "studies").glob("*.yaml")), ids=lambda p: p.name)
def test_further_studies_are_valid_and_named(path):
    schema = yaml.safe_load((ROOT / "workflow/schemas/study.schema.yaml").read_text())
    assert parse_study(yaml.safe_load(path.read_text()), schema).figures
    assert f"STUDY=studies/{path.name}" in README


def test_make_targets_exist():
    makefile = (ROOT / "Makefile").read_text()
    named = set(re.findall(r"(?:^|`)make ([a-z]+)", README, re.MULTILINE))
    assert {"reproduce", "test", "study"} <= named
    for target in named:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_results_folder_says_what_appears_there():
    text = (ROOT / "results/README.md").read_text()
    for name in ("stiction", "scans", "states", "figures/", "blocks/", "logs/"):
        assert name in text


def test_layout_names_every_module():
    (tree,) = [block for block in blocks("text") if "src/vibrissa" in block]
    modules = {path.stem for path in (ROOT / "src/vibrissa").rglob("*.py")} - {"__init__"}
    assert modules - set(re.findall(r"\w+", tree)) == set()
