"""Study files as they are written: every mistake with its line."""

import resource
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from vibrissa.errors import StudyError
from vibrissa.study.reading import as_text_says, read_study, retyped

ROOT = Path(__file__).parents[2]
GRIDS = """grids:
  main:
    theta: [1, 2]
    mu0: [0.3]
    eta: [0.85]
    dx0: [0.001]
"""


@pytest.fixture
def mistakes(tmp_path):
    """Mistakes of a file of this text, without the folder's name."""

    def find(text):
        path = tmp_path / "my.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        with pytest.raises(StudyError) as error:
            read_study([path])
        return [told.replace(f"{tmp_path}/", "") for told in error.value.mistakes]

    return find


@pytest.mark.parametrize("path", [ROOT / "config.yaml", *ROOT.glob("studies/*.yaml")])
def test_studies_of_the_project_are_read(path):
    assert read_study([path]).name == yaml.safe_load(path.read_text())["study"]


def test_all_mistakes_are_told_with_their_lines_in_the_order_of_the_file(mistakes):
    text = (
        "study: a b\n"
        + GRIDS.replace("[1, 2]", "[1,\n      0.5]").replace("0.001", "010")
        + "contact: tip\nblocksize: 5\nfigures:\n  f: {kind: taper, grid: mani}\nstudy: c\n"
    )
    found = mistakes(text.replace("study: a b", "study: a"))
    starts = [
        "my.yaml:5: grids.main.theta[1]: 0.5 is not allowed",
        "my.yaml:8: grids.main.dx0[0]: 010 is not allowed, as YAML reads it as 8",
        "my.yaml:9: contact: 'tip' is not allowed",
        "my.yaml:10: the study file: unknown key 'blocksize'",
        "my.yaml:12: figures.f.grid: 'mani' is not the name of a grid; allowed: main",
        "my.yaml:13: the study file: 'study' stands twice, in lines 1 and 13",
    ]
    assert len(found) == len(starts)
    for told, start in zip(found, starts, strict=True):
        assert told.startswith(start)


def test_mistakes_among_sections_are_told_with_those_within_them(mistakes):
    text = (
        f"study: a\n{GRIDS.replace('0.001', 'x')}contact: line\nmethod: shooting\n"
        "scans:\n  s: {theta: [2], mu0: [0.3], eta: [0.85], dx0: [1.0e-9], cycles: 9}\n"
        "states:\n  b: {theta: 0.5, eta: 0.5, x1: 0.1}\n  c: {theta: 1, eta: 0.5, x1: 0.1}\n"
        "figures:\n  f: {kind: scan, scan: s, theta: 3, mu0: 0.3}\n"
        "  g: {kind: taper, grid: main}\n  h: {kind: state, state: [b, c]}\n"
        "claims: {taper: main, friction: mani, scan: s, state: c}\n"
    )
    starts = [told.partition(" is not")[0].partition(" are not")[0] for told in mistakes(text)]
    # What is drawn from a section with a mistake has none for that.
    assert [told for told in starts if "claims" not in told] == [
        "my.yaml:7: grids.main.dx0[0]: 'x'",
        "my.yaml:9: method: 'shooting'",
        "my.yaml:10: scans: some 900,000,001 steps in all",
        "my.yaml:11: scans.s: 9 cycles in steps of dx0 = 0.000000001 can take 1e+10 steps; "
        "allowed: (cycles + 1)/dx0 up to 1e+06",
        "my.yaml:13: states.b.theta: 0.5",
        "my.yaml:16: figures.f.theta: 3",
    ]
    assert "my.yaml:19: claims.friction: 'mani'" in starts
    assert not [told for told in starts if "claims.taper" in told]


def test_a_section_with_a_mistake_hides_none_of_another(mistakes):
    scan = "{{theta: [2], mu0: [0.3], eta: [{}], dx0: [{}], cycles: 9}}"
    text = (
        f"study: a\n{GRIDS}scans:\n  r: {scan.format(5, 1)}\n  s: {scan.format(0.85, '1.0e-9')}\n"
    )
    starts = [told.partition(" is not")[0].partition(" in steps")[0] for told in mistakes(text)]
    assert "my.yaml:9: scans.r.eta[0]: 5" in starts and "my.yaml:10: scans.s: 9 cycles" in starts


def test_mistakes_among_sections_have_lines(mistakes):
    (told,) = mistakes(f"study: a\n{GRIDS}figures:\n  f: {{kind: taper, grid: mani}}\n")
    assert told.startswith("my.yaml:9: figures.f.grid: 'mani' is not the name of a grid")


def test_a_mistake_that_an_anchor_repeats_is_told_where_it_is_written(mistakes):
    text = "study: a\nx-axes: &axes\n  eta: [2]\n  dx0: [0.001]\ngrids:\n  g:\n    <<: *axes\n"
    found = mistakes(text + "    theta: [1]\n    mu0: [0.3]\n")
    assert [told.partition(" is not")[0] for told in found] == ["my.yaml:3: grids.g.eta[0]: 2"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("", "my.yaml is empty; a study file has at least the keys study and grids"),
        ("# nothing\n", "my.yaml is empty"),
        ("- 1\n- 2\n", "my.yaml:1: a list is not allowed; a study file has keys"),
        ("\njust words\n", "my.yaml:2: 'just words' is not allowed"),
        ("study: [\n", "my.yaml:2: not valid YAML: while parsing a flow node"),
        ("study: &a x\nb: &a y\n", "my.yaml:2: not valid YAML: found duplicate anchor 'a'"),
        ("study: *a\n", "my.yaml:1: not valid YAML: found undefined alias"),
        ("study: a\ngrids: &g\n  x: *g\n", "my.yaml:3: grids.x: an anchor stands within what it"),
        ("a: !!python/object:os.system x\n", "my.yaml:1: not valid YAML: could not determine"),
        ("a: 2020-99-99\n", "my.yaml: not valid YAML: month must be in"),
        ("? [a]\n: 1\n", "my.yaml:1: not valid YAML: while constructing a mapping"),
        ("a: " + "[" * 5000, "my.yaml: not valid YAML: too many sections within sections"),
        (b"study: \xff\xfe\n", "my.yaml is not a text in UTF-8: invalid start byte"),
        (b"study: \x01\n", "my.yaml: not valid YAML: unacceptable character"),
    ],
)
def test_what_is_no_study_file_has_one_line(mistakes, text, start):
    (told,) = mistakes(text)
    assert told.startswith(start)
    assert "\n" not in told


@pytest.mark.parametrize(
    ("written", "read"),
    [("010", "8"), ("-0_7", "-7"), ("1:30", "90"), ("1:30.5", "90.5"), ("+012", "10")],
)
def test_numbers_that_yaml_reads_as_others_are_refused(mistakes, written, read):
    found = mistakes(f"study: a\n{GRIDS.replace('0.001', written)}")
    start = f"my.yaml:7: grids.main.dx0[0]: {written} is not allowed, as YAML reads it as {read};"
    assert any(told.startswith(start) for told in found)


@pytest.mark.parametrize("key", ["study", "grids", "main", "theta"])
def test_a_key_that_stands_twice_is_told_with_both_lines(mistakes, key):
    lines = f"study: a\n{GRIDS}".splitlines()
    (first,) = (i for i, line in enumerate(lines) if line.strip().startswith(f"{key}:"))
    indent = lines[first][: -len(lines[first].lstrip())]
    end = {"study": 7, "grids": 7, "main": 7, "theta": 7}[key]
    repeated = f"{indent}{key}: {'b' if key == 'study' else '{}'}"
    found = mistakes("\n".join([*lines[:end], repeated]))
    told = f"{key!r} stands twice, in lines {first + 1} and 8; a key is allowed once"
    assert any(told in line and line.startswith("my.yaml:8: ") for line in found)


def test_what_is_not_needed_may_be_empty_or_hold_anchors(tmp_path):
    path = tmp_path / "my.yaml"
    path.write_text(
        "x-axes: &axes {eta: [0.85], dx0: [0.001]}\nx-words: whatever\nstudy: mine\n"
        "grids:\n  g: {<<: *axes, theta: [1], mu0: [0.3], eta: [0.5]}\n"
        "scans:\nstates:\ncomparisons:\nfigures:\n"
    )
    study = read_study([path])
    assert (study.scans, study.figures) == ({}, {})
    assert [float(value) for value in study.point_grids["g"].eta] == [0.5]


def test_two_study_files_are_refused(tmp_path):
    paths = [tmp_path / "a.yaml", tmp_path / "b.yaml"]
    for path in paths:
        path.write_text(f"study: a\n{GRIDS}")
    with pytest.raises(StudyError, match=r"2 study files are given \(.*a.yaml, .*b.yaml\); one is"):
        read_study(paths)


def test_the_file_of_another_workflow_is_not_the_study(tmp_path):
    path = tmp_path / "other.yaml"
    path.write_text("samples: 3\nvibrissa: {}\n")
    with pytest.raises(StudyError) as error:
        read_study([path], {"study": "a", "contact": "tip"})
    assert error.value.mistakes[0].startswith("the study file: missing 'grids'")
    assert error.value.mistakes[1].startswith("contact: 'tip' is not allowed")


def test_a_folder_and_a_missing_file_are_named(tmp_path):
    with pytest.raises(StudyError, match="cannot be read: Is a directory"):
        read_study([tmp_path])
    with pytest.raises(StudyError, match="No such study file: "):
        read_study([tmp_path / "none.yaml"])


def test_a_slip_of_the_pen_is_refused_without_its_points(tmp_path):
    path = tmp_path / "my.yaml"
    axis = "{start: 1, stop: 1.999999, step: 0.000001}"
    path.write_text(f"study: a\n{GRIDS.replace('[1, 2]', axis).replace('[0.3]', axis)}")
    code = (
        "import sys\nfrom pathlib import Path\nfrom vibrissa.study.reading import *\n"
        "try:\n    read_study([Path(sys.argv[1])])\n"
        "except StudyError as error:\n    print(error)"
    )

    def small():
        limit = 500_000_000
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CPU, (2, 2))

    command = [sys.executable, "-c", code, path]
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=small)
    assert "my.yaml:3: grids.main: 1,000,000,000,000 points" in done.stdout
    assert "up to 10,000,000 in all (the key max_points sets this limit)" in done.stdout


def test_a_key_raises_the_limit(tmp_path):
    path = tmp_path / "my.yaml"
    path.write_text(f"study: a\nmax_points: 1\n{GRIDS}")
    with pytest.raises(StudyError, match="2 points, of 2 of the study"):
        read_study([path])
    path.write_text(f"study: a\nmax_points: 2\n{GRIDS}")
    assert read_study([path]).max_points == 2


def test_numbers_of_the_command_line_are_numbers():
    given = {"g": {"theta": ["1", "2.5"], "mu0": {"start": "0.1"}, "eta": ["010", "half"]}}
    assert retyped(given) == {
        "g": {"theta": [1, 2.5], "mu0": {"start": 0.1}, "eta": ["010", "half"]}
    }
    assert retyped("7") == "7"
    assert as_text_says("{theta: [1, 2.5]}") == {"theta": [1, 2.5]}
    assert as_text_says("a: [") == "a: ["


def test_changes_of_the_command_line_are_checked_with_the_file(tmp_path):
    path = tmp_path / "my.yaml"
    path.write_text(f"study: a\n{GRIDS}")
    with pytest.raises(StudyError, match="the study file: unknown key 'size'"):
        read_study([path], yaml.safe_load(path.read_text()) | {"size": 4})


def test_a_mistake_on_the_command_line_has_no_line_of_the_file(tmp_path):
    path = tmp_path / "my.yaml"
    path.write_text(f"study: a\n{GRIDS.replace('0.3', '-1')}contact: point\n")
    config = yaml.safe_load(path.read_text()) | {"contact": "tip", "size": 4}
    config["grids"]["main"]["theta"] = [1, 0.5]
    with pytest.raises(StudyError) as error:
        read_study([path], config)
    *changed, written = [
        told.partition(" is not")[0].partition(";")[0] for told in error.value.mistakes
    ]
    assert sorted(changed) == [
        "--config: contact: 'tip'",
        "--config: grids.main.theta[1]: 0.5",
        "--config: the study file: unknown key 'size'",
    ]
    assert written == f"{path}:5: grids.main.mu0[0]: -1"
