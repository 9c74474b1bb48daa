"""The site of the documentation, and its tutorial as a newcomer follows it."""

import re
from importlib import import_module
from pathlib import Path

import pytest
from typer.testing import CliRunner

from vibrissa.cli.app import app

pytest.importorskip("sphinx")
nodes = pytest.importorskip("docutils.nodes")
new_document = pytest.importorskip("docutils.utils").new_document

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


@pytest.fixture(autouse=True)
def _tools(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "site"))


def tool(name):
    return import_module(name)


def test_links_stay_within_the_site():
    source = ["[`config.yaml`](../config.yaml) and [the model](model.md#rod)"]
    tool("links").keep_inside(None, "study", source)
    assert source == ["`config.yaml` and [the model](model.md#rod)"]


def test_terms_that_a_search_finds_first_have_their_headings():
    for page, heading in tool("links").TERMS:
        assert re.search(rf"^#+ {heading}$", (DOCS / f"{page}.md").read_text(), re.MULTILINE)
    source = ["# Trust\n\n## Accuracy\n"]
    tool("links").with_terms(None, "trust", source)
    assert "!single: accuracy\n" in source[0].partition("## Accuracy")[0]
    assert "!single: error\n" in source[0].partition("## Accuracy")[0]


def test_excerpts_keep_the_places_of_a_page():
    page = new_document("page")
    page += nodes.section("", nodes.title(text="A < B"), nodes.paragraph(text="words"), ids=["a-b"])
    page[0] += nodes.section("", nodes.paragraph(text="more"), ids=["inner", "index-1"])
    text = tool("excerpts").sections(page)
    start, inner = '<section id="a-b">', '<section id="inner"><section id="index-1">'
    assert text == f"{start}A &lt; B\nwords\n{inner}more\n</section></section></section>"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("as in (E3a) and (M10)", ["E3a", "M10"]),
        ("by equation (8) of the model", ["8"]),
        ("paper equation (2)", []),
        ("in (3) or f(E1) of E1", ["E1"]),
    ],
)
def test_numbers_of_equations_are_found(text, expected):
    assert [match[0] for match in tool("links").EQUATION.finditer(text)] == expected


def test_every_equation_that_is_named_is_on_its_page():
    links = tool("links")
    numbers = {
        name: set(re.findall(r"\\tag\{(\w+)\}", (DOCS / f"{name}.md").read_text()))
        for name in set(links.PAGES.values())
    }
    texts = [*DOCS.glob("*.md"), *(ROOT / "src").rglob("*.py")]
    named = {match[0] for path in texts for match in links.EQUATION.finditer(path.read_text())}
    assert {"E1", "D5"} <= named
    assert [number for number in named if number not in numbers[links.PAGES[number[0]]]] == []


def test_equations_have_their_number_beside_them():
    mathml = tool("mathml")
    assert mathml.without_tag(r"a = b, \tag{E1}") == ("a = b, ", "E1")
    assert mathml.without_tag("a = b") == ("a = b", "")
    shown = mathml.mathml(r"\cos\alpha", "inline")
    assert shown.startswith("<math") and "mspace" in shown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("x0,max at μ0", "<i>x</i><sub>0,max</sub> at <i>μ</i><sub>0</sub>"),
        ("x0, then Δx0.", "<i>x</i><sub>0</sub>, then <i>Δx</i><sub>0</sub>."),
        ("fx in E·I0/L²", "<i>f</i><sub>x</sub> in <i>E</i>·<i>I</i><sub>0</sub>/<i>L</i>²"),
        ("μk/μ0", "<i>μ</i><sub>k</sub>/<i>μ</i><sub>0</sub>"),
        ("μ_lock of s_c", "<i>μ</i><sub>lock</sub> of <i>s</i><sub>c</sub>"),
        ("<b>θ</b> = α", "<b><i>θ</i></b> = <i>α</i>"),
        ('<a href="#θ-x0">κ0</a>', '<a href="#θ-x0"><i>κ</i><sub>0</sub></a>'),
        *(
            (text, text)
            for text in ("<code>μ0</code>", "fxs, ax0, x0_max", "<math><mi>θ</mi></math>")
        ),
    ],
)
def test_symbols_in_the_text_look_as_in_the_equations(text, shown):
    assert tool("symbols").with_symbols(text) == shown


def test_equations_are_cut_between_their_parts():
    lines = tool("mathml").lines
    assert lines(r"x = 1, \quad y = 2, \qquad z = 3") == ["x = 1,", "y = 2,", "z = 3"]
    assert lines(r"x = \quadratic") == [r"x = \quadratic"]
    rows = r"\begin{aligned} a &= b \quad c \end{aligned}"
    assert lines(rows) == [rows]


def test_the_explorer_and_the_site_lead_to_each_other():
    assert 'href="index.html"' in tool("made").page(home="index.html")
    for path in ("index.md", "site/templates/explorer.html"):
        assert "play.html" in (DOCS / path).read_text()


def test_the_reference_says_what_each_command_prints():
    page = tool("made").commands()
    for name in ("solve", "scan", "import", "identify", "design"):
        section = page.partition(f"## `vibrissa {name}`\n")[2].partition("\n## ")[0]
        help = CliRunner().invoke(app, [name, "--help"], env={"COLUMNS": "200"}).output
        options = set(re.findall(r"(?<=\s)--[a-z][a-z0-9-]+", help)) - {"--help"}
        assert len(options) > 4
        assert {option for option in options if option not in section} == set()
        assert f"\nvibrissa {name} " in section
    assert "it may lie flat." in page
    assert "| `--mu0` | Coefficient of static friction. **Required.** |" in page


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Young's modulus:\n  '210 GPa', a*b.", "Young's modulus: `'210 GPa'`, a\\*b."),
        ("the rod's, the stage's", "the rod's, the stage's"),
        ("Repeat it: --to 1 --to 0.", "Repeat it: `--to` 1 `--to` 0."),
        ("'force_x=Fz [mN]' | [N]", "`'force_x=Fz [mN]'` \\| \\[N]"),
    ],
)
def test_what_a_user_types_is_code_on_the_site(text, expected):
    assert tool("made").escaped(text) == expected
