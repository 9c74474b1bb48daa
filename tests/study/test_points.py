"""Points of a study from a file: what is read, cut into chunks, and refused."""

import pandas as pd
import pytest

from vibrissa.errors import StudyError
from vibrissa.study import points
from vibrissa.study.axes import MOUNTING_AXES
from vibrissa.study.reading import read_study

HEAD = "theta,mu0,eta,dx0\n"
ROWS = ("2,0.3,0.85,0.001", "1,.4,0.8,1e-3", "2,0.2,0.85,0.002", "3,0.2,0.85,0.001")
FILE = HEAD + "\n".join(ROWS) + "\n"
STUDY = """
study: mine
grids:
  scattered: {points: mine.csv}
  other: {theta: [1, 2], mu0: 0.3, eta: 0.85, dx0: 0.001}
"""


@pytest.fixture
def read(tmp_path):
    def read(text=STUDY, file=FILE, name="mine.csv"):
        if isinstance(file, str):
            (tmp_path / name).write_text(file)
        else:
            file.to_parquet(tmp_path / name)
        path = tmp_path / "my.yaml"
        path.write_text(text)
        return read_study(path)

    return read


def columns(study):
    return study.grids["scattered"].table.columns


def test_a_row_is_a_point_and_its_rod_is_solved_once(read):
    study = read()
    assert columns(study) == {
        "theta": [2.0, 1.0, 2.0, 3.0],
        "mu0": [0.3, 0.4, 0.2, 0.2],
        "eta": [0.85, 0.8, 0.85, 0.85],
        "dx0": [0.001, 0.001, 0.002, 0.001],
        **{axis: [0.0] * 4 for axis in MOUNTING_AXES},
    }
    table = study.grids["scattered"].table
    assert table.rods(by_step=False) == [[0, 2], [1], [3]]
    assert table.rods(by_step=True) == [[0], [1], [2], [3]]
    assert study.grids["scattered"].axes["theta"] == (1.0, 2.0, 3.0)
    assert study.data_files == ["mine.csv"]


def test_an_axis_that_is_the_same_for_all_points_may_be_a_key(read):
    file = "# measured\ntheta, mu0, curvature\n1, 0.3, 0.1 -0.3\n\n2, 0.4, 0.1 0\n"
    keys = "{points: mine.csv, eta: 0.85, dx0: 1e-3, clamp_angle: 0.1}"
    found = columns(read(STUDY.replace("{points: mine.csv}", keys), file))
    assert found["eta"] == [0.85, 0.85] and found["clamp_angle"] == [0.1, 0.1]
    assert found["curvature"] == [(0.1, -0.3), 0.1]


def test_a_row_may_have_a_stiffening_and_a_bore(read):
    file = "theta, mu0, stiffening, bore\n1, 0.3, 0.1 -0.3, 0.9\n2, 0.4, 0.2, 0.4\n"
    study = STUDY.replace("{points: mine.csv}", "{points: mine.csv, eta: 0.85, dx0: 1e-3}")
    found = columns(read(study, file))
    assert found["stiffening"] == [(0.1, -0.3), 0.2] and found["bore"] == [0.9, 0.4]
    with pytest.raises(StudyError, match=r"mine.csv:3: bore: .* 1/theta = 0\.5 d0, got 0\.5"):
        read(study, file.replace("0.2, 0.4", "0.2, 0.5"))


def test_a_parquet_file_has_the_same_points(read):
    frame = pd.DataFrame(columns(read())).drop(columns=list(MOUNTING_AXES))
    other = read(STUDY.replace("mine.csv", "mine.parquet"), frame, "mine.parquet")
    assert columns(other) == columns(read())
    assert (
        other.study_part("stiction").splitlines()[-1]
        == read().study_part("stiction").splitlines()[-1]
    )


def parts(study):
    return {name: study.chunk_part(name) for name in study.chunks if name.startswith("sc")}


def test_only_chunks_whose_points_change_are_others(read):
    text = "chunk: {rods: 2}\n" + STUDY
    before = read(text)
    assert [(chunk.rods, chunk.points) for chunk in list(before.chunks.values())[:2]] == [
        (2, 3),
        (1, 1),
    ]
    assert list(parts(before)) == ["scattered/rod1", "scattered/rod3"]
    remark = read(text, "# a remark\n" + FILE.replace("1e-3", " 0.001"))
    assert parts(remark) == parts(before) and remark.study_part("stiction") == before.study_part(
        "stiction"
    )
    edited = read(text, FILE.replace("3,0.2", "3,0.25"))
    assert parts(edited)["scattered/rod1"] == parts(before)["scattered/rod1"]
    assert parts(edited)["scattered/rod3"] != parts(before)["scattered/rod3"]
    assert edited.study_part("stiction") != before.study_part("stiction")
    more = read(text, FILE + "9,0.2,0.85,0.001\n4,0.2,0.85,0.001\n")
    assert list(parts(more)) == ["scattered/rod1", "scattered/rod3", "scattered/rod5"]
    assert parts(more)["scattered/rod1"] == parts(before)["scattered/rod1"]


def test_rods_of_a_chunk_are_limited_in_a_product_too(read):
    study = read("chunk: {rods: 1}\n" + STUDY)
    assert sum(name.startswith("other/") for name in study.chunks) == 2


MISTAKES = {
    "missing column": (
        FILE.replace("mu0,", "").replace(",0.3", "").replace(",.4", "").replace(",0.2", ""),
        "mine.csv has no column 'mu0'; it has theta, eta, dx0. Add the column, or the key mu0",
    ),
    "unknown column": (FILE.replace("dx0", "dx"), "mine.csv: 'dx' is not an axis; remove it; allo"),
    "doubled column": (FILE.replace("mu0", "eta"), "mine.csv has two columns 'eta'; remove one"),
    "out of range": (
        FILE.replace("1,.4", "0.5,.4"),
        "mine.csv:3: theta: '0.5' is not allowed: input should be greater than or equal to 1; co",
    ),
    "not a number": (
        FILE.replace(".4", "nan"),
        "mine.csv:3: mu0: 'nan' is not allowed: input should be a finite number; correct it, or ",
    ),
    "empty cell": (FILE.replace(",.4", ","), "mine.csv:3: mu0: '' is not allowed: input should be"),
    "a text": (FILE.replace("1e-3", "1 mm"), "mine.csv:3: dx0: '1 mm' is not allowed: input"),
    "a short row": (FILE.replace(",1e-3", ""), "mine.csv:3: the row has 3 values, but the first "),
    "semicolons": (FILE.replace(",", ";"), "it has theta;mu0;eta;dx0"),
    "the same point": (
        FILE + "3.0,0.2,.85,1e-3\n",
        "mine.csv:6: the same point as in mine.csv:5; remove one of them",
    ),
    "no rows": (HEAD, "mine.csv has no rows; it needs a row for each point"),
    "no text": ("", "mine.csv has no rows"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_in_the_file_has_its_row_and_column(read, name):
    file, words = MISTAKES[name]
    with pytest.raises(StudyError) as raised:
        read(file=file)
    assert all(
        line.startswith("my.yaml:4: grids.scattered.points: ") or "/my.yaml:4: " in line
        for line in str(raised.value).splitlines()
    )
    assert words in str(raised.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mine.csv", "none.csv", "there is no file none.csv in the study file's folder or below"),
        ("mine.csv", "../mine.csv", "there is no file ../mine.csv in the study file's folder or b"),
        ("mine.csv", "my.yaml", "my.yaml: the name must end in .csv or .parquet"),
        ("mine.csv}", "mine.csv, dx0: 1}", "mine.csv has the column 'dx0', which is also a key of"),
        ("mine.csv}", "mine.csv, eta: [0.8, 0.9]}", "scattered.eta: [0.8, 0.9] is not allowed: in"),
        (
            "mine.csv}",
            "mine.csv, etta: 1}",
            "'etta' is not a valid key; allowed: bore, clamp",
        ),
        ("study: mine", "study: mine\nmax_points: 5", "the study has 6 points, counting each"),
        (
            STUDY[-1],
            "\nfigures: {f: {kind: friction, grid: scattered}}\n",
            "'scattered' does not have all combinations of its values, as a figure of kind frict",
        ),
    ],
)
def test_mistakes_in_the_study_file(read, old, new, words):
    text = STUDY[:-1] + new if old == "\n" else STUDY.replace(old, new)
    with pytest.raises(StudyError) as raised:
        read(text)
    assert words in str(raised.value)


def test_points_that_are_a_product_can_be_drawn_as_one(read):
    rows = [f"{theta},{mu0},0.85,0.001" for theta in (1, 2) for mu0 in (0.2, 0.3)]
    study = read(STUDY + "figures: {f: {kind: taper, grid: scattered}}\n", HEAD + "\n".join(rows))
    assert study.grids["scattered"].is_product


def test_many_mistakes_and_many_rows_are_short(read, monkeypatch):
    with pytest.raises(StudyError) as raised:
        read(file=FILE.replace("0.8", "8"))
    assert len(str(raised.value).splitlines()) == 4
    monkeypatch.setattr(points, "REPORTED_CELLS", 2)
    with pytest.raises(StudyError, match=r"mine\.csv: and 2 more cells$"):
        read(file=FILE.replace("0.8", "8"))
    monkeypatch.setattr(points, "MOST_ROWS", 3)
    with pytest.raises(StudyError, match=r"has 4 rows; allowed: 3; spread them over several"):
        read()


def test_a_damaged_parquet_file_is_named(read):
    with pytest.raises(StudyError, match=r"mine\.parquet cannot be read as a Parquet file: "):
        read(STUDY.replace("mine.csv", "mine.parquet"), "no table", "mine.parquet")
    frame = pd.DataFrame({"theta": [1, 2], "mu0": [0.3, None], "eta": 0.85, "dx0": 0.001})
    with pytest.raises(StudyError, match=r"mine\.parquet, row 2: mu0: None is not allowed"):
        read(STUDY.replace("mine.csv", "mine.parquet"), frame, "mine.parquet")
