"""The report: what it says, and what it does in a browser."""

import io
import json
import re
from html.parser import HTMLParser

import numpy as np
import pyarrow as pa
import pytest
from matplotlib import image

from validation.browser import CHROMIUM, chromium
from vibrissa import paper as papers
from vibrissa.explorer.page import MOUNTED, PAPER
from vibrissa.figures import style
from vibrissa.figures.draw import KINDS
from vibrissa.paper import claims, ledger
from vibrissa.paper.evidence import gather
from vibrissa.paper.reproduction import reproduced
from vibrissa.report import facts, tables
from vibrissa.report import motion as motions
from vibrissa.report.motion import motion
from vibrissa.report.page import About, Picture, page, shown
from vibrissa.report.spelling import spell, spell_column, symbol, with_symbols
from vibrissa.tables import schemas

EVIL = "</script><script>throw 1</script><b>&\"'"


def png(width=8, height=8, parts=""):
    file = io.BytesIO()
    image.imsave(file, np.zeros((height, width)), format="png", metadata={"Parts": parts})
    return file.getvalue()


def about(**others):
    known = {"study": "mine", "title": "My study", "claims": {}}
    known |= {"study_file": ("my.yaml", "study: mine"), "environment": {"Python": "3"}}
    return About(**known | others)


class Elements(HTMLParser):
    """Elements of a page with their attributes, and all of its text."""

    def __init__(self, text):
        super().__init__()
        self.found, self.text = [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.text += data

    def values(self, tag, name):
        return [attrs[name] for found, attrs in self.found if found == tag and name in attrs]


def failed(schema, **values):
    row = dict.fromkeys(schema.names) | {"theta": 2.0, "mu0": 0.3, "eta": 0.85, "dx0": 0.001}
    row |= {"status": "failed", "residual": None} | values
    rows = [{name: value for name, value in row.items() if name in schema.names}]
    return schema.empty_table().from_pylist(rows, schema=schema)


def changed(table, **values):
    return table.from_pylist([row | values for row in table.to_pylist()], schema=table.schema)


@pytest.fixture(scope="module")
def whole(study_tables, paper):
    """The paper's study with a ledger of one statement of each verdict."""
    names = ("example rod", "arc length", "pushed", "end of sticking")
    judged = [claim for claim in claims.CLAIMS if claim.name in names]
    evidence = gather(study_tables, dict(paper.claims))
    table = ledger.claims_table(judged, evidence, study="paper", method="collocation")
    return study_tables | {"claims": table}


@pytest.fixture(scope="module")
def text(whole, paper):
    pictures = [
        Picture(key=key, caption=figure["caption"], png=png(), selection=figure["selection"])
        for key, figure in paper.figure_params.items()
    ]
    return page(about(claims=dict(paper.claims)), whole, pictures)


def test_the_report_reads_as_before(text, snapshot):
    read = re.sub(r"<(script|style).*?</\1>|<[^>]+>", " ", text, flags=re.DOTALL)
    # Rounding errors differ from machine to machine.
    read = re.sub(r"[\d.]+·10⁻¹[⁰¹²³⁴-⁹]", "~0", read)
    lines = [" ".join(line.split()) for line in read.splitlines()]
    assert "\n".join(line for line in lines if line) == snapshot


def test_the_statements_that_do_not_hold_come_first_and_the_others_are_folded(text):
    order = re.findall(r'<article id="statement-[^"]*" data-of="([^"]*)">', text)
    assert order == ["contradicted", "ambiguous", "holds", "holds with a condition"]
    folded = text.index('<details id="settled">')
    assert text.index('data-of="ambiguous"') < folded < text.index('data-of="holds"')


def test_every_link_has_a_place_and_figures_and_statements_are_linked_both_ways(text):
    found = Elements(text)
    places = {attrs["id"] for _, attrs in found.found if "id" in attrs}
    links = [link[1:] for link in found.values("a", "href")]
    known = {facts.anchor(claim.name) for claim in claims.CLAIMS}
    assert set(links) <= places | known
    assert {"fig3", "fig7", "statement-pushed"} <= set(links)


def test_single_panels_of_a_figure_that_is_shown_whole_are_left_out(text):
    shown_keys = Elements(text).values("button", "data-tab")
    assert [key for key in shown_keys if key[3].isdigit()] == [f"fig{i}" for i in range(3, 9)]
    assert set(shown_keys) > {"figures_4_and_5", "nine_slips", "one_slip"}
    alone = [Picture(key=key, caption="", png=png()) for key in ("fig4a", "run1", "run1b")]
    assert [one.name for one in shown(alone)] == ["Figure 4a", "Run1", "Run1b"]


def test_the_papers_figures_are_compared_with_what_it_prints(study_tables, paper):
    parts = {part.name: part for part in reproduced(gather(study_tables, dict(paper.claims)))}
    assert parts["Figure 3"].outcome == "yes: x0,max = 0.052 L"
    assert parts["Figure 4"].outcome == "yes: 3 rods, 9 cycles each"
    assert parts["Figure 8"].difference.startswith("the sign of φ1, negative, agrees")
    listed = {name for part in parts.values() for name in part.claims}
    assert listed == {claim.name for claim in claims.CLAIMS if claim.texts["figures"]} | {
        "force unit"
    }


def test_another_study_has_its_own_heading_and_no_word_of_the_paper(study_tables):
    found = Elements(page(about(), study_tables, []))
    assert "My study" in found.text and papers.TITLE not in found.text
    assert not found.values("button", "data-verdict")


def test_the_page_refers_to_nothing_outside(text):
    found = Elements(text)
    assert not re.findall(r'(?:src|href)="(?!data:|#)', text)
    assert all(source.startswith("data:image/png;base64,") for source in found.values("img", "src"))
    assert "default-src 'none'" in text


def test_every_text_is_escaped(study_tables):
    found = study_tables | {
        "scans": changed(study_tables["scans"], scan=EVIL),
        "stiction": changed(study_tables["stiction"], grid=EVIL),
        "states": failed(schemas.STATES, state=EVIL, message=EVIL),
    }
    pictures = [Picture(key=EVIL, caption=EVIL, png=png())]
    made = page(
        about(title=EVIL, study=EVIL, study_file=(EVIL, EVIL), environment={EVIL: EVIL}),
        found,
        pictures,
    )
    elements = Elements(made)
    assert len([tag for tag, _ in elements.found if tag == "script"]) == 3
    data = re.search(r'data-x="presets">(.*?)</script>', made, re.DOTALL)[1]
    assert json.loads(data)[0]["recording"]["name"] == EVIL


def test_what_failed_is_told_and_not_shown(study_tables):
    found = {
        "stiction": failed(schemas.STICTION, grid="g", message="try a thicker rod"),
        "scans": failed(schemas.SCANS, scan="runs", message="no step"),
        "states": failed(schemas.STATES, state="low", message="it is too low"),
    }
    said = Elements(page(about(), found, [])).text
    for line in ("stiction: 1 row failed: try a thicker rod", "scans: 1 row failed: no step"):
        assert line in said
    assert "states: 1 row failed: it is too low" in said
    assert "Choose a figure of the paper, or" in said and "Green" not in said


def test_of_many_reasons_the_most_frequent_are_listed():
    many = [*range(43), 42]
    states = [failed(schemas.STATES, state=f"s{i}", message=f"no. {n}") for i, n in enumerate(many)]
    table = states[0].from_batches([batch for one in states for batch in one.to_batches()])
    told = facts.troubles({"states": table})
    assert told[0] == "states: 2 rows failed: no. 42"
    assert len(told) == 41 and told[-1] == "states: and 3 more reasons; see its table"


def test_the_scans_are_presets_with_names_of_figures_and_the_tables_rows(study_tables, paper):
    figures = {
        f"Figure {key[3:]}": figure.params()["selection"] for key, figure in paper.figures.items()
    }
    presets, _ = motion(study_tables, figures)
    rows = study_tables["scans"].to_pandas()
    names = [preset.name.partition(":")[0] for preset in presets]
    assert sorted(names) == [f"Figure {name}" for name in ("3", "4a", "4b", "4c", "5a", "5c")]
    for preset in presets:
        theta, mu0 = (preset.settings[name] for name in ("theta", "mu0"))
        chosen = rows[(rows["theta"] == theta) & (rows["mu0"] == mu0)]
        assert list(preset.recording.clamp) == pytest.approx(chosen["footpoint"].to_list())
        for name in ("fx", "fy", "m"):
            values = chosen[f"reaction_{name}"].to_list()
            assert list(getattr(preset.recording, name)) == pytest.approx(values, abs=0.51e-5)
        assert (preset.settings["contact"], preset.settings["section"]) == ("point", "round")
    assert motion(study_tables, {})[0][0].name.startswith("Nine cycles: θ = ")
    other = {b"vibrissa.study": b"{study: a, contact: line, section: planar}"}
    scans = study_tables["scans"].replace_schema_metadata(other)
    settings = motion({"scans": scans}, {})[0][0].settings
    assert (settings["contact"], settings["section"]) == ("line", "planar")


def test_scans_that_the_page_cannot_repeat_are_counted(study_tables, monkeypatch):
    scans = study_tables["scans"]
    tilted, steep = changed(scans, clamp_angle=0.1), changed(scans, theta=30.0, scan="steep")
    bent = changed(scans, curvature_powers="-0.6")
    all_of_them = pa.concat_tables([scans, tilted, steep, bent])
    presets, note = motion({"scans": all_of_them}, {})
    assert len(presets) == 6 and "leaves out 14 scans" in note
    monkeypatch.setattr(motions, "MOST_SCANS", 2)
    monkeypatch.setattr(motions, "MOST_ROWS", 60)
    presets, note = motion(study_tables, {})
    assert len(presets) == 2 and "leaves out 4 scans" in note
    assert all(len(preset.recording.clamp) == 30 for preset in presets)
    presets, note = motion({"scans": tilted}, {})
    assert presets == (*PAPER, *MOUNTED) and "6 scans" in note


def test_tables_have_some_rows_and_say_once_what_is_the_same(study_tables):
    by_title = {section.title: section for section in tables.sections(study_tables)}
    points = by_title["Grid points"]
    cells = {column.name: column.cells for column in points.columns}
    assert len(cells["μ0"]) == 40 and set(cells["grid"]) == {"Taper", "Friction"}
    first, last = (study_tables["stiction"].to_pylist()[place] for place in (0, -1))
    ends = [(row["theta"], row["mu0"]) for row in (first, last)]
    assert [(float(cells["θ"][i]), float(cells["μ0"][i])) for i in (0, -1)] == ends
    assert "In all of these rows: η = 0.85, dx0 = 0.001" in points.note
    scans = {column.name: column.cells for column in by_title["Scans"].columns}
    assert all(" … " in cell for cell in scans["reaction_fx"])
    assert "cycle = 9" in by_title["Scans"].note and "clamp_angle" not in by_title["Scans"].note
    table = study_tables["scans"]
    bent = changed(table, curvature_powers="0.6")
    mounted = pa.concat_tables([table, changed(table, stage_angle=0.1), bent])
    (scans,) = tables.sections({"scans": mounted})
    cells = {column.name: column.cells for column in scans.columns}
    assert cells["stage_angle"] == ["0.0"] * 6 + ["0.1"] * 6 + ["0.0"] * 6
    assert cells["curvature_powers"] == ["–"] * 12 + ["0.6"] * 6


def test_points_follow_the_longest_axis_of_their_grid(study_tables):
    points = {section.title: section for section in tables.sections(study_tables)}["Grid points"]
    rows = [
        dict(zip([column.name for column in points.columns], row, strict=True))
        for row in points.rows
    ]
    taper = [row for row in rows if row["grid"] == "Taper"]
    series = {}
    for row in taper:
        series.setdefault(float(row["μ0"]), []).append((float(row["θ"]), float(row["x0_max"])))
    assert list(series) == [0.2, 0.4]
    for trend in series.values():
        thetas, lengths = zip(*trend, strict=True)
        assert (
            len(trend) >= 8 and list(thetas) == sorted(thetas) and list(lengths) == sorted(lengths)
        )
        assert (thetas[0], thetas[-1]) == (1.0, 3.0)


def test_of_points_that_are_no_product_the_first_are_shown(study_tables):
    table = study_tables["stiction"]
    some = table.filter(pa.compute.equal(table["grid"], "taper")).slice(1)
    (points,) = tables.sections({"stiction": some})
    shown = {column.name: column.cells for column in points.columns}
    assert [float(cell) for cell in shown["θ"]] == some["theta"].to_pylist()[: len(shown["θ"])]
    assert [float(cell) for cell in shown["μ0"]] == some["mu0"].to_pylist()[:40]


def test_a_study_without_grids_has_its_results(study_tables):
    scans = {name: study_tables[name] for name in ("scans", "periods")}
    assert facts.results(scans) == facts.results(study_tables)[-1:] != []


def readings():
    """Friction read at two tapers: four recordings with an estimate each, and one without."""
    row = dict.fromkeys(schemas.FRICTION.names) | {"eta": 0.85, "dx0": 0.001, "mu0": 0.3}
    row |= {"readings": "tapers", "surface": "plane", "law": "free", "read_by": "model"}
    row |= {"transducer": "nano", "limit_name": [], "limit_share": [], "way": 0.05}
    row |= {"modulus": 2e11, "diameter": 1e-3, "length": 0.16, "periods_used": 5}
    row |= {"mu0_true": 0.3, "mu0_deviation": 0.01, "mu0_random": 0.006, "mu0_common": 0.008}
    row |= {"period_error": 0.02, "period_deviation": 0.02, "predicted": 0.02, "status": "read"}
    errors = (0.01, 0.01, 0.02, 0.04)
    rows = [
        row
        | {"theta": theta, "recording": number, "mu0_read": 0.3 + error}
        | {"inside": abs(error) < 0.0196, "grade": "doubtful" if number == 4 else None}
        for theta in (1.0, 2.0)
        for number, error in enumerate(errors, 1)
    ]
    lost = {"theta": 1.0, "recording": 5, "status": "yielded", "mu0_read": None, "inside": None}
    return pa.Table.from_pylist([*rows, row | lost], schema=schemas.FRICTION)


def test_a_study_of_the_sensor_has_its_figure_its_accuracy_and_its_readings(whole):
    table, file = readings(), io.BytesIO()
    with style.applied():
        figure = KINDS["accuracy"].plot(table.to_pandas(), over="theta", by="eta")
        figure.savefig(file, format="png")
    picture = Picture(key="errors", caption="Errors over theta.", png=file.getvalue())
    text = page(about(), {"friction": table, "claims": whole["claims"]}, [picture])
    found = Elements(text)
    told = " ".join(found.text.split())
    # By hand: rms √(1 + 1 + 4 + 16)·0.01/2 at each taper, and two of four intervals hold the truth.
    assert "tapers, by model: 9 recordings, 11% without an estimate, 22% in doubt" in told
    assert "0.023 (rms), stated 0.01, bias +0.02" in told
    assert "50.0% ± 7.7% of the 95 % intervals hold the truth" in told
    assert "Friction read from recordings" in told and "Errors over θ" in told
    assert "errors" in found.values("figure", "id")
    statements = [one for one in found.values("article", "id") if one.startswith("statement-")]
    assert len(statements) == len(whole["claims"])


@pytest.mark.parametrize(
    ("values", "texts"),
    [
        ([0.5, 12.25, -3.0], ["0.50", "12.25", "−3.00"]),
        ([1.0, 5.5511e-17], ["1", "0"]),
        ([0.3, None, float("inf")], ["0.3", "–", "∞"]),
        (["lock", "slip"], ["lock", "slip"]),
        ([123456.7, 0.001], ["123457", "0"]),
        ([0.052838, 0.1], ["0.05284", "0.10000"]),
    ],
)
def test_decimals_of_a_column_are_aligned(values, texts):
    assert spell_column(values) == texts


def test_names_in_captions_are_written_as_in_figures():
    written = with_symbols("x0,max over theta, mu0 < mu_lock; eta, beta, data x0")
    assert written == (
        "x<sub>0,max</sub> over θ, μ<sub>0</sub> &lt; μ<sub>lock</sub>; η, beta, data x<sub>0</sub>"
    )


def test_results_name_the_extremes_of_the_study(study_tables):
    slips, locks, scans = (line.replace("\u00a0", " ") for line in facts.results(study_tables))
    assert slips.startswith("The clamp moves by 0.00463 L (theta = 1, mu0 = 0.2, eta = 0.85) to ")
    assert "mu_lock = 0.4776 at theta = 2" in locks
    assert "0.009 L (theta = 1, mu0 = 0.3, eta = 0.85) to 0.076 L (theta = 3, mu0 = 0.4" in scans


def test_a_figure_has_its_physical_width_and_one_may_stand_at_the_head(study_tables):
    wide = Picture(key="head", caption="", png=png(2160, 300), leads=True)
    made = page(about(), study_tables, [wide, Picture(key="small", caption="", png=png(1050, 300))])
    widths = re.findall(r'<figure id="(\w+)" style="--width: (\d+)px">', made)
    # 7.2 and 3.5 inch, of 96 pixels each, enlarged by 1.4.
    assert widths == [("head", "968"), ("small", "470")]
    assert made.index('id="head"') < made.index("<h2>The rod in motion") < made.index('id="small"')


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (5.5511e-17, "< 10⁻¹⁵"),
        (float("inf"), "∞"),
        (-0.5, "−0.5"),
        (3.25e-13, "3.25·10⁻¹³"),
        (True, "yes"),
        ("out_of_reach", "out of reach"),
    ],
)
def test_values_are_spelled(value, text):
    assert spell(value) == text
    assert (symbol("theta"), symbol("eta"), symbol("mu_lock")) == ("θ", "η", "μ_lock")


def test_the_environment_names_the_software_and_neither_machine_nor_folder():
    found = facts.environment()
    assert found["numpy"] == np.__version__ and "/" not in "".join(found.values())


needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium to look at the report with (Debian: apt install chromium)"
)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("chromium")) as page:
        yield page


@pytest.fixture
def opened(browser, text, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(text, encoding="utf-8")

    def open_in(width=1200, **media):
        browser.open(path.as_uri(), width, **media)
        return browser

    return open_in


def wait_until(page, condition):
    page.evaluate(f"""new Promise((done, fail) => {{
        const end = Date.now() + 20000;
        const look = () => ({condition}) ? done(true)
            : Date.now() > end ? fail('never') : setTimeout(look, 20);
        look();
    }})""")


X0 = "Number(document.querySelector('[data-value=x0]').textContent)"


@needs_chromium
@pytest.mark.slow
def test_nothing_is_asked_of_the_network_and_nothing_goes_wrong(opened):
    page = opened()
    page.evaluate("document.querySelector('[data-x=play]').click()")
    wait_until(page, f"{X0} > 0.002")
    asked = [event["request"]["url"] for event in page.params("Network.requestWillBeSent")]
    assert [url for url in asked if not url.startswith("data:")] == [asked[0]]
    problems = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
    assert [page.params(problem) for problem in problems] == [[], [], []]


SHOWN = "[...document.querySelectorAll('{}')].filter((one) => one.checkVisibility()).map({})"


@needs_chromium
@pytest.mark.slow
def test_filters_filter_and_links_show_what_is_folded(opened):
    page = opened()
    statements = SHOWN.format("article", "(one) => one.dataset.of")
    assert page.evaluate(statements) == ["contradicted", "ambiguous"]
    page.evaluate("document.querySelector('[data-verdict=holds]').click()")
    assert page.evaluate(statements) == ["holds"]
    page.evaluate("document.querySelector('[data-verdict=holds]').click()")
    assert len(page.evaluate(statements)) == 4
    page.evaluate("document.querySelector('[data-verdict=ambiguous]').click()")
    page.evaluate("location.hash = '#statement-pushed'; 0")
    wait_until(page, f"{statements}.includes('holds')")


@needs_chromium
@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_a_figure_by_its_tab_and_folds_the_explorer(opened, scheme):
    page = opened(390, prefers_color_scheme=scheme)
    figures = SHOWN.format(".pictures figure", "(one) => one.id")
    assert page.evaluate(figures) == ["fig3"]
    page.evaluate("document.querySelector('[data-tab=fig7]').click()")
    assert page.evaluate(figures) == ["fig7"]
    assert not page.evaluate("document.querySelector('.explorer').checkVisibility()")
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    assert page.evaluate("document.documentElement.scrollHeight") < 8000
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 23, 26)"
    assert dark == (scheme == "dark")


@needs_chromium
@pytest.mark.slow
def test_on_a_phone_the_panels_of_a_wide_figure_stand_below_each_other(study_tables, tmp_path):
    parts = "[[0.0, 0.0, 0.5, 1.0], [0.5, 0.0, 1.0, 0.8], [0.5, 0.8, 1.0, 1.0]]"
    path = tmp_path / "report.html"
    wide = Picture(key="wide", caption="", png=png(2160, 900, parts))
    path.write_text(page(about(), study_tables, [wide]), encoding="utf-8")
    boxes = """[...document.querySelectorAll('.part')].filter((one) => one.checkVisibility())
        .map((one) => one.getBoundingClientRect()).map((b) => [b.x, b.y, b.width, b.height])"""
    with chromium(tmp_path) as browser:
        browser.open(path.as_uri(), 1200)
        assert browser.evaluate(boxes) == []
        browser.open(path.as_uri(), 390)
        wait_until(browser, "document.querySelectorAll('.part').length === 3")
        left, top, width, height = np.array(browser.evaluate(boxes)).T
        assert (np.diff(top) >= height[:-1]).all() and (left + width <= 390).all()
        # Each has the proportions of its part of the picture.
        assert width / height == pytest.approx([0.5 * 2.4, 0.5 * 2.4 / 0.8, 0.5 * 2.4 / 0.2], 0.02)
        scrolls = "document.querySelector('.sheet').scrollWidth > 390"
        assert not browser.evaluate(scrolls)
        assert browser.evaluate("document.querySelector('.sheet img').alt") == "Wide: "
