"""What README and docs say can be typed, and what they point to is there."""

import re
import runpy
import tomllib
from pkgutil import resolve_name

import pytest
import typer
import yaml

from pages import PAGES, blocks, commands
from runs import ROOT
from validation.__main__ import TASKS
from vibrissa.cli.app import app
from vibrissa.study.chunks import number_of_points
from vibrissa.study.reading import read_study
from vibrissa.tables import schemas

GENERATED = runpy.run_path(str(ROOT / "docs/generated.py"))
PACKAGES = [path.parent.name for path in sorted(ROOT.glob("src/vibrissa/*/__init__.py"))]


@pytest.mark.parametrize("arguments", commands(), ids=" ".join)
def test_commands_are_understood(arguments):
    group = typer.main.get_command(app)
    if arguments[0].startswith("-"):
        assert arguments[0] in [name for parameter in group.params for name in parameter.opts]
    else:
        name, command, rest = group.resolve_command(typer.Context(group), list(arguments))
        assert command.make_context(name, rest).params


def test_example_study_is_valid():
    (_, example), *_ = blocks("yaml", ["docs/study.md"])
    study = read_study(None, yaml.safe_load(example))
    assert number_of_points(study.grids["strong_taper"].axes) == 15 * 3 * 3


def test_the_set_up_that_a_page_shows_is_that_of_the_example():
    ((_, shown),) = blocks("toml", ["docs/friction.md"])
    assert tomllib.loads(shown) == tomllib.loads((ROOT / "examples/setup.toml").read_text())


@pytest.mark.parametrize("path", sorted((ROOT / "studies").glob("*.yaml")), ids=lambda p: p.name)
def test_further_studies_are_valid_and_named(path):
    assert read_study(path).figures
    assert f"STUDY=studies/{path.name}" in PAGES["docs/study.md"]


@pytest.mark.parametrize("page", PAGES)
def test_make_targets_exist(page):
    makefile = (ROOT / "Makefile").read_text()
    for target in set(re.findall(r"(?:^|`)make ([a-z-]+)", PAGES[page], re.MULTILINE)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
    assert set(re.findall(r"python -m validation ([a-z][a-z-]*)", PAGES[page])) <= set(TASKS)


def test_help_names_every_target():
    makefile = (ROOT / "Makefile").read_text()
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE)) - {"help"}
    assert targets == set(re.findall(r'@echo "  make ([a-z-]+)', makefile))
    screen = makefile.partition("\nhelp:\n")[2].partition("\n\n")[0]
    assert max(map(len, re.findall(r'^\t@echo "(.*)"$', screen, re.MULTILINE))) <= 80


@pytest.mark.parametrize("page", PAGES)
def test_no_line_is_lost_as_a_comment(page):
    # The site leaves out a line that begins with a per cent sign.
    assert not re.search(r"^\s*%", PAGES[page], re.MULTILINE)


def anchors(text):
    """Places in a page that a link can point to, as GitHub names them."""
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    for target in re.findall(r"""(?:\]\(|src=")([^)\s"]+)""", PAGES[page]):
        # What is made for the site alone is checked when it is built: a warning is an error there.
        if not target.startswith(("http", "made/")):
            name, _, anchor = target.partition("#")
            path = (ROOT / page).parent / name if name else ROOT / page
            assert path.exists(), target
            assert not anchor or anchor in anchors(path.read_text(encoding="utf-8")), target


@pytest.mark.parametrize("page", PAGES)
def test_named_code_exists(page):
    names = re.findall(rf"`(?:vibrissa\.)?((?:{'|'.join(PACKAGES)})\.[\w.]+)`", PAGES[page])
    for name in (name for name in names if not name.endswith((".html", ".md", ".yaml"))):
        resolve_name(f"vibrissa.{name}")


def test_pages_that_code_names_exist():
    places = [ROOT / "Makefile", *ROOT.glob("workflow/**/*.*")]
    places += [
        path
        for folder in ("src", "examples", "validation")
        for path in ROOT.glob(f"{folder}/**/*.*")
    ]
    for path in places:
        if path.suffix in {".py", ".ipynb", ".yaml", ".smk", ""}:
            for name in re.findall(r"docs/\w+\.\w+", path.read_text(encoding="utf-8")):
                assert (ROOT / name).exists(), f"{path}: {name}"


def test_generated_parts_are_those_of_the_code():
    for path, text in GENERATED["pages"]().items():
        remedy = f"{path} is old: run python -m validation pages"
        assert path.read_text(encoding="utf-8") == text, remedy


def test_every_column_has_a_row():
    parts = GENERATED["parts"]()
    for table, schema in schemas.TABLES.items():
        rows = "".join(parts[f"columns of {name}"][1] for name in ("shared", "state", table))
        assert [name for name in schema.names if f"`{name}`" not in rows] == []
