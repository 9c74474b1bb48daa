"""Run Snakemake's linter, and ignore the findings that are listed here with a reason.

`snakemake --lint` has no option for that, and its `--lint json` prints plain text (Snakemake 9.27).
So this program calls the linter through Snakemake's Python interface.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
from fnmatch import fnmatch
from pathlib import Path

from snakemake.api import OutputSettings, ResourceSettings, SnakemakeApi

# (rule or file, title of the finding) as shell patterns -> why it is all right here.
ALLOWED = {
    ("*", "Specify a conda environment or container for each rule*"): (
        "all rules share the one environment of requirements.lock / environment.yml"
    ),
}


def main() -> int:
    captured = io.StringIO()
    with SnakemakeApi(OutputSettings()) as api, contextlib.redirect_stdout(captured):
        workflow = api.workflow(ResourceSettings(), snakefile=Path("Snakefile"))
        workflow.lint(json=True)
    found = json.loads(captured.getvalue())
    remaining = 0
    for entry in [*found["snakefiles"], *found["rules"]]:
        where = entry["for"].get("rule") or entry["for"].get("snakefile", "?")
        for lint in entry["lints"]:
            if any(fnmatch(where, w) and fnmatch(lint["title"], t) for w, t in ALLOWED):
                continue
            remaining += 1
            print(f"{where}: {lint['title']}\n    {lint['body']}")
    print(f"snakemake lint: {remaining} finding(s), {len(ALLOWED)} kind(s) allowed")
    return 1 if remaining else 0


if __name__ == "__main__":
    sys.exit(main())
