"""The whole page of the paper's study as it is read: no word, no number changes unnoticed.

What the parts of the page show is tested in test_page.py.
"""

import re
from html.parser import HTMLParser
from pathlib import Path

import pyarrow as pa

from known import Known
from vibrissa.report import facts
from vibrissa.report import page as report
from vibrissa.tables.proofs import KEYS, read

ROOT = Path(__file__).parents[2]
KNOWN = Known(__file__)
# Numbers that are nothing but rounding are others on another machine.
ROUNDING = re.compile(r"\d(\.\d+)?·10⁻¹[⁰¹²³⁴⁵⁶⁷⁸⁹]")
BENCHMARKS = {
    "curves": ["s\tmax_rss\n1.5\t100\n", "s\tmax_rss\n2.5\t300\n"],
    "figure": ["s\tmax_rss\n0.25\t50\n"],
}


class Text(HTMLParser):
    """The text between the tags, a line for each piece; without scripts and styles."""

    def __init__(self, page):
        super().__init__()
        self.lines, self.hidden = [], False
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.hidden = tag in ("script", "style")
        for name, value in attributes:
            if name in ("title", "alt", "class", "id", "aria-label"):
                self.lines.append(f"<{tag} {name}={value}>")

    def handle_endtag(self, tag):
        self.hidden = False

    def handle_data(self, data):
        if not self.hidden and data.strip():
            self.lines.append(ROUNDING.sub("(rounding)", " ".join(data.split())))


def test_the_page_reads_as_it_did(study_tables):
    run = report.Run(
        study_files={"my.yaml": "study: mine"},
        environment={"Python": "3"},
        benchmarks=BENCHMARKS,
        proofs=read(ROOT / "tests/regression/paper/enclosures.csv", KEYS),
    )
    KNOWN.check("page", Text(report.page("paper", study_tables, [], run)).lines)


def test_times_of_jobs_are_summed_up_by_rule():
    rows = facts.job_times(BENCHMARKS).to_dict("records")
    names = ("rule", "jobs", "seconds", "longest", "memory")
    assert [tuple(row[name] for name in names) for row in rows] == [
        ("curves", 2, 4.0, 2.5, 300.0),
        ("figure", 1, 0.25, 0.25, 50.0),
        ("all", 3, 4.25, 2.5, 300.0),
    ]


def test_a_table_says_which_code_made_it():
    told = {"vibrissa.version": "1.2", "vibrissa.commit": "a" * 40}
    for metadata, version, commit, short in (
        (told, "1.2", "a" * 40, "a" * 12),
        (None, "unknown", "unknown", "unknown"),
    ):
        made = facts.origin("states", pa.table({"x": [1, 2]}).replace_schema_metadata(metadata))
        assert (made.table, made.rows, made.version) == ("states", 2, version)
        assert (made.commit, made.short) == (commit, short)
