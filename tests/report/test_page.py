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
from browser import CHROMIUM, chromium

from vibrissa import __version__, solve_curve, stick_slip
from vibrissa.paper import ledger
from vibrissa.paper.evidence import gather
from vibrissa.report import animation, facts, proofs, tables
from vibrissa.report import page as report
from vibrissa.report.spelling import spell
from vibrissa.study.codec import decode_grid
from vibrissa.tables import records, schemas, store
from vibrissa.tables.proofs import Proof, read

EVIL = "</script><script>throw 1</script><b>&\"'"
ROOT = Path(__file__).parents[2]
RUN = report.Run(study_files={"my.yaml": "study: mine"}, environment={"Python": "3"}, benchmarks={})
SVG = b'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"/>'


def picture(name="one", caption="A caption.", svg=SVG, png=b"png"):
    return report.Picture(name=name, caption=caption, svg=svg, png=png)


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
            judge=lambda _, v=verdict: v.because("a reason", {"number": (-0.00012345678, "1/L")}),
        )
        for verdict in ledger.Verdict
    ]
    return names | {
        "claims": ledger.claims_table(claims, found, study="paper", method="collocation")
    }


def test_the_same_tables_make_the_same_page(whole):
    first, second = (report.page("paper", whole, [picture()], RUN) for _ in range(2))
    assert first == second


def test_the_page_holds_what_the_tables_say(whole):
    text = Elements(report.page("paper", whole, [picture()], RUN)).text
    for said in ("221: 9 lock, 212 slip", "6, all slip", "2049", "A caption.", "study: mine"):
        assert said in text
    assert "not every step" not in text and "the first" not in text.partition("Tables")[0]
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
    assert page.count("script") == 2  # the data and the program
    assert ("b", {}) not in [e for e in page.found if e[0] == "b"][3:]  # Fx, Fy, M
    assert page.text.count(EVIL) > 10
    data = re.search(r'id="scans">(.*?)</script>', text, re.DOTALL)[1]
    assert json.loads(data)[0]["scan"] == EVIL


def test_a_study_may_have_nothing_but_points_that_failed():
    found = {"stiction": failed(schemas.STICTION, grids=["g"], message="try a thicker rod")}
    page = Elements(report.page("bad", found, [], RUN))
    assert "stiction: 1 row failed: try a thicker rod" in page.text
    assert not page.count("script") and not page.count("img")
    assert "Grid g" in page.text


def test_failed_scans_and_states_are_told_and_not_shown(study_tables):
    found = {
        "stiction": study_tables["stiction"],
        "scans": failed(schemas.SCANS, scan="runs"),
        "states": failed(schemas.STATES, state="low", message="it is too low"),
    }
    page = Elements(report.page("bad", found, [], RUN))
    assert "scans: 1 row failed" in page.text and "states: 1 row failed: it is too low" in page.text
    assert "Motion" not in page.text


def test_the_frames_are_the_tables_rows(study_tables):
    rows = study_tables["scans"].to_pandas()
    first = animation.runs(study_tables["scans"])[0]
    chosen = rows[(rows["theta"] == first["theta"]) & (rows["mu0"] == first["mu0"])]
    assert len(first["shape"]) == first["steps"] == len(chosen)
    for i in (0, 7, len(chosen) - 1):
        row = chosen.iloc[i]
        points = np.reshape(first["shapes"][first["shape"][i]], (-1, 2)) * animation.PRECISION
        kept = np.isin(np.round(row["shape_s"], 6), first["s"])
        shape = np.column_stack([row["shape_x"] - row["footpoint"], row["shape_y"]])[kept]
        assert np.abs(points - shape).max() <= 0.5001 * animation.PRECISION
        assert first["fx"][i] == pytest.approx(row["reaction_fx"], abs=1e-5)
        assert first["m"][i] == pytest.approx(row["reaction_m"], abs=1e-5)
    assert sum(first["slip"]) == 9
    assert len(first["shapes"]) < len(chosen) / 8


def test_long_scans_are_thinned_out_and_keep_their_slips(study_tables, monkeypatch):
    monkeypatch.setattr(animation, "MOST_FRAMES", 600)
    for run in animation.runs(study_tables["scans"]):
        assert len(run["shape"]) <= 100 + 2 * 9
        assert sum(run["slip"]) == 9
    monkeypatch.setattr(animation, "MOST_FRAMES", 60)
    assert all(len(run["shape"]) <= 10 for run in animation.runs(study_tables["scans"]))
    monkeypatch.setattr(animation, "MOST_SCANS", 2)
    assert len(animation.runs(study_tables["scans"])) == 2
    found = {name: study_tables[name] for name in ("stiction", "scans")}
    text = Elements(report.page("long", found, [], RUN)).text
    assert "not every step is shown" in text and "the first 2 of 6 scans" in text


@pytest.fixture(scope="module")
def swinging():
    """A scan of a locked rod that swings aside and is dragged, and one of a planar rod."""
    (point,) = decode_grid(dict(theta=("2",), mu0=("0.9",), eta=("0.85",), dx0=("0.01",))).points()
    return {
        section: records.scan_table(
            "runs", point, stick_slip(curve, 0.9, 0.01, 3), study="a", method=curve.method
        )
        for section in ("round", "planar")
        for curve in [solve_curve(2.0, 0.85, section=section)]
    }


def test_a_rod_that_swings_aside_is_seen_to_turn(swinging):
    (run,) = animation.runs(swinging["round"])
    assert run["turn"].count(0) == run["steps"] == len(swinging["round"])
    swings = np.flatnonzero(run["turn"])
    before, after = swings[0] - 1, swings[-1] + 1
    assert len(swings) == 11 and after - before == 12
    x = lambda i: np.reshape(run["shapes"][run["shape"][i]], (-1, 2))[:, 0]  # noqa: E731
    for i in swings:
        share = np.cos(np.radians(run["turn"][i]))
        assert x(i) == pytest.approx(share * x(before), abs=1.01)
        assert run["clamp"][i] == run["clamp"][before]
        assert run["fx"][i] == pytest.approx(share * run["fx"][before], abs=2e-5)
        assert run["m"][i] == pytest.approx(share * run["m"][before], abs=2e-5)
        assert run["fy"][i] == run["fy"][before]
    # The half turn ends in the next state of the table, up to the step of the clamp.
    assert x(after) == pytest.approx(-x(before), abs=0.01 / animation.PRECISION)
    text = Elements(report.page("a", {"scans": swinging["round"]}, [], RUN)).text
    assert "seen from the side while its plane turns" in text and "not every step" not in text


def test_what_the_frames_do_not_show_is_said_of_those_that_do_not_show_it(swinging, study_tables):
    locking, slipping = (
        animation.runs(found) for found in (swinging["planar"], study_tables["scans"])
    )
    said = facts.motion_notes(locking, swinging["planar"])
    assert len(said) == 1 and said[0].startswith("A self-locking tip never slips forward")
    assert facts.motion_notes(slipping, study_tables["scans"]) == []
    (turning,) = animation.runs(swinging["round"])
    assert len(facts.motion_notes([turning], swinging["round"])) == 2
    short = [run | {"steps": run["steps"] + 1} for run in slipping[:-1]]
    thinned, first = facts.motion_notes(short, study_tables["scans"])
    assert "not every step" in thinned and first == "These are the first 5 of 6 scans."


def test_a_planar_rod_and_a_slipping_tip_do_not_turn(swinging, study_tables):
    planar = swinging["planar"]
    rows = planar.to_pylist()
    assert rows[-1]["x1"] < rows[-1]["footpoint"]
    # As in an inclined clamp: the tip is behind it, but the rod has not yet left its plane.
    inclined = planar.from_pylist([row | {"stability_aside": 0.1} for row in rows], planar.schema)
    for scans in (planar, inclined, study_tables["scans"]):
        assert not any(any(run["turn"]) for run in animation.runs(scans))


def test_a_thinned_scan_keeps_both_sides_of_its_swing(swinging, monkeypatch):
    whole = animation.runs(swinging["round"])[0]
    monkeypatch.setattr(animation, "MOST_FRAMES", 20)
    (run,) = animation.runs(swinging["round"])
    assert len(run["shape"]) < 45 < len(whole["shape"])
    for one in (whole, run):
        swings = np.flatnonzero(one["turn"])
        assert np.diff([one["clamp"][i] for i in (swings[0], swings[-1] + 1)]) == pytest.approx(
            0.01
        )


def test_a_figure_of_very_many_lines_is_shown_as_pixels():
    assert picture().source.startswith("data:image/svg+xml;base64,")
    large = picture(svg=SVG + b" " * report.LARGEST_SVG)
    assert large.source == "data:image/png;base64,cG5n"


def test_key_rows_are_the_corners_and_the_middle(study_tables):
    rows = study_tables["stiction"].to_pandas()
    taper = rows[["taper" in grids for grids in rows["grids"]]]
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
    run = replace(RUN, proofs=read(ROOT / "tests/regression/paper/enclosures.csv", proofs.KEYS))
    page = Elements(report.page("paper", whole, [picture()], run))
    assert "proved = ✓" in page.text and "numbers in 243 rows" in page.text
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
STATE = """JSON.stringify([
    document.querySelector('#stage .rod').getAttribute('d'),
    ...['fx', 'fy', 'm'].map((n) => document.querySelector(`#signal-${n} output`).textContent),
    document.querySelector('#signal-fx .mark').getAttribute('d'),
    document.getElementById('step').value,
])"""


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


def state(page):
    return json.loads(page.evaluate(STATE))


def wait_until(page, condition):
    page.evaluate(f"""new Promise((done, fail) => {{
        const end = Date.now() + 20000;
        const look = () => ({condition}) ? done(true)
            : Date.now() > end ? fail('never') : setTimeout(look, 20);
        look();
    }})""")


@needs_chromium
@pytest.mark.slow
def test_nothing_is_asked_of_the_network_and_nothing_goes_wrong(opened):
    page = opened()
    page.evaluate("document.getElementById('play').click()")
    wait_until(page, "Number(document.getElementById('step').value) > 2")
    asked = [event["request"]["url"] for event in page.params("Network.requestWillBeSent")]
    assert [url for url in asked if not url.startswith("data:")] == [asked[0]]
    assert asked[0].startswith("file:")
    problems = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
    assert [page.params(problem) for problem in problems] == [[], [], []]


@needs_chromium
@pytest.mark.slow
def test_play_moves_the_rod_and_pause_stops_it(opened):
    page = opened()
    before = state(page)
    page.evaluate("document.getElementById('play').click()")
    assert page.evaluate("document.getElementById('play').textContent") == "Pause"
    wait_until(page, "Number(document.getElementById('step').value) > 2")
    page.evaluate("document.getElementById('play').click()")
    after = state(page)
    assert all(old != new for old, new in zip(before, after, strict=True))
    page.evaluate("new Promise((done) => setTimeout(done, 300))")
    assert state(page) == after
    assert page.evaluate("document.getElementById('play').textContent") == "Play"


@needs_chromium
@pytest.mark.slow
def test_the_slider_shows_the_tables_row(opened, whole):
    page = opened()
    page.evaluate("document.getElementById('scan').value = 5")
    page.evaluate("document.getElementById('scan').dispatchEvent(new Event('change'))")
    page.evaluate("document.getElementById('step').value = 30")
    page.evaluate("document.getElementById('step').dispatchEvent(new Event('input'))")
    rows = whole["scans"].to_pandas()
    *_, (_, chosen) = rows.groupby(list(tables.SCAN), sort=False)
    shown = state(page)
    for text, name in zip(shown[1:4], tables.REACTIONS, strict=True):
        value = round(chosen[name].iloc[30], 5)
        assert float(text.replace("−", "-")) == pytest.approx(value, abs=0.6e-4)
    assert f"{chosen['footpoint'].iloc[30]:.4f}" in page.evaluate(
        "document.getElementById('where').textContent"
    )


@needs_chromium
@pytest.mark.slow
def test_a_rod_that_swings_aside_turns_in_the_browser(browser, swinging, tmp_path):
    path = tmp_path / "swinging.html"
    path.write_text(report.page("a", {"scans": swinging["round"]}, [], RUN), encoding="utf-8")
    browser.open(path.as_uri())
    (run,) = animation.runs(swinging["round"])
    half = run["turn"].index(90)
    browser.evaluate(f"document.getElementById('step').value = {half}")
    browser.evaluate("document.getElementById('step').dispatchEvent(new Event('input'))")
    said = browser.evaluate("document.getElementById('phase').textContent")
    assert said == "swings aside, turned by 90°"
    # Edge on, the rod is seen as a straight line above its clamp, as thick as its base.
    width = browser.evaluate("document.querySelector('#stage .rod').getBBox().width")
    assert width == pytest.approx(2 * 14, abs=0.5)


@needs_chromium
@pytest.mark.slow
def test_the_keyboard_is_enough(opened):
    page = opened()
    page.evaluate("document.getElementById('step').focus()")
    page.press("ArrowRight", 39)
    page.press("ArrowRight", 39)
    assert state(page)[-1] == "2"
    page.press("End", 35)
    assert "cycle 9: has just slipped" in page.evaluate(
        "document.getElementById('step').getAttribute('aria-valuetext')"
    )
    page.evaluate("document.getElementById('play').focus()")
    page.press(" ", 32)  # from the end it starts anew
    wait_until(page, "Number(document.getElementById('step').value) < 20")
    assert page.evaluate("document.getElementById('play').textContent") == "Pause"


@needs_chromium
@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phone_shows_all_of_its_width(opened, scheme):
    page = opened(390, prefers_color_scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 23, 26)"
    assert dark == (scheme == "dark")
