"""Encoding, separator, decimal sign, titles and units are found, or asked for."""

from itertools import cycle, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibrissa.errors import RecordingError
from vibrissa.sensor.importing import Settings, import_recording
from vibrissa.sensor.importing.delimited import SEPARATORS
from vibrissa.sensor.importing.layout import layout_of_text

TITLES = ["Weg", "Fx", "Fz"]
ROWS = [(0.0, 0.5, -1.25), (0.02, 0.625, -1.375), (0.04, 0.75, -12.5), (0.06, 0.5, -1.0)]
HEADS = {
    "none": "",
    "words": "Prüfstand 7\nDatum: heute\n\n",
    "pairs": "Prüfer{s}Müller\nRate{s}50\n",
    "many": "1{s}2{s}3{s}4{s}5\n" + "Offset{s}1{s}2\n" * 3,
}
SOURCES = {"footpoint": "Weg [mm]", "force_x": "Fx [N]", "force_y": "Fz [N]"}


def written(sign, decimal, head="", ends="\n", units=False, footer=""):
    lines = [sign.join(TITLES)] + ([sign.join(["mm", "N", "N"])] if units else [])
    lines += [sign.join(f"{v:.4f}".replace(".", decimal) for v in row) for row in ROWS]
    return ends.join([*head.format(s=sign).split("\n")[:-1], *lines]) + ends + footer


def read(data, sources=SOURCES, **settings):
    data = data if isinstance(data, bytes) else data.encode()
    values = import_recording(data, Settings.read(column=sources, **settings)).values
    return np.stack([values[name] * {"footpoint": 1e3}.get(name, 1) for name in SOURCES], axis=1)


def cases():
    """Each separator with each decimal sign and head; each head and separator with all ends."""
    signs = product((";", "\t", ",", "|", " ", "   "), ".,")
    usual = ((*pair, head) for pair in signs for head in HEADS if pair != (",", ","))
    return [(*case, ends) for case, ends in zip(usual, cycle(("\n", "\r\n", "\r")), strict=False)]


@pytest.mark.parametrize(("sign", "decimal", "head", "ends"), cases())
def test_every_usual_file_is_read(sign, decimal, head, ends):
    for units in (False, True):
        text = written(sign, decimal, HEADS[head], ends, units, "Ende der Messung" + ends)
        assert read(text) == pytest.approx(np.array(ROWS), abs=1e-12)


@pytest.mark.parametrize(
    ("head", "row"),
    [
        ("#\tt [s]\tWeg [mm]\tFx [N]\t", "{n}\t{t}\t{x}\t{f}\t"),
        ("t;Weg;Fx;v\ns;mm;N;mm/s", "{t};{x};{f};1"),
        ("t;Weg;Fx\ns;mm;N\n;;", "{t};{x};{f}"),
        ("t [s];Weg [mm];Fx (raw)\n;;N", "{t};{x};{f}"),
    ],
)
def test_columns_and_units_of_unusual_heads_are_found(head, row, snapshot):
    rows = [row.format(n=n, t=n / 10, x=n / 2, f=-n / 4) for n in range(1, 9)]
    columns = {"time": "t", "footpoint": "Weg", "force_y": "Fx"}
    empty = "".join(sign for sign in rows[0] if sign in ";\t")
    blank = "\t" * (";" in empty)
    data = "\n".join([head, *rows[:2], empty, blank, "# tapped", *rows[2:]]).encode()
    found = import_recording(data, Settings.read(column=columns))
    wanted = np.arange(1, 9)[:, None] * [0.1, 0.5e-3, -0.25]
    assert np.stack([found.values[name] for name in columns], axis=1) == pytest.approx(wanted)
    assert found.report() == snapshot
    del columns["time"]
    counted = import_recording(data, Settings.read(column=columns, rate="10 Hz")).values["time"]
    assert (10 * counted).tolist() == [0, 1, *range(3, 9)]  # the third sample is lost


@pytest.mark.parametrize("encoding", ["latin-1", "cp1252", "utf-8", "utf-8-sig", "utf-16"])
def test_encodings_are_found(encoding):
    text = written(";", ",", HEADS["words"]).replace("Fx", "Kräfte")
    assert read(text.encode(encoding), SOURCES | {"force_x": "Kräfte [N]"})[0, 1] == 0.5


def test_bytes_are_no_text():
    with pytest.raises(RecordingError, match="not a text file"):
        read(b"\x7fELF\x00\x00" + bytes(range(256)))
    with pytest.raises(RecordingError, match="not a spreadsheet that can be read"):
        read(b"PK\x03\x04\x00\x00" + bytes(range(256)))


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        (["1,234", "2,345", "12,250", "9"], "line 2: .*'1,234' may mark .*: add --decimal"),
        (["9", "2.345", "12.250", "9"], "line 3: the separator in '2.345' may mark decimals or"),
        (["1,5", "2.5", "3,5", "4"], "line 3: force_x must be empty or a number.*, got '2.5'"),
        (["1,5", "2.5", "3,5", "4.5"], "line 2: force_x .*, got '1,5'\n.*line 4: force_x"),
        (["1,5", "OVLD", "3", "4"], "line 3: force_x must be empty or .*got 'OVLD'"),
        (["1,5", "1e999", "3", "4"], "line 3: force_x must be empty or a number"),
    ],
)
def test_ambiguous_and_wrong_numbers_are_refused(cells, message):
    text = "Weg;Fx;Fz\n" + "\n".join(f"{i};{cell};7" for i, cell in enumerate(cells))
    with pytest.raises(RecordingError, match=message):
        read(text)


def test_the_decimal_sign_may_be_told_or_another_number_decides():
    lines = [f"{i};{1 + i % 998},234;7" for i in range(3000)]
    text = "Weg;Fx;Fz\n" + "\n".join(lines)
    with pytest.raises(RecordingError, match="may mark decimals or thousands"):
        read(text)
    assert read(text, decimal=",")[:2, 1] == pytest.approx([1.234, 2.234])
    with pytest.raises(RecordingError, match=r"line 2: force_x .* got '1,234'"):
        read(text, decimal=".")
    assert read(f"{text}\n3000;0,5;7")[:2, 1] == pytest.approx([1.234, 2.234])


def test_a_leading_zero_is_before_decimals():
    text = "Weg;Fx;Fz\n" + "\n".join(f"0,00{i};1,234;−7,000" for i in range(4))
    assert read(text)[1] == pytest.approx([1e-3, 1.234, -7.0])


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda lines: [*lines, "0,05;1", *lines[1:]], "line 6: 2 values, but line 2 has 3"),
        (lambda lines: [*lines, "0,05;1;2;3", *lines[1:], "1"], "6: 4 values.*\n.*11: 1 value,"),
        (lambda lines: [*lines, "Pause;;", *lines[1:]], "line 6: footpoint .* got 'Pause'"),
        (lambda lines: ["Weg;Fx", *lines[1:]], "from line 2 on are: #1, #2, #3$"),
        (lambda lines: ["Weg;Fx;Fx;Fz", *lines[1:]], "from line 2 on are: #1, #2, #3$"),
        (lambda lines: lines[1:], "no column Weg"),
        (lambda lines: lines[:2], "no table was found; needed: at least 2 columns and 3 rows"),
        (lambda lines: ["Weg;Fx;Fx", *lines[1:]], "several columns are called Fx"),
        (lambda lines: [line.replace(";", ",") for line in lines], "line 2 on are: #1, .*, #6$"),
        (lambda lines: [*lines, *lines[1:], '0,05;"1;2', *lines[1:]], "line 10: unpaired quotes"),
        (lambda lines: ["Weg;Fx;Fz", *["0;;1"] * 3, "lost;a;b", *lines[1:]], "5: .* got 'lost'"),
        (lambda lines: [*(f"{one};" for one in lines), "lost", *["0;0;1;tap"] * 5], "line 6"),
    ],
)
def test_lines_that_do_not_fit_are_named(damage, message):
    with pytest.raises(RecordingError, match=message):
        read("\n".join(damage(written(";", ",").strip().split("\n"))))


def test_columns_without_titles_have_numbers():
    text = "\n".join(written(";", ",").split("\n")[1:])
    numbered = {"footpoint": "#1 [mm]", "force_x": "-#2 [N]", "force_y": "#3 [N]"}
    assert read(text, numbered)[:, 1] == pytest.approx(-np.array(ROWS)[:, 1])
    assert read(f"a;b\n{text}", numbered)[:, 1] == pytest.approx(-np.array(ROWS)[:, 1])
    with pytest.raises(RecordingError, match="no column #4"):
        read(text, numbered | {"force_y": "#4 [N]"})


def test_columns_of_words_and_empty_columns_do_no_harm():
    lines = written(";", ",").strip().split("\n")
    text = "\n".join([lines[0] + ";Phase;", *(line + ";ok;" for line in lines[1:])])
    assert read(text) == pytest.approx(np.array(ROWS))
    trailing = "\n".join([lines[0], *(line + ";" for line in lines[1:])])
    assert read(trailing) == pytest.approx(np.array(ROWS))
    assert read("\n".join([lines[0] + ";;", *lines[1:]])) == pytest.approx(np.array(ROWS))


def test_comments_may_be_anywhere_and_hold_the_titles():
    lines = written(" ", ".").split("\n")
    text = "\n".join(["# Weg [mm] Fx [N] Fz [N]", lines[1], "# here it was tapped", *lines[2:]])
    found = import_recording(
        text.encode(), Settings.read(column={n: s.split()[0] for n, s in SOURCES.items()})
    )
    assert found.values["force_x"] == pytest.approx(np.array(ROWS)[:, 1])
    assert "comments in 1 row, left out: line 3" in found.notes


@pytest.mark.slow
@settings(max_examples=15)
@given(
    st.sampled_from(list(SEPARATORS)),
    st.sampled_from(".,"),
    st.lists(st.floats(-1e6, 1e6, width=32), min_size=12, max_size=60),
)
def test_what_was_written_comes_back_or_is_asked_for(separator, decimal, numbers):
    sign = SEPARATORS[separator]
    if sign == decimal:
        return
    rows = [numbers[i : i + 3] for i in range(0, len(numbers) - 2, 3)]
    lines = [sign.join(TITLES)]
    lines += [sign.join(f"{v:.3f}".replace(".", decimal) for v in row) for row in rows]
    text = "\n".join(lines)
    wanted = np.array([[float(f"{value:.3f}") for value in row] for row in rows])
    try:
        layout = layout_of_text(text.encode(), "a")
    except RecordingError as error:
        assert "may have" in str(error)
        assert read(text, decimal=decimal) == pytest.approx(wanted)
    else:
        assert layout.notes[0].startswith(f"separator {separator}, ")
        assert read(text) == pytest.approx(wanted)
