"""Encoding, separator, titles and decimal sign are found, or asked for."""

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibrissa.errors import RecordingError
from vibrissa.sensor.importing import Settings, import_recording
from vibrissa.sensor.importing.decoding import decoded
from vibrissa.sensor.importing.layout import FOOTER, SIGNS, Separator, layout_of

TITLES = ["Weg", "Fx", "Fz"]
ROWS = [(0.0, 0.5, -1.25), (0.02, 0.625, -1.375), (0.04, 0.75, -12.5), (0.06, 0.5, -1.0)]
HEADS = {
    "none": "",
    "words": "Prüfstand 7\nDatum: heute\n\n",
    "pairs": "Prüfer{s}Müller\nRate{s}50\n",
    "many": "1{s}2{s}3{s}4{s}5\n",
}
SOURCES = {"footpoint": "Weg [mm]", "force_x": "Fx [N]", "force_y": "Fz [N]"}


def written(sign, decimal, head="", ends="\n", units=False, footer=""):
    lines = [sign.join(TITLES)] + ([sign.join(["mm", "N", "N"])] if units else [])
    lines += [sign.join(f"{v:.4f}".replace(".", decimal) for v in row) for row in ROWS]
    return ends.join([*head.format(s=sign).split("\n")[:-1], *lines]) + ends + footer


def read(data, **settings):
    data = data if isinstance(data, bytes) else data.encode()
    values = import_recording(data, Settings.read(columns=SOURCES, **settings)).values
    scale = {"footpoint": 1e3}
    return np.stack([values[name] * scale.get(name, 1.0) for name in SOURCES], axis=1)


def cases():
    for sign in (";", "\t", ",", "|", " ", "   "):
        for decimal in ".,":
            if sign != decimal:
                yield from ((sign, decimal, head) for head in HEADS)


@pytest.mark.parametrize(("sign", "decimal", "head"), list(cases()))
@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_every_usual_file_is_read(sign, decimal, head, ends):
    for units in (False, True):
        text = written(sign, decimal, HEADS[head], ends, units, "Ende der Messung" + ends)
        assert read(text) == pytest.approx(np.array(ROWS), abs=1e-12)


def test_the_sniffer_of_python_does_not_do():
    wrong = 0
    for sign, decimal, head in cases():
        try:
            found = csv.Sniffer().sniff(written(sign, decimal, HEADS[head]), ";\t,| ").delimiter
        except csv.Error:
            found = None
        wrong += found != sign[0]
    assert wrong > len(list(cases())) // 4


@pytest.mark.parametrize(
    ("encoding", "found"),
    [
        ("latin-1", "cp1252"),
        ("cp1252", "cp1252"),
        ("utf-8", "utf-8"),
        ("utf-8-sig", "utf-8-sig"),
        ("utf-16", "utf-16"),
        ("utf-16-le", "utf-16-le"),
        ("utf-16-be", "utf-16-be"),
    ],
)
def test_encodings_are_found(encoding, found):
    text = written(";", ",", HEADS["words"])
    assert decoded(text.encode(encoding), "a") == (text, found)
    assert read(text.encode(encoding)) == pytest.approx(np.array(ROWS))


def test_bytes_are_no_text():
    with pytest.raises(RecordingError, match="not a text file"):
        decoded(b"PK\x03\x04\x00\x00" + bytes(range(256)), "a")


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        (["1,234", "2,345", "12,250", "9"], r"line 2: Fx = '1,234' may be 1.234 .* or 1234.0"),
        (["1.234", "2.345", "12.250", "9"], r"may be 1.234 .* or 1234.0"),
        (["1,5", "2.5", "3", "4"], "line 3: Fx must be a number with a decimal comma, got '2.5'"),
        (
            ["1,5", "OVLD", "3", "4"],
            "line 3: Fx must be a number, got 'OVLD': leave the cell empty",
        ),
        (["1,5", "2.5", "3", "OVLD"], "line 5: Fx must be a number, got 'OVLD': leave the cell"),
        (["12:03", "1", "3", "4"], "line 2: Fx must be a number, got '12:03': clock times"),
        (["1", "12:03:04,5", "3", "4"], "got '12:03:04,5': clock times are not read: give --rate"),
        (["1", "a 12:03", "3", "4"], "got 'a 12:03': leave the cell empty"),
        (["1,5", "inf", "3", "4"], "line 3: Fx must be a number"),
        (["1,5", "1e999", "3", "4"], "line 3: Fx must be a number"),
    ],
)
def test_ambiguous_and_wrong_numbers_are_refused(cells, message):
    text = "Weg;Fx;Fz\n" + "\n".join(f"{i};{cell};7" for i, cell in enumerate(cells))
    with pytest.raises(RecordingError, match=message):
        read(text)


def test_the_decimal_sign_may_be_told():
    text = "Weg;Fx;Fz\n" + "\n".join(f"{i};{i},234;7" for i in range(1, 5))
    assert read(text, decimal=",")[:, 1] == pytest.approx([1.234, 2.234, 3.234, 4.234])
    assert read(text, decimal=".")[:, 1] == pytest.approx([1234, 2234, 3234, 4234])


@pytest.mark.parametrize("cell", ["1.234,5", "1 234,5", "1'234,5", "1234,5", "1234,50", "+1234,5"])
def test_thousands_are_told_by_another_number(cell):
    text = "Weg;Fx;Fz\n" + "\n".join(f"{i};{cell};0,5" for i in range(4))
    assert read(text)[:, 1] == pytest.approx(1234.5)


def test_a_leading_zero_is_before_decimals():
    text = "Weg;Fx;Fz\n" + "\n".join(f"0,00{i};1,234;−7,000" for i in range(4))
    assert read(text)[1] == pytest.approx([1e-3, 1.234, -7.0])


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda lines: [*lines, "0,05;1", *lines[1:]], "line 6: 2 values"),
        (lambda lines: [*lines, "0,05;1;2;3", *lines[1:], *lines[1:]], "line 6: 4 values"),
        (
            lambda lines: [*lines, "Pause", *lines[1:]],
            "line 6: the table ends, but one more begins",
        ),
        (lambda lines: [*lines, "0,05;1"], "line 6: 2 values"),
        (lambda lines: ["Weg;Fx", *lines[1:]], "line 1: 2 titles, but there are 3"),
        (lambda lines: ["Weg;Fx", "", *lines[1:]], "line 1: 2 titles, but there are 3"),
        (lambda lines: ["Weg;Fx;Fx;Fz", *lines[1:]], "line 1: 4 titles, but there are 3"),
        (lambda lines: lines[1:], "There are no titles"),
        (lambda lines: [*lines[1:], "Ende;der;Messung"], "There are no titles"),
        (lambda lines: [lines[0], "Pause", *lines[1:]], "There are no titles"),
        (lambda lines: lines[:2], "no table"),
        (lambda lines: ["Weg;Fx;Fx", *lines[1:]], "several columns are called Fx"),
        (lambda lines: [line.replace(";", ",") for line in lines], "1: 3 titles, but there are 6"),
    ],
)
def test_lines_that_do_not_fit_are_named(damage, message):
    with pytest.raises(RecordingError, match=message):
        read("\n".join(damage(written(";", ",").strip().split("\n"))))


def test_columns_without_titles_have_numbers():
    text = "\n".join(written(";", ",").split("\n")[1:])
    numbered = {"footpoint": "#1 [mm]", "force_x": "-#2 [N]", "force_y": "#3 [N]"}
    found = import_recording(text.encode(), Settings.read(columns=numbered)).values
    assert found["force_x"] == pytest.approx(-np.array(ROWS)[:, 1])


def test_columns_of_words_and_empty_columns_do_no_harm():
    lines = written(";", ",").strip().split("\n")
    text = "\n".join([lines[0] + ";Phase;", *(line + ";ok;" for line in lines[1:])])
    assert read(text) == pytest.approx(np.array(ROWS))
    trailing = "\n".join([lines[0], *(line + ";" for line in lines[1:])])
    assert read(trailing) == pytest.approx(np.array(ROWS))
    assert read("\n".join([lines[0] + ";;", *lines[1:]])) == pytest.approx(np.array(ROWS))


def test_the_line_of_the_titles_may_be_told():
    matrix = "a;b;c\n" + "1;2;3\n" * 8 + "\n"
    text = matrix + written(";", ",")
    with pytest.raises(RecordingError, match="line 11: the table ends, but one more begins"):
        layout_of(text, "a")
    assert read(text, titles=11) == pytest.approx(np.array(ROWS))


@given(
    st.sampled_from(list(SIGNS)),
    st.sampled_from(".,"),
    st.lists(st.floats(-1e6, 1e6, width=32), min_size=12, max_size=60),
)
def test_what_was_written_comes_back_or_is_asked_for(separator, decimal, numbers):
    sign = SIGNS[separator]
    if sign == decimal:
        return
    rows = [numbers[i : i + 3] for i in range(0, len(numbers) - 2, 3)]
    lines = [sign.join(TITLES)]
    lines += [sign.join(f"{v:.3f}".replace(".", decimal) for v in row) for row in rows]
    try:
        layout = layout_of("\n".join(lines), "a")
        told = import_recording(
            "\n".join(lines).encode(), Settings.read(columns=SOURCES, begin="-9 km", end="9 km")
        ).values["force_x"]
    except RecordingError as error:
        assert "may be" in str(error)
    else:
        assert layout.separator == separator
        wanted = [float(f"{row[1]:.3f}") for row in rows]
        assert told.tolist() == pytest.approx(wanted, abs=1e-9)
    assert set(Separator) > set(SIGNS)


NUMBERS = "0,0;0,5;-1,25\n0,1;0,6;-1,3\n0,2;0,7;-1,5\n0,3;0,5;-1,0\n"


def test_words_below_the_table_are_no_titles():
    found = layout_of(f"mm;N;kN\n{NUMBERS}end;of;all", "a file")
    assert found.titles == ("mm", "N", "kN")
    assert found.left_out == {FOOTER: (6,)}


def test_lines_of_titles_and_units_are_those_that_are_there():
    for head, titles, units in (
        ("", 0, 0),
        ("Weg;Fx;Fz\n", 1, 0),
        ("Bench 7\nmm;N;kN\n", 2, 0),
        ("Bench 7\nWeg;Fx;Fz\nmm;N;kN\n", 2, 3),
    ):
        found = layout_of(head + NUMBERS, "a file")
        assert (found.title_line, found.unit_line) == (titles, units)
