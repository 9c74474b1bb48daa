"""The report: what it says, and what it does in a browser."""

import json
import platform
import re
from dataclasses import replace
from decimal import Decimal
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import made_tables
from validation.browser import CHROMIUM, chromium
from vibrissa import __version__, solve_curve, stick_slip
from vibrissa.paper import ledger
from vibrissa.paper.evidence import gather
from vibrissa.report import facts, proofs, tables
from vibrissa.report import motion as motions
from vibrissa.report import page as report
from vibrissa.report.motion import motion, of_points, of_scans
from vibrissa.report.spelling import spell
from vibrissa.tables import records, schemas, store
from vibrissa.tables.proofs import KEYS, Proof, read

EVIL = "</script><script>throw 1</script><b>&\"'"
ROOT = Path(__file__).parents[2]
RUN = report.Run(study_files={"my.yaml": "study: mine"}, environment={"Python": "3"}, benchmarks={})


def picture(name="one", caption="A caption.", png=b"png"):
    return report.Picture(name=name, caption=caption, png=png)


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

    def count(self, tag):
        return sum(name == tag for name, _ in self.found)


def failed(schema, **values):
    """Table of one row that has no result."""
    empty = {field.name: [] if "list" in str(field.type) else None for field in schema}
    known = {"theta": 2.0, "mu0": 0.3, "eta": 0.85, "dx0": 0.001, "x1": 0.1, "status": "failed"}
    row = {key: value for key, value in (empty | known | values).items() if key in schema.names}
    return store.joined([], schema).from_pylist([row], schema=schema)


@pytest.fixture(scope="module")
def whole(study_tables, paper):
    """The paper's tables, with a few of its statements."""
    names = {key: study_tables[key] for key in ("stiction", "scans", "states")}
    found = gather(names, dict(paper.claims))
    claims = [
        ledger.Claim(
            name=f"{verdict} {EVIL}",
            section="I",
            statement=EVIL,
            computed="computed",
            figures=[],
            reasons={verdict: "a reason"},
            compute=lambda _, v=verdict: (v, {"number": (-0.00012345678, "1/L")}),
        )
        for verdict in ledger.Verdict
    ]
    return names | {
        "claims": ledger.claims_table(claims, found, study="paper", method="collocation")
    }


@pytest.mark.slow
def test_the_same_tables_make_the_same_page(whole):
    first, second = (report.page("paper", whole, [picture()], RUN) for _ in range(2))
    assert first == second


def test_the_page_holds_what_the_tables_say(whole):
    text = Elements(report.page("paper", whole, [picture()], RUN)).text
    for said in ("224: 9 lock, 215 slip", "6, all slip", "2049", "A caption.", "study: mine"):
        assert said in text
    assert "Not offered" not in text and "the first" not in text.partition("Tables")[0]
    assert "−0.00012346 1/L" in text
    (row,) = (r for r in whole["states"].to_pylist() if r["state"] == "penetrating")
    assert spell(row["f"]) in text
    for verdict in ledger.Verdict:
        assert f"1 {verdict}" in text


def test_the_page_says_what_every_column_is(whole):
    text = report.page("paper", whole, [], RUN)
    dictionary = text.partition('id="dictionary"')[2].partition("</details>")[0]
    rows = re.findall("<tr><td><code>(.*?)</code></td>", dictionary)
    assert rows == [name for table in whole.values() for name in table.schema.names]
    assert "<td>E·I0/L²</td>" in dictionary and "<td>fx = f·sin α</td>" in dictionary


def test_the_page_refers_to_nothing_outside(whole):
    page = Elements(report.page("paper", whole, [picture()], RUN))
    for tag, attributes in page.found:
        for name in ("src", "href", "srcset", "action", "data"):
            assert re.match(r"data:|#|None", str(attributes.get(name))), (tag, attributes)
    style = Path(report.__file__).with_suffix(".css").read_text()
    assert "url(" not in style and "@import" not in style


def test_every_text_is_escaped(whole):
    run = report.Run(
        study_files={EVIL: EVIL},
        environment={EVIL: EVIL},
        benchmarks={EVIL: ["s\tmax_rss\n1\t2\n"]},
    )
    found = dict(whole)
    scans = found["scans"].slice(0, 3).to_pylist()
    found["scans"] = found["scans"].from_pylist(
        [row | {"scan": EVIL} for row in scans], schema=schemas.SCANS
    )
    found["states"] = failed(schemas.STATES, state=EVIL, message=EVIL)
    text = report.page(EVIL, found, [picture(EVIL, EVIL)], run)
    page = Elements(text)
    assert page.count("script") == 2  # the presets and the program
    assert len([e for e in page.found if e == ("b", {})]) == 8  # titles, steps of the introduction
    assert page.text.count(EVIL) > 10
    data = re.search(r'data-x="presets">(.*?)</script>', text, re.DOTALL)[1]
    assert json.loads(data)[0]["recording"]["name"] == EVIL


def test_a_study_may_have_nothing_but_points_that_failed():
    found = {"stiction": failed(schemas.STICTION, grid="g", message="try a thicker rod")}
    page = Elements(report.page("bad", found, [], RUN))
    assert "stiction: 1 row failed: try a thicker rod" in page.text
    assert not page.count("img")
    assert "Grid g" in page.text


def test_failed_scans_and_states_are_told_and_not_shown(study_tables):
    found = {
        "stiction": study_tables["stiction"],
        "scans": failed(schemas.SCANS, scan="runs"),
        "states": failed(schemas.STATES, state="low", message="it is too low"),
    }
    page = Elements(report.page("bad", found, [], RUN))
    assert "scans: 1 row failed" in page.text and "states: 1 row failed: it is too low" in page.text
    assert "Choose a point of the study, or" in page.text and "Green" not in page.text


def test_a_study_without_scans_offers_corners_of_its_grids(study_tables):
    points = study_tables["stiction"]
    found = motion({"stiction": points})
    assert (found.what, found.notes) == ("a point of the study", ())
    names = [preset.name for preset in found.presets]
    assert names[0] == "friction: θ = 2, μ0 = 0.1, η = 0.85, Δx0 = 0.001"
    assert names[2].endswith("(self-locking)") and len(names) == 3 + 9
    rows = points.to_pandas()
    for preset in found.presets:
        settings = preset.settings
        (row,) = rows[
            (rows["grid"] == preset.name.partition(":")[0])
            & (rows["theta"] == settings["theta"])
            & (rows["mu0"] == settings["mu0"])
        ].to_dict("records")
        slips = row["status"] == "slip"
        assert preset.clamp == (row["x0_max"] if slips else 0.0)
        assert f"{row['x0_slip'] if slips else row['mu_lock']:.5g}" in preset.note
        assert (settings["beta"], settings["contact"], settings["section"]) == (0, "point", "round")


def test_points_are_offered_as_their_study_has_them(study_tables):
    points = study_tables["stiction"].slice(0, 9)
    other = {b"vibrissa.study": b"{study: a, contact: line, section: planar}"}
    presets = of_points(points.replace_schema_metadata(other)).presets
    assert presets
    assert {preset.settings["contact"] for preset in presets} == {"line"}
    assert {preset.settings["section"] for preset in presets} == {"planar"}
    for others in ({"clamp_angle": 0.1}, {"theta": 30.0}, {"status": "failed"}):
        assert of_points(changed(points, **others)).presets == ()


def test_the_scans_are_presets_with_the_tables_rows(study_tables):
    found = of_scans(study_tables["scans"])
    rows = study_tables["scans"].to_pandas()
    assert len(found.presets) == 6 and found.notes == ()
    for preset in found.presets:
        assert preset.settings["contact"] == "point" and preset.settings["section"] == "round"
        theta, mu0 = (preset.settings[name] for name in ("theta", "mu0"))
        chosen = rows[(rows["theta"] == theta) & (rows["mu0"] == mu0)]
        assert list(preset.recording.clamp) == pytest.approx(chosen["footpoint"].to_list())
        for name in ("fx", "fy", "m"):
            values = chosen[f"reaction_{name}"].to_list()
            assert list(getattr(preset.recording, name)) == pytest.approx(values, abs=0.51e-5)


def changed(scans, **values):
    return scans.from_pylist([row | values for row in scans.to_pylist()], schema=scans.schema)


def test_scans_that_the_page_cannot_repeat_are_counted(study_tables, monkeypatch):
    scans = study_tables["scans"]
    tilted, steep = changed(scans, clamp_angle=0.1), changed(scans, theta=30.0, scan="steep")
    both = scans.from_batches([*scans.to_batches(), *tilted.to_batches(), *steep.to_batches()])
    found = of_scans(both)
    assert len(found.presets) == 6
    assert "not mounted as in the paper: 6 scans" in found.notes[0]
    assert "outside of the fields' range: 2 scans" in found.notes[1]
    monkeypatch.setattr(motions, "MOST_SCANS", 2)
    monkeypatch.setattr(motions, "MOST_ROWS", 60)
    found = of_scans(scans)
    assert len(found.presets) == 2 and "the first 2 of 6 scans" in found.notes[0]
    assert all(len(preset.recording.clamp) == 30 for preset in found.presets)
    assert of_scans(tilted).presets == ()
    text = Elements(report.page("a", {"scans": tilted}, [], RUN)).text
    assert "Choose a figure of the paper, or" in text and "not mounted as in the paper: 6" in text


@pytest.fixture(scope="module")
def swinging():
    """A scan of a locked rod that swings aside and is dragged, and one of a planar rod."""
    axes = made_tables.grid((2.0,), (0.9,), dx0=(0.01,))
    point = {name: value for name, (value,) in axes.items()}
    return {
        section: records.scan_table(
            "runs", point, stick_slip(curve, 0.9, 0.01, 3), study="a", method=curve.method
        )
        for section in ("round", "planar")
        for curve in [solve_curve(2.0, 0.85, section=section)]
    }


@pytest.mark.slow
def test_a_planar_rod_is_offered_as_one(swinging):
    for section, scans in swinging.items():
        (preset,) = of_scans(scans).presets
        assert preset.settings["section"] == section and "self-locking" in preset.name


def test_key_rows_are_the_corners_and_the_middle(study_tables):
    rows = study_tables["stiction"].to_pandas()
    taper = rows[rows["grid"] == "taper"]
    keys = tables.key_rows(taper, tables.POINT)
    assert list(zip(keys["theta"], keys["mu0"], strict=True)) == [
        (theta, mu0) for theta in (1, 2, 3) for mu0 in (0.2, 0.3, 0.4)
    ]


def proof(table, quantity, midpoint, radius="1E-22", on_path=True, **row):
    return Proof(
        table=table,
        row=row,
        quantity=quantity,
        midpoint=Decimal(midpoint),
        radius=Decimal(radius),
        on_path=on_path,
        note="",
    )


ONSET = {"theta": "2", "mu0": "0.4", "eta": "0.85", "dx0": "0.001"}
LOCKS = ONSET | {"mu0": "0.50"}


def test_digits_are_those_that_both_ends_of_an_enclosure_have():
    spelled = {
        ("0.0528380427957399076949", "1E-23"): "0.052838042795739907694…",
        ("0.0528380427957399076949", "1E-22"): "0.05283804279573990769…",  # 4… or 5…
        ("-1.2345678901", "5E-11"): "−1.234567890…",
        ("0.2", "1E-9"): "0.…",  # 0.19… or 0.20…
        ("52", "0"): "52",
    }
    for (midpoint, radius), text in spelled.items():
        assert proofs.digits(proof("curves", "x", midpoint, radius)) == text
    assert proofs.digits(None) == "–"


def test_a_row_is_marked_that_its_proofs_do_not_contradict():
    found = proofs.Proved(
        [
            proof("stiction", "x0_slip", "0.05", **ONSET),
            proof("stiction", "", "NaN", "NaN", **LOCKS),
            proof("states", "f", "1", on_path=False, state="arch"),
        ]
    )
    row = {name: float(value) for name, value in ONSET.items()}
    marks = {
        "✓": found.of("stiction", row | {"x0_slip": 0.05 + 1e-9}),
        "✓ (state)": found.of("states", {"state": "arch", "f": 1.0}),
    }
    for text, of in marks.items():
        assert proofs.mark(of) == text
    for other in (row | {"x0_slip": 0.05 + 1e-7}, row | {"x0_slip": None}, row | {"mu0": 0.3}):
        assert proofs.mark(found.of("stiction", other)) == "–"
    assert proofs.mark(found.of("stiction", row | {"mu0": 0.5, "x0_slip": None})) == "✓"
    assert found.summary() == {"Proved": "2 numbers in 3 rows"}


def test_the_page_shows_proved_digits(whole):
    run = replace(RUN, proofs=read(ROOT / "tests/regression/paper/enclosures.csv", KEYS))
    page = Elements(report.page("paper", whole, [picture()], run))
    assert "proved = ✓" in page.text and "numbers in 297 rows" in page.text
    # θ = 2, μ0 = 0.4, and the state of Figure 8.
    assert "0.052838042795739907694…" in page.text and "22.982580886641143470…" in page.text
    assert "Proved" not in Elements(report.page("paper", whole, [picture()], RUN)).text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (float("nan"), "–"),
        (float("inf"), "∞"),
        (-0.5, "−0.5"),
        (3.25e-13, "3.25·10⁻¹³"),
        (True, "yes"),
        ("out_of_reach", "out of reach"),
        ("my_scan", "my_scan"),
    ],
)
def test_values_are_spelled(value, text):
    assert spell(value) == text


def test_benchmarks_are_summed_up_by_rule():
    text = "s\th:m:s\tmax_rss\n{}\t0:00:01\t{}\n".format
    times = facts.job_times({"a": [text(1.5, 10), text(2, "NA")], "none": [], "b": [text(4, 7)]})
    assert times.to_dict("records") == [
        {"rule": "a", "jobs": 2, "seconds": 3.5, "longest": 2.0, "memory": 10.0},
        {"rule": "b", "jobs": 1, "seconds": 4.0, "longest": 4.0, "memory": 7.0},
        {"rule": "all", "jobs": 3, "seconds": 7.5, "longest": 4.0, "memory": 10.0},
    ]
    assert facts.job_times({"none": []}).empty


def test_the_environment_names_the_software_and_neither_machine_nor_folder():
    found = facts.environment()
    assert found["vibrissa"].startswith(__version__)
    assert found["numpy"] == np.__version__
    assert int(found["cores"]) >= 1
    assert found["system"] == f"{platform.system()}, {platform.machine()}"
    named = {"vibrissa", "Python", "system", "cores", "made", *facts.LIBRARIES}
    assert found.keys() == named
    assert "/" not in "".join(found.values())


needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="no Chromium to look at the report with (Debian: apt install chromium)"
)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("chromium")) as page:
        yield page


@pytest.fixture
def opened(browser, whole, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(report.page("paper", whole, [picture()], RUN), encoding="utf-8")

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
    assert asked[0].startswith("file:")
    problems = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
    assert [page.params(problem) for problem in problems] == [[], [], []]


@needs_chromium
@pytest.mark.slow
def test_a_scan_of_the_study_is_played_over_its_own_numbers(opened):
    page = opened()
    page.evaluate(
        "(() => { const choice = document.querySelector('[data-x=preset]');"
        "choice.value = '5'; choice.dispatchEvent(new Event('change')); })()"
    )
    wait_until(page, f"{X0} > 0.02")
    page.evaluate("document.querySelector('[data-x=play]').click()")
    page.evaluate(
        "new Promise(requestAnimationFrame).then(() => new Promise(requestAnimationFrame))"
    )
    lines = page.evaluate(
        "['measured', 'curve'].map((name) =>"
        "document.querySelector(`svg[data-x=fy] .${name}`).getAttribute('d'))"
    )
    table, solved = (
        [tuple(map(float, place.split())) for place in re.split("[ML]", line)[1:]] for line in lines
    )
    # The line that the page has solved so far lies on that of the table, to a tenth of a pixel.
    assert 20 < len(solved) < len(table)
    assert np.allclose(solved, table[: len(solved)], atol=0.1)


@needs_chromium
@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_all_of_its_width(opened, scheme):
    page = opened(390, prefers_color_scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 23, 26)"
    assert dark == (scheme == "dark")
