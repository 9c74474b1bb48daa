"""The explorer's page in a browser: what it shows, says and writes."""

import json
import math
import re
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
import yaml

from responses import respond
from validation.browser import CHROMIUM
from vibrissa import Mounting, solve_curve, stick_slip
from vibrissa.explorer.__main__ import main
from vibrissa.explorer.modules import bundle
from vibrissa.explorer.page import (
    FOLDER,
    MOUNTED,
    PAPER,
    RANGES,
    WAVES,
    Preset,
    fits,
    fragment,
    page,
    program,
    style,
)
from vibrissa.scanning import surfaces
from vibrissa.scanning.slip import Slip
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.scanning.stage import Stage

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
    # Figures 4 and 5 are their parts side by side; others explain what the paper's figures show.
    of_paper = {name for name in study["figures"] if name.startswith("fig") and name[3].isdigit()}
    assert len({preset.name for preset in PAPER}) == len(of_paper - {"fig4", "fig5"})


@pytest.mark.parametrize("name", RANGES)
def test_settings_beyond_a_field_do_not_fit(name):
    assert all(fits(preset.settings) for preset in (*PAPER, *MOUNTED, *WAVES))
    low, high = RANGES[name]
    assert fits({name: low}) and fits({name: high}) and fits({"other": 99.0})
    assert not fits({name: low - 1e-6}) and not fits({"theta": 2.0, name: high + 1e-6})


def test_the_page_holds_its_parts_as_they_are():
    text = page()
    (presets,) = re.findall(r'data-x="presets">(.*?)</script>', text)
    assert json.loads(presets) == [asdict(preset) for preset in (*PAPER, *MOUNTED, *WAVES)]
    assert text.count(style()) == text.count(program()) == 1 and "<a " not in text
    linked = page(home='a"b/index.html')
    assert '<a href="a&#34;b/index.html">' in linked and '<a href="a&#34;b/model.html">' in linked


def test_the_page_and_python_know_the_same_ranges():
    text = (FOLDER / "view/settings.js").read_text(encoding="utf-8")
    fields = re.findall(r'key: "(\w+)",.*? min: (\S+), max: (\S+),', text)
    found = {key: (float(low), float(high)) for key, low, high in fields}
    in_si = ("modulus", "diameter", "length")
    assert {key: ends for key, ends in found.items() if key not in in_si} == RANGES


def test_a_name_in_a_preset_cannot_end_the_script():
    text = fragment([Preset(name="</script>", settings={})])
    assert text.count("</script>") == 1


def test_the_file_is_written_whole_or_a_line_says_why_not(tmp_path, capsys, monkeypatch):
    path = tmp_path / "new/folder/explorer.html"
    main([str(path)])
    assert path.read_text() == page()
    assert capsys.readouterr().out == f"open {path.as_uri()} in a browser\n"
    # Once more, into a folder that is there.
    main([str(path)])
    with pytest.raises(SystemExit, match="cannot be written"):
        main([str(path / "below.html")])
    monkeypatch.setattr("vibrissa.extras.find_spec", lambda name: None)
    with pytest.raises(SystemExit, match=r"jinja2, yaml: pip install 'vibrissa\[workflow\]'"):
        main([str(path)])


@pytest.mark.slow
def test_the_module_tells_how_to_use_it():
    command = [sys.executable, "-m", "vibrissa.explorer", "--help"]
    assert b"vibrissa.explorer [-h] file" in subprocess.check_output(command, timeout=60)


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

    def open_at(address="", width=1200, height=900, **media):
        browser.open("about:blank")
        browser.open(f"{path.as_uri()}#{address}", width, height, **media)
        wait_until(browser, "document.querySelector('.stage .rod')?.getAttribute('d')?.length > 99")
        return browser

    return open_at


def seen(browser, selector, of="textContent"):
    return browser.evaluate(f"document.querySelector({json.dumps(selector)}).{of}")


def value(browser, key):
    return float(seen(browser, f"[data-value={key}]").replace("−", "-"))


def said(browser):
    return seen(browser, ".said", "innerText")


def click(browser, selector):
    seen(browser, selector, "click()")


def type_in(browser, key, text):
    """Type into a field, and leave it."""
    browser.evaluate(f"""(() => {{ const box = document.getElementById('x-{key}');
        box.focus(); box.value = {json.dumps(text)}; box.dispatchEvent(new Event('input'));
        box.dispatchEvent(new Event('change')); box.blur(); }})()""")
    frames(browser)


def frames(browser):
    browser.evaluate("new Promise((done) => setTimeout(() => requestAnimationFrame(done), 60))")


def at_rest(browser, selector):
    """Middle of an element, as soon as three frames have left it where it is."""
    return browser.evaluate(f"""new Promise((done, fail) => {{
        const end = Date.now() + 20000;
        let [before, frames] = ['', 0];
        const look = () => {{
            const b = document.querySelector({json.dumps(selector)})?.getBoundingClientRect();
            const now = JSON.stringify(b);
            frames = b && now === before ? frames + 1 : 0;
            before = now;
            if (frames === 3) done([b.x + b.width / 2, b.y + b.height / 2]);
            else if (Date.now() > end) fail({json.dumps(selector)} + ' does not come to rest');
            else requestAnimationFrame(look);
        }};
        look();
    }})""")


def drag(browser, right, selector=".stage .clamp", down=0):
    """Drag something by pixels, in steps as a hand does."""
    x, y = at_rest(browser, selector)
    mouse = {"button": "left", "buttons": 1, "clickCount": 1}
    for kind, part in [("mousePressed", 0), *(("mouseMoved", k / 20) for k in range(1, 21))]:
        place = {"x": x + part * right, "y": y + part * down}
        browser.call("Input.dispatchMouseEvent", type=kind, **mouse, **place)
        browser.evaluate("new Promise(requestAnimationFrame)")
    browser.call("Input.dispatchMouseEvent", type="mouseReleased", button="left", **place)
    frames(browser)


POINT, HANDLE = "svg[data-x=sticking] .now", "svg[data-x=sticking] .handle"
BOX = "getBoundingClientRect().toJSON()"


class TestPage:
    pytestmark = needs_chromium

    def test_nothing_is_asked_of_the_network_and_nothing_goes_wrong(self, opened):
        browser = opened()
        drag(browser, 150)
        click(browser, "[data-x=play]")
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
        before = seen(browser, ".stage .rod", "getAttribute('d')")
        drag(browser, 10)
        assert 0.01 < value(browser, "x0") < 0.05 and value(browser, "fx") < 0
        assert seen(browser, ".stage .rod", "getAttribute('d')") != before
        drag(browser, 100)
        wait_until(browser, "document.querySelector('.said').innerText.includes('x0 reset to 0')")
        assert "slipped at x0 = 0.05284 L" in said(browser)
        # The slip leaves the old rod and the length of its jump.
        assert seen(browser, ".labels .jump-length") == "0.05284 L"
        assert len(seen(browser, ".stage .slipped", "getAttribute('d')")) > 99
        click(browser, "[data-x=restart]")
        wait_until(
            browser, "document.querySelector('.stage .slipped').getAttribute('d') === 'M0 0'"
        )

    @pytest.mark.parametrize(
        ("address", "words"),
        [
            ("mu0=0.9&clamp=0,2", "Locked"),
            ("theta=2&eta=0.85&mu0=0.9&clamp=0.5", "behind the clamp"),
            ("theta=1&eta=0.85&mu0=0.9&section=planar&clamp=1", "snapped through"),
            ("theta=3&eta=0.75&mu0=0.9&contact=line&clamp=0.2", "lies on the surface"),
            ("theta=2&eta=0.85&mu0=0.4&clamp=-0.1", "Pulled by the clamp"),
            ("theta=2&eta=0.85&mu0=0.9&beta=5&clamp=0.6", "not computed in this mounting"),
            ("theta=2&law=energy&ratio=0.3&clamp=0.1", "released so much energy"),
            ("theta=99&mu0=x", "θ in the address: must be from 1 to 20"),
            ("clamp=abc&side=behind", "clamp in the address: “abc” is not a number"),
            ("theta=2&pin=x", "a pin in the address has no settings"),
            ("mu0=0.3&amplitude=0.0001&clamp=0.05", "The tip slipped by"),
            ("tetha=3", "tetha in the address is not a known key"),
            ("side=-1&clamp=0.005", "dragged, behind the clamp"),
            ("theta=2" + 4 * "&pin=eta%3D0.9", "only the first 3 pins"),
        ],
    )
    def test_what_happens_is_said_once(self, opened, address, words):
        browser = opened(address)
        wait_until(browser, f"document.querySelector('.said').innerText.includes('{words}')")
        live = "document.querySelectorAll('[aria-live], [role=alert], output').length"
        assert browser.evaluate(live) == 1

    def test_a_mounting_is_drawn_and_stands_in_the_address(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        assert seen(browser, "[data-x=mounted]").startswith("ideal")
        type_in(browser, "beta", "5")
        type_in(browser, "delta", "3")
        wait_until(browser, "location.hash.includes('beta=5') && location.hash.includes('delta=3')")
        assert seen(browser, "[data-x=mounted]") == "β = 5°, δ = 3°"
        turned = "getAttribute('transform')"
        assert seen(browser, ".stage .clamp path", turned).startswith("rotate(-5 ")
        rail = seen(browser, ".rail", "getAttribute('d')")
        left, right, end = map(float, re.fullmatch(r"M0 (\S+)L(\S+) (\S+)", rail).group(1, 2, 3))
        assert math.degrees(math.atan2(left - end, right)) == pytest.approx(3)
        assert seen(browser, ".labels .delta") == "δ = 3.0°"
        type_in(browser, "delta", "0")
        curve = solve_curve(2, 0.85, mounting=Mounting(clamp_angle=math.radians(5)))
        assert value(browser, "slip") == pytest.approx(float(curve.onset(0.4)), rel=6e-4)

    def test_the_keyboard_is_enough(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4&dx0=0.01")
        seen(browser, ".stage .clamp", "focus()")
        for _ in range(3):
            browser.press("ArrowRight", 39)
        wait_until(browser, "document.querySelector('[data-value=x0]').textContent === '0.03000'")
        words = seen(browser, ".stage .clamp", "getAttribute('aria-valuetext')")
        assert words == "0.03000 L, sticks"
        seen(browser, POINT, "focus()")
        browser.press("PageUp", 33)
        # The point stays where the tip sticks.
        wait_until(browser, "document.querySelector('[data-value=x0]').textContent === '0.05284'")
        seen(browser, HANDLE, "focus()")
        browser.press("ArrowUp", 38)
        wait_until(browser, "document.getElementById('x-mu0').value === '0.405'")
        seen(browser, ".stage .clamp", "focus()")
        browser.press("Home", 36)
        wait_until(browser, "document.querySelector('[data-value=clamp]').textContent === '0'")
        named = """[...document.querySelectorAll('.explorer :is(input, select, button, .clamp)')]
            .every((n) => n.ariaLabel || n.labels?.length || n.textContent)"""
        assert browser.evaluate(named)

    def test_a_link_brings_everything_back(self, opened):
        browser = opened("theta=3&eta=0.7&mu0=0.35&contact=line&law=kinetic&ratio=0.6&units=si")
        click(browser, "[data-x=pin]")
        type_in(browser, "theta", "2")
        drag(browser, 60)
        # The address is written 0.3 s after the last change; timers end in their order.
        browser.evaluate("new Promise((done) => setTimeout(done, 400))")
        wait_until(browser, "location.hash.includes('x0=') && location.hash.includes('pin=')")
        address, x0 = browser.evaluate("location.hash.slice(1)"), value(browser, "x0")
        again = opened(address)
        assert value(again, "x0") == x0 and seen(again, ".pinname").startswith("pinned: θ = 3")
        assert again.evaluate("location.hash.slice(1)") == address
        click(again, "[data-x=reset]")
        wait_until(again, "location.hash === '#theta=2&eta=0.85&mu0=0.4'")

    @pytest.mark.parametrize(
        ("text", "mistake", "used"),
        [
            ("0.5", "must be from 1 to 20", "2"),
            ("1e9", "must be from 1 to 20", "2"),
            ("1e", "“1e” is not a number, from 1 to 20", "2"),
            ("", "a number from 1 to 20", "2"),
            ("2,5", "", "2.5"),
            (" 1e1", "", "10"),
        ],
    )
    def test_what_is_typed_stays_and_is_judged(self, opened, text, mistake, used):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        type_in(browser, "theta", text)
        assert seen(browser, "#x-theta", "value") == text
        assert seen(browser, "#x-theta-mistake") == mistake
        assert seen(browser, "[data-key=theta] input[type=range]", "value") == used
        type_in(browser, "theta", "3")
        assert seen(browser, "#x-theta-mistake") == ""

    def test_no_text_outlives_what_it_says(self, opened):
        browser = opened()
        note = "document.querySelector('.said').innerText.includes('at θ = 2')"
        browser.evaluate("""(() => { const list = document.querySelector('[data-x=preset]');
            list.value = '0'; list.dispatchEvent(new Event('change')); })()""")
        wait_until(browser, note)
        type_in(browser, "theta", "3")
        wait_until(browser, f"!({note})")
        assert seen(browser, "[data-x=preset]", "value") == ""

    @pytest.mark.parametrize("width", [390, pytest.param(1400, marks=pytest.mark.nightly), 2560])
    @pytest.mark.parametrize(
        "address",
        [
            "theta=1&eta=0.3&clamp=0.6",
            "theta=2&eta=0.97&mu0=2&clamp=0.3",
            "theta=2&eta=0.45&delta=-6&beta=10&clamp=0.4",
        ],
    )
    def test_the_stage_shows_all_of_the_rod(self, opened, width, address):
        browser = opened(address, width)
        frame = seen(browser, ".stage", BOX)
        for part in ("rod", "contact", "clamp"):
            box = seen(browser, f".stage .{part}", BOX)
            assert frame["left"] <= box["left"] and box["right"] <= frame["right"]
            assert frame["top"] <= box["top"] and box["bottom"] <= frame["bottom"]

    def test_a_wave_is_drawn_with_its_magnification_and_the_places_of_rest(self, opened):
        rods = "theta=2&eta=0.85&mu0=0.3&dx0=0.0005"
        plane = opened(rods)
        assert seen(plane, ".on-wave", BOX)["width"] == 0
        browser = opened(f"{rods}&amplitude=0.0001&wavelength=0.025&clamp=0.4")
        frames(browser)
        text = seen(browser, "[data-x=waves]")
        count, slips, magnified = re.match(
            r"([\d.]+) slips in a wave \(the last (\d+)\).* magnified (\d+) times", text
        ).groups()
        assert 0.9 < float(count) < 1.1 and int(slips) == 12
        marks = (
            "[...document.querySelectorAll('[data-x=wave] .rest')].filter((n) => n.r.baseVal.value)"
        )
        places = browser.evaluate(f"{marks}.map((n) => [n.cx.baseVal.value, n.cy.baseVal.value])")
        assert len(places) >= 6
        # Locked: all places of rest are as high in their waves, one in each.
        across, up = zip(*sorted(places), strict=True)
        steps = np.diff(across)
        assert steps == pytest.approx(steps[0], rel=0.05) and np.ptp(up) < 4
        wide, tall = (seen(browser, "[data-x=wave] .profile", BOX)[k] for k in ("width", "height"))
        assert tall / 2e-4 / (wide / 0.2) == pytest.approx(int(magnified), rel=0.1)
        drag(browser, 20)
        browser.evaluate("new Promise((done) => setTimeout(done, 400))")
        wait_until(browser, "location.hash.includes('tip=')")
        address, x0 = browser.evaluate("location.hash.slice(1)"), value(browser, "x0")
        again = opened(address)
        assert value(again, "x0") == pytest.approx(x0, abs=1e-7)

    def test_labels_can_be_switched_off(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4&clamp=0.04")
        names = "[...document.querySelectorAll('.labels text')].map((n) => n.textContent)"
        assert {"η", "x0", "α", "f", "friction cone", "α = 0"} <= set(browser.evaluate(names))
        click(browser, "[data-key=labels] input[value=off]")
        wait_until(
            browser, "getComputedStyle(document.querySelector('.eta')).visibility === 'hidden'"
        )

    def test_friction_and_the_point_are_dragged_on_the_curve(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        drag(browser, 0, HANDLE, down=40)
        mu0 = float(seen(browser, "#x-mu0", "value"))
        assert 0.2 < mu0 < 0.38
        drag(browser, 300, POINT)
        onset = float(solve_curve(2, 0.85).onset(mu0))
        assert value(browser, "x0") == pytest.approx(onset, rel=6e-4)
        assert said(browser).strip() == "Sticks"
        drag(browser, -10, POINT)
        read = seen(browser, "[data-x=sticking] .hovertext")
        assert re.fullmatch(r"x0 = [\d.]+ L, −tan α = [\d.]+", read)
        pulled = opened("theta=15&eta=0.97&beta=10&mu0=1&clamp=-0.05")
        assert seen(pulled, POINT, BOX)["width"] > 0

    def test_a_slip_is_seen_at_its_speed(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.1&speed=slow")
        click(browser, "[data-x=play]")
        wait_until(browser, "document.querySelector('[data-x=state]').textContent === 'slips'")
        # As many as the browser draws while the slip lasts.
        places = browser.evaluate("""new Promise((done) => {
            const places = [];
            const look = () => {
                if (document.querySelector('[data-x=state]').textContent !== 'slips') done(places);
                else {
                    const text = document.querySelector('[data-value=x0]').textContent;
                    places.push(Number(text.replace('−', '-')));
                    requestAnimationFrame(look);
                }
            };
            look();
        })""")
        assert places == sorted(places, reverse=True) and 0 <= places[-1] < places[0] < 0.0054
        assert any(0.001 < place < 0.004 for place in places)

    def test_play_stops_at_the_end_of_the_range_of_the_clamp(self, opened):
        browser = opened("clamp=49.995&x0=0")
        click(browser, "[data-x=play]")
        wait_until(browser, "document.querySelector('[data-x=play]').textContent === 'Play'")
        assert value(browser, "clamp") == 50

    def test_a_rod_that_buckles_laterally_turns_for_half_a_second(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.9&clamp=0.5")
        type_in(browser, "dx0", "0.05")
        seen(browser, ".stage .clamp", "focus()")
        browser.evaluate("""window.widths = new Promise((done) => {
            const widths = [];
            const look = () => {
                const state = document.querySelector('[data-x=state]').textContent;
                const turns = state === 'buckles laterally';
                if (turns) widths.push(document.querySelector('.stage .rod').getBBox().width);
                if (!turns && widths.length) done(widths);
                else requestAnimationFrame(look);
            };
            look();
        }); 0""")
        browser.press("Home", 36)
        seen(browser, ".stage .clamp", "focus()")
        browser.press("PageUp", 33)
        widths = browser.evaluate("window.widths")
        # It is seen from the edge of its plane in between.
        assert len(widths) > 4 and min(widths) < 0.6 * max(widths)
        wait_until(
            browser, "document.querySelector('.said').innerText.includes('buckled laterally')"
        )

    def test_a_message_about_an_event_fades_and_other_messages_stay(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        past = "document.querySelector('[data-x=event]').classList.contains('past')"
        drag(browser, 100)
        wait_until(browser, "document.querySelector('.said').innerText.includes('slipped')")
        assert not browser.evaluate(past)
        later = "window.requestAnimationFrame = ((of) => (f) => of((t) => f(t + 1e4)))"
        browser.evaluate(f"{later}(requestAnimationFrame); 0")
        wait_until(browser, past)
        click(browser, "[data-x=pin]")
        wait_until(browser, f"!{past}")
        frames(browser)
        assert not browser.evaluate(past) and "Pinned" in said(browser)

    def test_a_shape_beyond_the_surface_is_drawn_as_impossible(self, opened):
        browser = opened("theta=2&eta=0.7&mu0=0.9&clamp=0.3")
        beyond, rod = (seen(browser, f".stage .{part}", BOX) for part in ("beyond", "rod"))
        surface = seen(browser, ".stage .surface", BOX)["top"]
        assert beyond["width"] > 5 and beyond["bottom"] <= surface + 3 and rod["top"] > surface - 9
        lies = opened("theta=2&eta=0.7&mu0=0.9&clamp=0.3&contact=line")
        assert seen(lies, ".stage .beyond", "getAttribute('d')") == "M0 0"

    def test_the_length_of_a_force_is_true_to_its_scale(self, opened):
        def ratio(address):
            browser = opened(address)
            d = seen(browser, ".stage .arrow", "getAttribute('d')")
            x, y, tx, ty = map(float, re.match(r"M(\S+) (\S+)L(\S+) ([^M]+)M", d).groups())
            name = re.fullmatch(r"f(?:, scale 1:(\d+))?", seen(browser, ".labels .force"))
            drawn = int(name[1] or 1) * math.hypot(tx - x, ty - y)
            height = seen(browser, ".stage .height", BOX)["height"]
            return drawn / height / value(browser, "f"), int(name[1] or 1)

        small, large = ratio("eta=0.7&mu0=2"), ratio("eta=0.7&mu0=2&contact=line&clamp=0.6")
        assert small[1] == 1 < large[1] and small[0] == pytest.approx(large[0], rel=0.02)

    @pytest.mark.parametrize("width", [390, 1200])
    @pytest.mark.parametrize(
        "address",
        [
            pytest.param("mu0=0.45&clamp=0.1", marks=pytest.mark.nightly),
            "mu0=0.445&clamp=0.02",
            "mu0=0.02&clamp=0.001",
            pytest.param("theta=1&eta=0.5&mu0=0.3&clamp=0.4", marks=pytest.mark.nightly),
            "theta=3&beta=10&delta=3&clamp=0.05&mu0=0.5",
        ],
    )
    def test_no_name_covers_another(self, opened, width, address):
        browser = opened(address, width)
        covered = browser.evaluate("""[...document.querySelectorAll('svg')].flatMap((svg) => {
            const texts = [...svg.querySelectorAll('text:not(.ticks text, .ruler text)')]
                .map((n) => [n.textContent, n.getBoundingClientRect()])
                .filter(([text, box]) => text && box.width);
            const over = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
                && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 4;
            return texts.flatMap(([name, a], i) =>
                texts.slice(i + 1).filter(([, b]) => over(a, b)).map(([other]) => [name, other]));
        })""")
        assert covered == []

    def test_the_introduction_goes_on_when_a_hand_has_done_its_step(self, opened):
        browser = opened()
        drag(browser, 100)
        part = "document.querySelector('.pointed')?.dataset.part"
        wait_until(browser, f"{part} === 'curve'")
        drag(browser, 0, HANDLE, down=20)
        wait_until(browser, f"{part} === 'controls'")
        type_in(browser, "theta", "3")
        wait_until(browser, "document.querySelector('.intro').hidden")

    def test_the_introduction_has_three_steps(self, opened):
        browser = opened()
        for part in ("stage", "curve", "controls"):
            assert seen(browser, ".pointed", "dataset.part") == part
            click(browser, "[data-x=next]")
        assert seen(browser, ".intro", "hidden")

    def test_every_control_has_a_word_of_help(self, opened):
        browser = opened("theta=2")
        without = """[...document.querySelectorAll('.explorer :is(input, select, button)')]
            .filter((n) => !n.closest('[data-help], .intro')).map((n) => n.outerHTML)"""
        assert browser.evaluate(without) == []
        seen(browser, "#x-eta", "focus()")
        assert "rod lengths" in seen(browser, ".help") and not seen(browser, ".help", "hidden")

    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_a_phone_shows_rod_and_curve_on_one_screen(self, opened, scheme):
        browser = opened("theta=2", width=390, height=844, prefers_color_scheme=scheme)
        assert browser.evaluate("document.documentElement.scrollWidth") == 390
        assert seen(browser, "svg[data-x=sticking]", BOX)["bottom"] < 844
        dark = browser.evaluate("getComputedStyle(document.body).backgroundColor")
        assert (dark == "rgb(20, 23, 26)") == (scheme == "dark")

    @pytest.mark.parametrize(
        "width",
        [
            390,
            *(pytest.param(one, marks=pytest.mark.nightly) for one in (820, 1040, 1300)),
            3840,
        ],
    )
    def test_no_field_covers_another_no_label_is_cut_and_no_message_moves_them(self, opened, width):
        browser = opened("theta=2&law=kinetic&units=si&beta=5&kappa0=-0.2&delta=1", width=width)
        browser.evaluate(
            "document.querySelectorAll('.mounting').forEach((n) => { n.open = true; })"
        )
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
        before = seen(browser, ".fields", BOX)
        seen(browser, "[data-x=event]", "textContent = 'A long message. '.repeat(30)")
        assert seen(browser, ".fields", BOX) == before

    def test_a_recording_is_drawn_with_the_curves(self, opened, tmp_path):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        path = tmp_path / "scan.csv"
        rows = "0,0,-1,0\n9,-1,-2,0\n" * 100_000
        path.write_text(f"footpoint [mm],force_x [N],force_y [N],moment_z [N*m]\n{rows}")
        node = browser.call("DOM.getDocument")["root"]["nodeId"]
        box = browser.call("DOM.querySelector", nodeId=node, selector="[data-x=file]")["nodeId"]
        browser.call("DOM.setFileInputFiles", nodeId=box, files=[str(path)])
        drawn = "document.querySelector('svg[data-x=fy] .measured').getAttribute('d')"
        wait_until(browser, f"{drawn}.includes('L')")
        before = browser.evaluate(drawn)
        type_in(browser, "diameter", "2")
        assert browser.evaluate(drawn) != before
        assert seen(browser, "[data-x=record]") == "scan.csv"
        wait_until(browser, "document.querySelector('[data-x=misfit]').textContent !== ''")

    def test_what_is_seen_is_exported_with_its_parameters(self, opened):
        browser = opened("theta=2&eta=0.85&mu0=0.4")
        drag(browser, 10)
        browser.evaluate(
            "URL.createObjectURL = (blob) => { window.made = blob; return 'data:,'; };"
            "HTMLAnchorElement.prototype.click = () => {}; 0"
        )

        def made(kind):
            browser.evaluate("window.made = null; 0")
            click(browser, f"button[data-x={kind}]")
            wait_until(browser, "window.made !== null")

        made("svg")
        wait_until(browser, "document.querySelector('.said').innerText.includes('vibrissa.svg is')")
        text = browser.evaluate("window.made.text()")
        assert text.startswith("<svg") and text.count("<svg") == 8 and "var(" not in text
        assert "θ = 2, η = 0.85 L, μ0 = 0.4" in text and "Sticking curve" in text
        made("png")
        assert browser.evaluate("createImageBitmap(window.made).then((i) => i.width)") > 2000
        made("csv")
        head, first, *rest = browser.evaluate("window.made.text()").splitlines()
        assert head.startswith("footpoint [L],force_x [E*I0/L^2],") and "theta [1],eta [L]" in head
        # Rounding errors are 0.
        assert first.startswith("0,0,-1.15") and ",2,0.85,0.4," in first and len(rest) > 10


def curve_of(settings):
    """Python's curve of the page's rod."""
    given = dict.fromkeys(["beta", "compliance", "kappa0", "kappa1", "delta"], 0) | settings
    mounting = Mounting(
        clamp_angle=math.radians(given["beta"]),
        clamp_compliance=given["compliance"],
        curvature=(given["kappa0"], given["kappa1"]),
        stage_angle=math.radians(given["delta"]),
    )
    contact = given.get("contact", "point")
    return solve_curve(given["theta"], given["eta"], mounting=mounting, contact=contact)


def of_model(functions, settings, clamp, values):
    """Values of the page's model, with its clamp moved from 0; s is where sticking ends."""
    return functions.evaluate(f"""(() => {{ const model = new Model();
        model.change({json.dumps(settings)}); model.moveTo({clamp});
        const s = model.sticking; return {values}; }})()""")


@pytest.fixture
def functions(browser):
    """Functions of the page without the page."""
    browser.open("about:blank")
    script = bundle(
        "solver/motion.js",
        "view/recording.js",
        "view/settings.js",
        "view/model.js",
        "view/svg.js",
        "view/misfit.js",
    )
    browser.evaluate(f"{script}; 0")
    return browser


class TestFunctions:
    pytestmark = needs_chromium

    def test_numbers_are_written_to_four_digits_and_rounding_errors_are_nothing(self, functions):
        texts = functions.evaluate("[0, 0.5, -12345.6, 1.2345e-5, -1e-9].map(significant)")
        assert texts == ["0", "0.5000", "−12346", "1.234e−5", "−1.000e−9"]
        assert functions.evaluate("[1e-13, -1e-13, 1e-9].map(withoutNoise)") == [0, 0, 1e-9]

    @pytest.mark.parametrize(
        "settings",
        [
            {"eta": 0.7},
            {"eta": 0.7, "mu0": 0.9},
            {"eta": 0.7, "contact": "line"},
            {"beta": 5.0, "kappa0": -0.2},
            {"compliance": 0.1},
            {"delta": 3.0, "kappa1": -0.1},
            {"delta": -3.0},
        ],
    )
    def test_steps_are_those_of_a_study(self, functions, settings):
        common = {"theta": 2.0, "eta": 0.8, "mu0": 0.3, "dx0": 0.005, "contact": "point"}
        settings = common | settings
        rows = stick_slip(curve_of(settings), settings["mu0"], settings["dx0"], 4)
        count, state = len(rows.clamp), rows.state
        assert count > 8
        found = json.loads(
            functions.evaluate(f"""(() => {{
                const model = new Model();
                model.change({json.dumps(settings)});
                model.restore(0, 0, 1);
                for (let k = 1; k < {count}; k += 1) model.step();
                return JSON.stringify(
                    model.trace.map((row) => [row.clamp, row.contact, row.fx, row.fy, row.m]));
            }})()""")
        )
        expected = (
            rows.clamp,
            rows.contact,
            state.reaction_fx,
            state.reaction_fy,
            state.reaction_m,
        )
        assert len(found) == count
        for got, *row in zip(found, *expected, strict=True):
            assert got == pytest.approx(row, abs=1e-8)

    @pytest.mark.parametrize(
        ("settings", "by", "friction"),
        [
            ({"theta": 2, "eta": 0.98, "beta": 10, "kappa0": -0.3, "delta": -6}, "slips", 1),
            ({"theta": 1, "eta": 0.95, "beta": 20}, "slips back", -1),
            ({"theta": 2.7, "eta": 0.93, "beta": 19, "kappa0": -0.4, "delta": -6}, "slips", 1),
        ],
    )
    def test_before_it_lifts_off_a_tip_ends_to_stick(self, functions, settings, by, friction):
        asked = "[s.high, String(s.path.muLock), s.highBy]"
        high, lock, found = of_model(functions, {"mu0": 1} | settings, 0, asked)
        curve = curve_of(settings)
        assert found == by and float(lock) == pytest.approx(curve.mu_lock)
        assert curve.mobilised_friction(high) == pytest.approx(friction, abs=1e-6)

    @pytest.mark.parametrize("law", ["free", "kinetic", "energy"])
    @pytest.mark.parametrize("begin", ["high", "low", "path.x0Pulled - 0.01"])
    @pytest.mark.parametrize("ratio", [0.8, pytest.param(0.4, marks=pytest.mark.nightly), 0.2])
    def test_slips_end_where_the_sensor_says(self, functions, law, begin, ratio):
        theta, eta, mu0 = 2.0, 0.85, 0.4
        friction = json.dumps({"mu0": mu0, "ratio": ratio, "law": law})
        start, found = functions.evaluate(f"""(() => {{
            const rod = {{ theta: {theta}, eta: {eta}, contact: "point", round: true }};
            const sticking = stickingOf(solvedPath(rod).path, {friction});
            const x0 = sticking.{begin};
            return [x0, String(restOf(sticking, x0))];
        }})()""")
        response = respond(theta, eta)
        surface = surfaces.constant(mu0)
        stage = Stage(response=response, eta=eta)
        slip = Slip(stage=stage, surface=surface, model=SlipModel.of(law, ratio))
        rest = slip.follow(response.contact(0.0, start, 1))
        expected = np.nan if rest.lost else rest.x0
        assert float(found) == pytest.approx(expected, abs=2e-6, nan_ok=True)

    @pytest.mark.parametrize(
        ("mu0", "clamp", "fallen"),
        # The demand of the last tip, past the critical state, is below the friction that is left.
        [(0.4, 0.05, 0.1), (0.4, -0.01, 0.1), (0.8, 0.6, 0.3), (0.9, 0.3, 0.3), (0.9, 0.3, 0.42)],
    )
    def test_a_tip_slips_if_friction_falls_below_its_demand(self, functions, mu0, clamp, fallen):
        told = "[e.clamp, e.x0, e.rest, model.reading(e).demand]"
        fall = f"model.change({{ mu0: {fallen} }}).map((e) => {told})"
        rows = "model.trace.map((row) => row.clamp), model.moveTo(0).map((e) => e.x0)"
        asked = f"[model.place.x0, {fall}, {rows}]"
        x0, slips, rows, later = of_model(functions, {"mu0": mu0}, clamp, asked)
        demand = solve_curve(2, 0.85).mobilised_friction
        holds = abs(demand(x0)) < fallen
        assert slips == ([] if holds else [[clamp, x0, 0, pytest.approx(demand(x0))]])
        assert rows == [clamp]
        if holds:  # until the clamp moves back
            assert demand(later[:2]) == pytest.approx([fallen, -fallen])

    @pytest.mark.parametrize(
        ("settings", "moves", "clamp", "x0"),
        [
            ({"mu0": 0.02}, "model.moveTo(20)", 20, "20 % s.high"),
            # A tip that slides along stays at its onset.
            ({"law": "kinetic", "ratio": 1}, "model.moveTo(1)", 1, "s.high"),
            ({"law": "energy", "ratio": 1}, "model.moveTo(1)", 1, "s.high"),
            ({}, "model.restore(0.0526, 0, 1), model.step()", 0.053, 0.0004),
            ({}, "model.restore(50, 0, 1), model.step()", 50, 0),
            ({"mu0": 0.42}, "model.restore(0.3, 0.3, 1)", 0.3, 0.3),
            # Beyond these heights no period begins; one begins anew where the clamp is moved back.
            ({"eta": 0.3, "delta": 6}, "model.moveTo(5), model.moveTo(1)", 1, 0),
            # A rod that leans so far back is not solved.
            ({"beta": 60}, "model.restore(1, 0.04, 1), model.change(DEFAULTS)", 1, 0.04),
        ],
    )
    def test_clamp_and_tip_are_where_a_move_leads(self, functions, settings, moves, clamp, x0):
        asked = f"({moves}, [model.now.clamp, model.now.x0 - {x0}])"
        assert of_model(functions, settings, 0, asked) == pytest.approx([clamp, 0], abs=1e-6)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("", "the first line must name two or more of the columns"),
            ("force_x,force_y\n1,2\n", "footpoint is required"),
            ("footpoint [mm]\n1\n", "the first line must name two or more of the columns"),
            ("footpoint [N],force_x\n1,2\n", "“N” is not a known unit of length"),
            ("# a\nfootpoint,force_x\n1,2\n1,two\n", "line 4: “two” is not a number"),
            ("footpoint,force_x\n\n", "the file has no samples"),
        ],
    )
    def test_a_file_that_is_no_recording_is_told(self, functions, text, message):
        found = functions.evaluate(f"readRecording('a.csv', {json.dumps(text)}).message")
        assert message in found

    def test_a_recording_has_a_measure_of_fit(self, functions):
        found = functions.evaluate("""(() => {
            const model = new Model();
            model.moveTo(0.04);
            const rows = model.trace;
            const clamp = rows.map((row) => row.clamp);
            const [fx, fy] = ['fx', 'fy'].map((key) => rows.map((row) => row[key]));
            const away = 0.1 * (Math.max(...fx) - Math.min(...fx));
            const near = { name: '', clamp: [...clamp, 0.5], m: [],
                fx: [...fx.map((force) => force + away), NaN], fy: [...fy, NaN] };
            const far = { ...near, clamp: near.clamp.map((place) => place + 1) };
            return [misfitOf(rows, near), misfitOf(rows, far)];
        })()""")
        share = re.search(r"Fx 10 %, Fy 0.0 %; (\d+) % of", found[0])
        assert share and 90 < int(share[1]) < 100 and "Move the clamp" in found[1]

    def test_units_of_a_recording(self, functions):
        # E·I0 = 210 GPa · π · 1 mm⁴ / 64, L = 100 mm
        stiffness = 210e3 * 3.141592653589793 / 64
        text = "# zero\nmoment_z [mNmm];footpoint (cm);force_x [mN]\n1000;5;1030.835\n;5;nan\n"
        read = f"readRecording('a.csv', {json.dumps(text)}).recording"
        found = functions.evaluate(f"{read}(DEFAULTS)")
        assert found["clamp"] == pytest.approx([0.5, 0.5])
        assert found["fx"][0] == pytest.approx(1.030835 * 1e4 / stiffness)
        assert found["m"][0] == pytest.approx(1 * 100 / stiffness)
        assert found["fx"][1] is None and found["fy"] == []
        longer = functions.evaluate(f"{read}({{ ...DEFAULTS, length: 200 }})")
        assert longer["clamp"][0] == 0.25 and longer["fx"][0] == pytest.approx(4 * found["fx"][0])
