"""Readings of a study file: chunks of recordings, their random numbers, and mistakes."""

import re

import pytest
import yaml

from vibrissa.errors import StudyError
from vibrissa.pipeline.suitable import readings as check
from vibrissa.study.reading import read_study
from vibrissa.study.readings import digest_of_point

STUDY = """
study: demo
scans:
  runs: {theta: [1, 2], eta: 0.85, dx0: [0.001, 0.002], mu0: 0.3, to: 0.15}
readings:
  tapers:
    scan: runs
    transducer: [nano17-si-12-0.12, mini40-si-40-2]
    rod: {modulus: 210 GPa, diameter: 0.8 mm, length: 100 mm}
    method: [model, ratio]
    errors: drawn
    tolerances: default
    recordings: 7
    seed: 1
"""
CARD = """
limit = "1 N, 1 N, 10 N*mm"
resolution = "1 mN, 1 mN, 10 uN*m"
"""


@pytest.fixture
def read(tmp_path):
    def read(text):
        path = tmp_path / "my.yaml"
        path.write_text(text)
        (tmp_path / "mine.toml").write_text(CARD)
        return read_study(path, check=check)

    return read


def test_a_chunk_has_recordings_of_one_point(read):
    study = read(STUDY + "chunk: {recordings: 3}\n")
    chunks = list(study.reading_chunks.values())
    assert [(one.first, one.last) for one in chunks[:3]] == [(1, 3), (4, 6), (7, 7)]
    assert len(chunks) == 3 * 2 * 2 * 2
    assert [one.point["transducer"] for one in chunks[:4:3]] == [
        "nano17-si-12-0.12",
        "mini40-si-40-2",
    ]
    assert "friction" in study.tables and "tables/friction.parquet" in study.results
    part = yaml.safe_load(study.study_part("friction"))
    assert part.keys() == {"study", "scans", "readings"}


def test_other_values_and_chunks_do_not_change_the_digest_of_a_point(read):
    def digests(text):
        return {digest_of_point(one.point) for one in read(text).reading_chunks.values()}

    few = digests(STUDY)
    assert few < digests(STUDY.replace("theta: [1, 2]", "theta: [0.5e+1, 1, 1.5, 2]"))
    assert few == digests(STUDY + "chunk: {recordings: 1}\n")
    assert few == digests(STUDY.replace("recordings: 7", "recordings: 9"))
    assert few.isdisjoint(digests(STUDY.replace("mu0: 0.3", "mu0: 0.30001")))


def test_a_transducer_may_be_a_file(read):
    study = read(STUDY.replace("[nano17-si-12-0.12, mini40-si-40-2]", "mine.toml"))
    (chunk, *_) = study.reading_chunks.values()
    assert study.data_files == ["mine.toml"]
    # The content counts, wherever the file is.
    assert chunk.point["card"] not in study.reading_chunk_part(chunk.name)
    assert chunk.point["card_content"] in study.reading_chunk_part(chunk.name)
    assert chunk.point["card_content"] in study.study_part("friction")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("scan: runs", "scan: laws", "readings.tapers.scan: 'laws' is not the name of a scan"),
        ("scan: runs", "scam: runs", "'scam' is not a valid key; allowed: errors, method,"),
        ("[model, ratio]", "[model, model]", "readings.tapers.method: model, model has a name"),
        ("[model, ratio]", "moment", "input should be 'model' or 'ratio'"),
        ("errors: drawn", "errors: random", "'random' is not allowed"),
        ("recordings: 7", "recordings: 0", "input should be greater than or equal to 1"),
        ("seed: 1", "seed: -1", "input should be greater than or equal to 0"),
        ("nano17-si-12-0.12,", "nano18,", "readings.tapers.transducer[0]: "),
        ("mini40-si-40-2", "gone.toml", "there is no file gone.toml in the study file's folder"),
        ("0.8 mm", "0.8", "readings.tapers.rod: diameter"),
        ("length: 100 mm", "length: 100 mm, material: wood", "readings.tapers.rod: "),
        ("errors: drawn", "errors: {etta: 0.1 mm}", "errors.etta: a tolerance must be for one of"),
        ("errors: drawn", "errors: {eta: 0.1}", None),
        ("errors: drawn", "errors: {eta: 0.1 N}", "errors.eta: the tolerance of eta must be a"),
        ("errors: drawn", "errors: {clamp_compliance: -0.1}", "clamp_compliance by -0.1 is not"),
        (
            "tolerances: default",
            "tolerances: {eta: -0.1 mm}",
            "tolerances.eta: the tolerance of eta must not be negative",
        ),
        (
            "tolerances: default",
            "tolerances: {others: none}",
            "readings.tapers.tolerances.others: none is not allowed; allowed: default, exact",
        ),
        (
            "tolerances: default",
            "tolerances: {tip_radius: 0.1 mm}",
            "tolerances.tip_radius: recordings are simulated with a sharp tip",
        ),
        ("study: demo", "study: demo\ncontact: line", "the contact must be point, not line"),
        ("study: demo", "study: demo\nmethod: shooting", "readings need `method: collocation`"),
        ("mu0: 0.3", "mu0: 0.3, curvature: [[0.1, 0.2]]", "lists of coefficients; readings need"),
        (
            "mu0: 0.3",
            "mu0: 0.3, stiffening: [[0.1, 0.2]]",
            "lists of coefficients; readings need",
        ),
        ("recordings: 7", "recordings: 1e6", "max_points: the study has 900,000,450 points"),
    ],
)
def test_mistakes_are_reported_with_their_line(read, old, new, message):
    assert STUDY.count(old) == 1
    if message is None:
        read(STUDY.replace(old, new))
        return
    with pytest.raises(StudyError) as caught:
        read(STUDY.replace(old, new))
    text = str(caught.value)
    assert message in text
    # The key max_points has no line, as it is not written.
    assert re.search(r"my.yaml:([0-9]+:| max_points)", text.splitlines()[0])


def test_all_mistakes_of_rods_and_tolerances_are_reported_together(read):
    text = STUDY.replace("drawn", "{eta: 1 N, theta: 1 mm}").replace("nano17", "nano18")
    with pytest.raises(StudyError) as caught:
        read(text)
    lines = str(caught.value).splitlines()
    assert [line.split(": ")[1] for line in lines] == [
        "readings.tapers.transducer[0]",
        "readings.tapers.errors.eta",
        "readings.tapers.errors.theta",
    ]


def test_tolerances_may_be_those_of_some_quantities_alone(read):
    stated = "tolerances: {eta: 0.1 mm, others: exact}"
    section = read(STUDY.replace("tolerances: default", stated)).readings["tapers"]
    assert section.stated == {"eta": "0.1 mm"} and not section.assumes
    assert not read(STUDY.replace(": default", ": exact")).readings["tapers"].assumes
    section = read(STUDY.replace(": default", ": {eta: 0.1 mm}")).readings["tapers"]
    assert section.stated == {"eta": "0.1 mm"} and section.assumes
