"""Writes what came out of the faults as a table, if FAULTS_TABLE names the file that has it."""

import os
from pathlib import Path

import pytest

OUTCOMES = {}


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item):
    report = (yield).get_result()
    if report.when == "call" or (report.when == "setup" and not report.passed):
        fault = " ".join((item.function.__doc__ or item.name).split()).rstrip(".")
        entry = OUTCOMES.setdefault(fault, {"passed": 0, "failed": 0, "skipped": 0, "said": ""})
        entry[report.outcome] += 1
        entry["said"] = dict(item.user_properties).get("said", entry["said"])


def pytest_sessionfinish():
    name = os.environ.get("FAULTS_TABLE")
    if not name:
        return
    path = Path(name)
    start, _, rest = path.read_text().partition("<!-- table -->\n")
    _, _, end = rest.partition("<!-- end of table -->\n")
    rows = ["| fault | tries | outcome | what the screen said |", "| --- | --- | --- | --- |"]
    for fault, entry in OUTCOMES.items():
        outcome = f"{entry['passed']} healed"
        outcome += "".join(f", {entry[k]} {k}" for k in ("failed", "skipped") if entry[k])
        tries = entry["passed"] + entry["failed"]
        rows.append(f"| {fault} | {tries} | {outcome} | {entry['said'].replace('|', '/')} |")
    table = "\n".join(rows)
    path.write_text(f"{start}<!-- table -->\n{table}\n<!-- end of table -->\n{end}")
