"""The explorer's page in a browser: what it shows, says and writes."""

import json
import math
import re
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import pytest
import yaml

from known import Known
from validation.browser import CHROMIUM
from vibrissa import Mounting, solve_curve, stick_slip
from vibrissa.explorer.__main__ import main
from vibrissa.explorer.modules import bundle
from vibrissa.explorer.page import (
    FOLDER,
    MOUNTED,
    PAPER,
    RANGES,
    Preset,
    fits,
    fragment,
    page,
    program,
    style,
)
from vibrissa.sensor import surfaces
from vibrissa.sensor.response.branch import respond
from vibrissa.sensor.simulation.slips import SlipLaw, Slips

KNOWN = Known(__file__)
needs_chromium = [
    pytest.mark.skipif(
        CHROMIUM is None, reason="no Chromium to open the page with (Debian: apt install chromium)"
    ),
    pytest.mark.slow,
]


def test_presets_are_the_figures_of_the_paper():
    study = yaml.safe_load((Path(__file__).parents[2] / "config.yaml").read_text())
    for preset in PAPER:
        name = "fig" + preset.name.partition(":")[0].removeprefix("Figure ")
        figure = study["figures"][name]
        assert preset.settings["theta"] == figure.get("theta", preset.settings["theta"])
        assert preset.settings["mu0"] == figure.get("mu0", preset.settings["mu0"])
        assert preset.settings["eta"] == (0.55 if name == "fig8" else 0.85)
    # Figures 4 and 5 are their parts side by side.
    assert len({preset.name for preset in PAPER}) == len(study["figures"].keys() - {"fig4", "fig5"})


def test_what_a_user_can_choose_is_known():
    """Where the clamp stands, which fields are set and to what, and what is said to it."""
    KNOWN.check("presets", [vars(preset) for preset in (*PAPER, *MOUNTED)])
    assert all(fits(preset.settings) for preset in (*PAPER, *MOUNTED))


@pytest.mark.parametrize("name", RANGES)
def test_settings_beyond_a_field_do_not_fit(name):
    low, high = RANGES[name]
    assert fits({name: low}) and fits({name: high}) and fits({"other": 99.0})
    assert not fits({name: low - 1e-6}) and not fits({"theta": 2.0, name: high + 1e-6})


def test_only_a_page_that_is_part_of_a_site_links_to_it():
    assert "<a " not in page()
    assert '<a href="index.html">Documentation</a>' in page(home="index.html")
    assert '<a href="a&#34;b">' in page(home='a"b')


def test_the_page_holds_its_parts_as_they_are():
    text = page()
    (presets,) = re.findall(r'data-x="presets">(.*?)</script>', text)
    assert json.loads(presets) == [asdict(preset) for preset in (*PAPER, *MOUNTED)]
    # Short, as a report has one for each of its scans.
    assert ", " not in re.sub('"note":".*?"', "", presets)
    assert text.count(style()) == text.count(program()) == 1
    assert program().startswith('(() => {\n"use strict";') and program().endswith("})();")


def test_the_page_and_python_know_the_same_ranges():
    text = (FOLDER / "view/settings.js").read_text(encoding="utf-8")
    fields = re.findall(r'key: "(\w+)",.*? min: (\S+), max: (\S+),', text)
    found = {key: (float(low), float(high)) for key, low, high in fields}
    in_si = ("modulus", "diameter", "length")
    assert {key: ends for key, ends in found.items() if key not in in_si} == RANGES


def test_a_name_in_a_preset_cannot_end_the_script():
    text = fragment([Preset(name="</script>", settings={})])
    assert text.count("</script>") == 1
    (presets,) = re.findall(r'data-x="presets">(.*?)</script>', text)
    assert json.loads(presets) == [
        dict(name="</script>", note="", settings={}, clamp=0.0, play=False, recording=None)
    ]


def test_the_file_is_written_whole_or_a_line_says_why_not(tmp_path, capsys):
    path = tmp_path / "new/folder/explorer.html"
    assert main([str(path)]) == "" and path.read_text() == page()
    assert capsys.readouterr().out == f"open {path.as_uri()} in a browser\n"
    # Once more, into a folder that is there.
    assert main([str(path)]) == ""
    assert "say where to" in main([]) and "say where to" in main([str(path), "more"])
    assert "cannot be written" in main([str(path / "below.html")])


@pytest.mark.slow
def test_the_module_says_by_its_status_whether_it_has_written(tmp_path):
    command = [sys.executable, "-m", "vibrissa.explorer"]
    assert subprocess.run([*command, str(tmp_path / "explorer.html")], timeout=60).returncode == 0
    assert subprocess.run(command, capture_output=True, timeout=60).returncode == 1


def wait_until(browser, condition):
    browser.evaluate(f"""new Promise((done, fail) => {{
        const end = Date.now() + 20000;
        const look = () => ({condition}) ? done(true)
            : Date.now() > end ? fail('never: ' + document.querySelector('.said')?.innerText)
            : setTimeout(look, 20);
        look();
    }})""")


@pytest.fixture
def opened(browser, tmp_path):
    path = tmp_path / "explorer.html"
    path.write_text(page(), encoding="utf-8")

    def open_at(address="", width=1200, **media):
        browser.open("about:blank")
        browser.open(f"{path.as_uri()}#{address}", width, **media)
        wait_until(browser, "document.querySelector('.stage .rod')?.getAttribute('d')?.length > 99")
        return browser

    return open_at


def value(browser, key):
    text = browser.evaluate(f"document.querySelector('[data-value={key}]').textContent")
    return float(text.replace("−", "-"))


def said(browser):
    return browser.evaluate("document.querySelector('.said').innerText")


def drag(browser, pixels):
    """Drag the clamp by pixels, in steps as a hand does."""
    box = browser.evaluate(
        "(() => { const b = document.querySelector('.stage .clamp').getBoundingClientRect();"
        "return [b.x + b.width / 2, b.y + b.height / 2]; })()"
    )
    for kind, part in [("mousePressed", 0), *(("mouseMoved", k / 20) for k in range(1, 21))]:
        mouse = {"type": kind, "x": box[0] + part * pixels, "y": box[1]}
        browser.call("Input.dispatchMouseEvent", button="left", buttons=1, clickCount=1, **mouse)
        browser.evaluate("new Promise(requestAnimationFrame)")
    browser.call("Input.dispatchMouseEvent", button="left", **(mouse | {"type": "mouseReleased"}))
    browser.evaluate(
        "new Promise(requestAnimationFrame).then(() => new Promise(requestAnimationFrame))"
    )


class TestPage:
    pytestmark = needs_chromium

    def test_nothing_is_asked_of_the_network_and_nothing_goes_wrong(self, opened):
        browser = opened()
        drag(browser, 150)
        browser.evaluate("document.querySelector('[data-x=play]').click()")
        browser.evaluate("new Promise((done) => setTimeout(done, 500))")
        asked = [e["request"]["url"] for e in browser.params("Network.requestWillBeSent")]
        assert [url for url in asked if not url.startswith(("data:", "file:"))] == []
        problems = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")
        assert [browser.params(problem) for problem in problems] == [[], [], []]

    def test_the_values_are_those_of_python(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.9&clamp=0.1")
        state = solve_curve(2, 0.85).state(0.1)
        for key, expected in {
            "x0": 0.1,
            "f": state.f,
            "alpha": state.alpha,
            "phi1": state.phi1,
            "fx": state.reaction_fx,
            "m": state.reaction_m,
            "lock": 0.4775714,
        }.items():
            assert value(browser, key) == pytest.approx(float(expected), rel=6e-4)

    def test_a_dragged_clamp_bends_the_rod_until_its_tip_slips(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        before = browser.evaluate("document.querySelector('.stage .rod').getAttribute('d')")
        drag(browser, 10)
        assert 0.01 < value(browser, "x0") < 0.05 and value(browser, "fx") < 0
        assert browser.evaluate("document.querySelector('.stage .rod').getAttribute('d')") != before
        drag(browser, 100)
        wait_until(browser, "document.querySelector('.said').innerText.includes('slips ahead')")
        assert "0.05284" in said(browser)

    @pytest.mark.parametrize(
        ("address", "words"),
        [
            ("theta=2&eta=0.85&mu0=0.9&clamp=0.2", "locked"),
            ("theta=2&eta=0.85&mu0=0.9&clamp=0.5", "behind the clamp"),
            ("theta=1&eta=0.85&mu0=0.9&section=planar&clamp=1", "snaps through"),
            ("theta=3&eta=0.75&mu0=0.9&contact=line&clamp=0.2", "lies on the surface"),
            ("theta=2&eta=0.85&mu0=0.4&clamp=-0.1", "The clamp pulls"),
            ("theta=2&eta=0.85&mu0=0.9&beta=5&clamp=0.6", "not computed in this mounting"),
            ("theta=99&mu0=x", "θ must lie between 1 and 20"),
        ],
    )
    def test_what_happens_is_said(self, opened, address, words):
        browser = opened(address)
        wait_until(browser, f"document.querySelector('.said').innerText.includes('{words}')")

    def test_a_mounting_is_said_and_drawn_and_stands_in_the_address(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        upright = value(browser, "slip")
        seen = "document.querySelector('[data-x=mounted]').textContent"
        assert browser.evaluate(seen).startswith("ideal")
        browser.evaluate("""(() => { const box = document.getElementById('x-beta');
            box.value = '5'; box.dispatchEvent(new Event('input')); })()""")
        wait_until(browser, f"{seen}.includes('inclined by 5°')")
        wait_until(browser, "document.querySelector('.said').innerText.includes('leans back')")
        turned = "document.querySelector('.stage .clamp path').getAttribute('transform')"
        assert browser.evaluate(turned).startswith("rotate(-5 ")
        curve = solve_curve(2, 0.85, mounting=Mounting(clamp_angle=math.radians(5)))
        assert value(browser, "slip") == pytest.approx(float(curve.onset(0.4)), rel=6e-4)
        assert value(browser, "slip") > 1.2 * upright
        wait_until(browser, "location.hash.includes('beta=5')")

    def test_the_keyboard_is_enough(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4&dx0=0.01")
        browser.evaluate("document.querySelector('.stage .clamp').focus()")
        for _ in range(3):
            browser.press("ArrowRight", 39)
        wait_until(browser, "document.querySelector('[data-value=x0]').textContent === '0.03000'")
        seen = "document.querySelector('.stage .clamp').getAttribute('aria-valuetext')"
        assert browser.evaluate(seen) == "0.03000 L, sticks"
        browser.press("Home", 36)
        wait_until(browser, "document.querySelector('[data-value=x0]').textContent === '0'")
        named = """[...document.querySelectorAll('.explorer :is(input, select, button)')].every(
            (n) => n.ariaLabel || n.labels?.length || n.textContent)"""
        assert browser.evaluate(named)

    def test_the_address_brings_everything_back(self, opened):
        browser = opened("theta=3&eta=0.7&mu0=0.35&contact=line&law=kinetic&ratio=0.6&units=si")
        drag(browser, 30)
        wait_until(browser, "location.hash.includes('clamp=')")
        address, x0 = browser.evaluate("location.hash.slice(1)"), value(browser, "x0")
        again = opened(address)
        assert value(again, "x0") == pytest.approx(x0, abs=1e-3)
        assert again.evaluate("location.hash.slice(1)") == address

    def test_a_number_that_is_not_allowed_is_told_and_not_taken(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        type_in = """((text) => { const box = document.getElementById('x-theta');
            box.value = text; box.dispatchEvent(new Event('input')); })"""
        browser.evaluate(f"{type_in}('0.5')")
        message = "document.querySelector('[data-key=theta] .mistake').textContent"
        assert browser.evaluate(message) == "from 1 to 20"
        assert value(browser, "slip") == pytest.approx(0.05284)
        browser.evaluate(f"{type_in}('1')")
        wait_until(browser, "document.querySelector('[data-value=slip]').textContent !== '0.05284'")
        assert browser.evaluate(message) == ""

    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_a_phone_shows_all_of_its_width(self, opened, scheme):
        browser = opened(width=390, prefers_color_scheme=scheme)
        assert browser.evaluate("document.documentElement.scrollWidth") == 390
        dark = browser.evaluate("getComputedStyle(document.body).backgroundColor")
        assert (dark == "rgb(20, 23, 26)") == (scheme == "dark")

    @pytest.mark.parametrize("width", [390, 820, 1040, 1300, 3840])
    def test_no_field_covers_another_and_no_label_is_cut(self, opened, width):
        browser = opened("theta=2&law=kinetic&units=si&beta=5&kappa0=-0.2&delta=1", width=width)
        browser.evaluate("document.querySelector('.explorer .mounting').open = true")
        cut = """[...document.querySelectorAll('.explorer :is(.field label, .choice span, dt)')]
            .filter((n) => getComputedStyle(n).display !== 'inline')
            .filter((n) => n.scrollWidth > n.clientWidth + 1)
            .map((n) => n.textContent)"""
        assert browser.evaluate(cut) == []
        covered = """(() => {
            const boxes = [...document.querySelectorAll(
                '.explorer :is(.field input, .field label, .choice legend, .choice label)')]
                .map((n) => [n.id || n.textContent, n.getBoundingClientRect()])
                .filter(([, b]) => b.width > 0);
            const over = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2
                && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2;
            return boxes.flatMap(([name, a], i) =>
                boxes.slice(i + 1).filter(([, b]) => over(a, b)).map(([other]) => [name, other]));
        })()"""
        assert browser.evaluate(covered) == []

    def test_a_recording_is_drawn_with_the_curves(self, opened, tmp_path):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        path = tmp_path / "scan.csv"
        path.write_text(
            "footpoint [mm],force_x [N],force_y [N],moment_z [N*m]\n0,0,-1,0\n9,-1,-2,0\n"
        )
        node = browser.call("DOM.getDocument")["root"]["nodeId"]
        box = browser.call("DOM.querySelector", nodeId=node, selector="[data-x=file]")["nodeId"]
        browser.call("DOM.setFileInputFiles", nodeId=box, files=[str(path)])
        drawn = "document.querySelector('svg[data-x=fy] .measured').getAttribute('d')"
        wait_until(browser, f"{drawn}.includes('L')")

    def test_drawings_are_exported(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        browser.evaluate(
            "URL.createObjectURL = (blob) => { window.made = blob; return 'data:,'; };"
            "HTMLAnchorElement.prototype.click = () => {}; 0"
        )
        browser.evaluate("document.querySelector('button[data-x=svg]').click()")
        text = browser.evaluate("window.made.text()")
        assert text.startswith("<svg") and text.count("<svg") == 8 and "Sticking curve" in text
        assert "var(" not in text
        browser.evaluate("window.made = null; document.querySelector('button[data-x=png]').click()")
        wait_until(browser, "window.made?.type === 'image/png'")
        assert browser.evaluate("createImageBitmap(window.made).then((i) => i.width)") > 2000


@pytest.fixture
def functions(browser):
    """Functions of the page without the page."""
    browser.open("about:blank")
    script = bundle(
        "solver/motion.js", "view/recording.js", "view/settings.js", "view/model.js", "view/svg.js"
    )
    browser.evaluate(f"{script}; 0")
    return browser


class TestFunctions:
    pytestmark = needs_chromium

    @pytest.mark.parametrize(
        ("value", "text"),
        [
            (0, "0"),
            (0.5, "0.5000"),
            (-12345.6, "−12346"),
            (1.2345e-5, "1.234e−5"),
            (-1e-9, "−1.000e−9"),
        ],
    )
    def test_numbers_are_written_to_four_digits(self, functions, value, text):
        assert functions.evaluate(f"significant({value})") == text

    def test_rounding_errors_are_nothing(self, functions):
        assert functions.evaluate("[1e-13, -1e-13, 1e-9].map(withoutNoise)") == [0, 0, 1e-9]

    def stepped_as(self, rows, functions, settings):
        """Compare the steps of the page's clamp with those of a scan."""
        count = len(rows.footpoint)
        found = json.loads(
            functions.evaluate(f"""(() => {{
                const model = new Model();
                model.change({json.dumps(settings)});
                model.restart();
                for (let k = 1; k < {count}; k += 1) model.step();
                return JSON.stringify(
                    model.trace.map((row) => [row.clamp, row.contact, row.fx, row.fy, row.m]));
            }})()""")
        )
        state = rows.state
        expected = (rows.footpoint, rows.x1, state.reaction_fx, state.reaction_fy, state.reaction_m)
        assert len(found) == count
        for got, *row in zip(found, *expected, strict=True):
            assert got == pytest.approx(row, abs=1e-8)

    @pytest.mark.parametrize(("mu0", "contact"), [(0.3, "point"), (0.9, "point"), (0.3, "line")])
    def test_steps_are_those_of_a_study(self, functions, mu0, contact):
        theta, eta, dx0 = 2.0, 0.7, 0.01
        rows = stick_slip(solve_curve(theta, eta, contact=contact), mu0, dx0, 3)
        settings = {"theta": theta, "eta": eta, "mu0": mu0, "dx0": dx0, "contact": contact}
        self.stepped_as(rows, functions, settings)

    @pytest.mark.parametrize(
        ("settings", "mounting"),
        [
            ({"beta": 5.0, "kappa0": -0.2}, {"clamp_angle": 5.0, "curvature": -0.2}),
            ({"compliance": 0.1}, {"clamp_compliance": 0.1}),
            ({"delta": 3.0, "kappa1": -0.1}, {"stage_angle": 3.0, "curvature": (0, -0.1)}),
            ({"delta": -3.0}, {"stage_angle": -3.0}),
        ],
    )
    def test_steps_in_other_mountings_are_those_of_a_study(self, functions, settings, mounting):
        angles = ("clamp_angle", "stage_angle")
        given = {k: math.radians(v) if k in angles else v for k, v in mounting.items()}
        rows = stick_slip(solve_curve(2.0, 0.8, mounting=Mounting(**given)), 0.3, 0.005, 4)
        assert len(rows.footpoint) > 8
        self.stepped_as(
            rows, functions, {"theta": 2.0, "eta": 0.8, "mu0": 0.3, "dx0": 0.005} | settings
        )

    @pytest.mark.parametrize("law", ["free", "kinetic", "energy"])
    @pytest.mark.parametrize("pulled", [False, True])
    def test_slips_end_where_the_sensor_says(self, functions, law, pulled):
        theta, eta, mu0, ratio = 2.0, 0.8, 0.35, 0.8
        friction = json.dumps({"mu0": mu0, "ratio": ratio, "law": law})
        start, found = functions.evaluate(f"""(() => {{
            const rod = {{ theta: {theta}, eta: {eta}, contact: "point", round: true }};
            const sticking = stickingOf(solvedPath(rod).path, {friction});
            const x0 = {"sticking.low" if pulled else "sticking.high"};
            return [x0, restOf(sticking, x0)];
        }})()""")
        response = respond(theta, eta)
        slips = Slips(
            response=response, surface=surfaces.constant(mu0), law=SlipLaw(law), ratio=ratio
        )
        assert found == pytest.approx(slips.rest(0.0, start), abs=2e-6)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("", "the first line must name columns"),
            ("force_x,force_y\n1,2\n", "footpoint is needed"),
            ("footpoint [mm]\n1\n", "the first line must name columns"),
            ("footpoint [N],force_x\n1,2\n", "“N” is not a unit of length"),
            ("footpoint,force_x\n1,2\n1,two\n", "line 3: “two” is not a number"),
            ("footpoint,force_x\n\n", "there is no sample"),
        ],
    )
    def test_a_file_that_is_no_recording_is_told(self, functions, text, message):
        found = functions.evaluate(f"readRecording('a.csv', {json.dumps(text)}, DEFAULTS).message")
        assert message in found

    def test_units_of_a_recording(self, functions):
        # E·I0 = 210 GPa · π · 1 mm⁴ / 64, L = 100 mm
        stiffness = 210e3 * 3.141592653589793 / 64
        text = "moment_z [µN·m];footpoint (cm);force_x [mN]\n1000;5;1030.835\n;5;nan\n"
        found = functions.evaluate(
            f"readRecording('a.csv', {json.dumps(text)}, DEFAULTS).recording"
        )
        assert found["clamp"] == pytest.approx([0.5, 0.5])
        assert found["fx"][0] == pytest.approx(1.030835 * 1e4 / stiffness)
        assert found["m"][0] == pytest.approx(1 * 100 / stiffness)
        assert found["fx"][1] is None and found["fy"] == []
