"""Drag the clamp and a slider in the explorer's page for a minute.

Prints, for a headless Chromium that draws on the processor, how many frames were shown in a second,
how long the page's thread worked for each, and how long the rod took. The time of the thread is its
own time on the processor: other programs that run meanwhile do not count.
"""

import argparse
import json
import math
import os
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from validation.browser import CHROMIUM, Page, chromium
from vibrissa.explorer.page import page

# Milliseconds of each frame and those in which the rod was solved, as the page itself says them.
WATCH = """
window.seen = { frames: [], solved: [] };
let last = performance.now();
const watch = (now) => {
    window.seen.frames.push(now - last);
    last = now;
    const value = Number.parseFloat(document.querySelector('.explorer').dataset.solved);
    if (Number.isFinite(value)) window.seen.solved.push(value);
    requestAnimationFrame(watch);
};
requestAnimationFrame(watch);
0
"""
MOVE_CLAMP = "[data-x=stage] .clamp"
RODS = {
    "clamp, tip contact": ("theta=2&eta=0.85&mu0=0.4", MOVE_CLAMP),
    "clamp, line contact": ("theta=4&eta=0.6&mu0=0.4&contact=line", MOVE_CLAMP),
    "taper θ from 1 to 8, tip contact": ("theta=2&eta=0.85&mu0=0.4", "[data-key=theta]"),
    "taper θ from 1 to 8, line contact": (
        "theta=4&eta=0.6&mu0=0.4&contact=line",
        "[data-key=theta]",
    ),
    "friction μ0 from 0.05 to 0.75, tip contact": (
        "theta=2&eta=0.85&mu0=0.4&clamp=0.02",
        "[data-key=mu0]",
    ),
    "clamp, leaning back by 5°, curved, tip contact": (
        "theta=2&eta=0.85&mu0=0.4&beta=5&kappa0=-0.2",
        MOVE_CLAMP,
    ),
}
# Middle and half of the way of a slider.
WAYS = {"[data-key=theta]": (4.5, 3.5), "[data-key=mu0]": (0.4, 0.35)}


def dragged(browser: Page, seconds: float) -> dict[str, list[float]]:
    """Drag the clamp to and fro with the mouse."""
    x, y = browser.evaluate(
        f"(() => {{ const b = document.querySelector('{MOVE_CLAMP}').getBoundingClientRect();"
        "return [b.x + b.width / 2, b.y + b.height / 2]; })()"
    )
    mouse = {"button": "left", "buttons": 1, "clickCount": 1, "y": y}
    browser.call("Input.dispatchMouseEvent", type="mousePressed", x=x, **mouse)
    browser.evaluate(WATCH)
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        place = x + 250 * math.sin(1.5 * left) ** 2
        browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=place, **mouse)
        time.sleep(0.005)
    return json.loads(browser.evaluate("JSON.stringify(window.seen)"))


def slid(browser: Page, seconds: float, field: str) -> dict[str, list[float]]:
    """Move the slider of a field to and fro, in each frame."""
    middle, half = WAYS[field]
    browser.evaluate(WATCH)
    browser.evaluate(f"""new Promise((done) => {{
        const slider = document.querySelector('{field} input[type=range]');
        const end = performance.now() + {1000 * seconds};
        const move = (now) => {{
            slider.value = {middle} - {half} * Math.cos(now / 1500);
            slider.dispatchEvent(new Event('input'));
            if (now < end) requestAnimationFrame(move);
            else done();
        }};
        requestAnimationFrame(move);
    }})""")
    return json.loads(browser.evaluate("JSON.stringify(window.seen)"))


def worked(browser: Page) -> float:
    """Seconds that the page's thread has worked."""
    metrics = browser.call("Performance.getMetrics")["metrics"]
    return next(metric["value"] for metric in metrics if metric["name"] == "TaskDuration")


def measure(seconds: float) -> None:
    """Measure each way of moving, and print a table."""
    if CHROMIUM is None:
        sys.exit("no Chromium to open the page with (Debian: apt install chromium)")
    print(f"Processes that want to run: {os.getloadavg()[0]:.0f}, on {os.cpu_count()} cores.\n")
    print("| what moves | frames per second | work for a frame | rod solved in, median | 95 % |")
    print("| --- | --- | --- | --- | --- |")
    with TemporaryDirectory() as folder, chromium(folder) as browser:
        path = Path(folder, "explorer.html")
        path.write_text(page(), encoding="utf-8")
        for name, (address, moves) in RODS.items():
            browser.open("about:blank")
            browser.open(f"{path.as_uri()}#{address}", 1400)
            # The map of regimes is complete.
            time.sleep(5)
            browser.call("Performance.enable", timeDomain="threadTicks")
            before = worked(browser)
            part = seconds / len(RODS)
            seen = dragged(browser, part) if moves == MOVE_CLAMP else slid(browser, part, moves)
            work = 1000 * (worked(browser) - before) / len(seen["frames"])
            rate = 1000 / np.mean(seen["frames"][5:])
            median, most = np.quantile(seen["solved"], [0.5, 0.95])
            print(f"| {name} | {rate:.0f} | {work:.1f} ms | {median:.1f} ms | {most:.1f} ms |")


def main() -> None:
    """Read the options and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    measure(**vars(parser.parse_args()))
