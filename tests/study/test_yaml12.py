"""YAML 1.2 wherever a study is given, and mistakes in it with file and line."""

import pytest
import yaml

from vibrissa.errors import StudyError
from vibrissa.study.reading import read_study
from vibrissa.study.yaml12 import as_written, changes_of, loaded, text_of

STUDY = "study: a\ngrids: {g: {theta: [2], mu0: [0.3], eta: [0.85], dx0: [0.001]}}\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("study: a\n".encode("utf-16"), "my.yaml:1: not a text in UTF-8 .*; save it in this"),
        ("study: a\n# é\n".encode("latin-1"), "my.yaml:2: not a text in UTF-8"),
        (b"study: a\ngrids:\n\tg: 1\n", r"my.yaml:3: not valid YAML: found character '\\t'"),
        (b"study: a\n---\nstudy: b\n", "my.yaml:2: not valid YAML: .*another document"),
        (b"", "my.yaml: the file is empty; a study file has keys"),
        (b"- a\n", "my.yaml: a study file has keys with values"),
    ],
)
def test_a_file_that_is_no_study_is_reported_with_its_line(tmp_path, content, message):
    path = tmp_path / "my.yaml"
    path.write_bytes(content)
    with pytest.raises(StudyError, match=message):
        loaded(path, text_of(path))


@pytest.mark.parametrize(
    "written",
    ["chunk: {theta: 1}", "max_points: 1e7", 'study: "2024"', "strict: true", "chunk: {eta: 2}"],
)
def test_a_value_of_config_is_what_it_is_in_the_file(tmp_path, written):
    path = tmp_path / "my.yaml"
    path.write_text(STUDY)
    key, _, value = written.partition(": ")
    given = read_study(path, changes_of([f"{key}={value}"]))
    lines = [line for line in STUDY.splitlines() if not line.startswith(f"{key}:")]
    path.write_text("\n".join([*lines, written]))
    assert given.model_dump() == read_study(path).model_dump()


def test_what_is_no_text_asks_for_quotes(tmp_path):
    path = tmp_path / "my.yaml"
    path.write_text(STUDY)
    with pytest.raises(StudyError, match=r"--config: study: 2024 is a number .*; put a text in"):
        read_study(path, changes_of(["study=2024"]))
    # By YAML 1.1, a number and a date.
    for value in ("2024_01_15", "2024-01-15"):
        assert read_study(path, changes_of([f"study={value}"])).name == value
    with pytest.raises(StudyError, match=r"--config: chunk=\{theta: 1: not valid YAML"):
        changes_of(["chunk={theta: 1"])


def test_the_configuration_of_a_module_is_read_by_the_rules_of_its_file(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("other: 1\nsensor:\n  cycles: 010\n  dx0: 5e-3\n  deep: {a: 1:30}\n")
    by_snakemake = yaml.safe_load(path.read_text())["sensor"]
    assert by_snakemake["cycles"] == 8
    wanted = {"cycles": 10, "dx0": 0.005, "deep": {"a": "1:30"}}
    assert as_written(by_snakemake, [path]) == wanted
    # What no file has was made by a program.
    assert as_written({"cycles": 8}, [path]) == {"cycles": 8}


def test_many_coefficients_make_no_name_that_is_too_long(tmp_path):
    path = tmp_path / "my.yaml"
    values = [[0.123456789] * n for n in (12, 13)]
    path.write_text(STUDY.replace("dx0:", f"curvature: {values}, dx0:") + "chunk: {curvature: 1}\n")
    names = list(read_study(path).chunks)
    assert len(names) == 2 and max(map(len, names)) < 200
