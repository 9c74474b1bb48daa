"""Damaged recordings: each is refused by a message, doubted, or read correctly; never a traceback.

A friction is silently wrong if it is further than five of its deviations from the truth, its period
is not doubted, and no note names a line. The tables go through `identify` and `import`.
"""

import warnings
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from steel import SENSOR, TRANSDUCER
from steel import identified as friction_in
from vibrissa.errors import VibrissaError
from vibrissa.outcomes import Method
from vibrissa.scanning import surfaces
from vibrissa.sensor import PeriodStatus, Setup, scan
from vibrissa.sensor.identification.recording import read_recording, table_of
from vibrissa.sensor.importing import Settings, import_recording
from vibrissa.sensor.transducer import CHANNELS

WHISKER = Setup.read(
    theta=2, eta="85 mm", modulus="210 GPa", diameter="0.8 mm", length="100 mm"
).whisker
FRICTION = 0.3
TITLES = ("time [s]", "footpoint [mm]", "force_x [N]", "force_y [N]", "moment_z [N*m]")
WRONG = 5.0


@cache
def measured():
    """Rows of a recording of the known surface, as texts."""
    _ = WHISKER.response  # solved once, for all examples
    surface = surfaces.constant(FRICTION)
    signals = scan(WHISKER, surface, step="0.1 mm", to=["12 mm"], law="kinetic").measured(SENSOR)
    clamp = signals.truth.clamp * 100.0
    table = np.column_stack([np.arange(len(clamp)) / 100, clamp, signals.readings])
    return [list(map(repr, row)) for row in table.tolist()]


def text_of(rows, titles=TITLES, separator=",", ends="\n"):
    return ends.join(map(separator.join, [titles, *rows, []]))


def right(found):
    """Whether no friction is silently wrong."""
    periods = found.periods
    slips = (periods.status == PeriodStatus.SLIP) & np.array([not one for one in periods.doubt])
    off = np.abs(periods.mu0 - FRICTION) / periods.deviation
    return bool(periods.notes) or not (off[slips] > WRONG).any()


def identified(data, folder, whisker=WHISKER):
    """Identify a file; None if it was refused."""
    file = folder / "recording.csv"
    file.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return friction_in(whisker, file, transducer=TRANSDUCER if whisker else None)
        except VibrissaError as error:
            assert str(error)
            return None


def imported(data):
    """Import a file; None if it was refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = import_recording(data, Settings.read())
        except VibrissaError as error:
            assert str(error)
            return None
    sizes = {len(values) for values in found.values.values()}
    assert len(sizes) == 1 and not any(np.isinf(each).any() for each in found.values.values())
    return found


def reordered(rows, order):
    return text_of([[row[i] for i in order] for row in rows], [TITLES[i] for i in order])


HARMLESS = {
    "CRLF and a byte order mark": lambda rows: "\ufeff" + text_of(rows, ends="\r\n"),
    "further columns": lambda rows: text_of(
        [[*r, "ok", ""] for r in rows], [*TITLES, "phase", "b"]
    ),
    "another order": lambda rows: reordered(rows, [4, 2, 0, 1, 3]),
    "blank lines": lambda rows: text_of(rows).replace("\n", "\n\n"),
    "quotes": lambda rows: text_of([[f'"{cell}"' for cell in row] for row in rows]),
    "other units": lambda rows: text_of(
        [[a, f"{float(b) / 1e3:.17g}", c, d, f"{float(e) * 1e3:.17g}"] for a, b, c, d, e in rows],
        [*TITLES[:1], "footpoint [m]", *TITLES[2:4], "moment_z [N*mm]"],
    ),
}


@pytest.mark.parametrize("damage", HARMLESS)
def test_another_spelling_changes_nothing(damage, tmp_path):
    plain, data = text_of(measured()).encode(), HARMLESS[damage](measured()).encode()
    file = tmp_path / "recording.csv"
    readings = []
    for each in (plain, data):
        file.write_bytes(each)
        table = table_of(file, Method.MODEL)
        readings.append(read_recording(table, WHISKER.units, Method.MODEL, SENSOR).readings)
    assert readings[1] == pytest.approx(readings[0], rel=1e-12)
    wanted, found = (imported(each).values for each in (plain, data))
    for name in ("time", "footpoint", *CHANNELS):
        assert found[name] == pytest.approx(wanted[name], rel=1e-12)


ROWS = st.integers(0, 100)
CELLS = st.floats().map(repr) | st.text(max_size=8) | st.sampled_from(["", "NaN", "1,5", "#NV"])


@st.composite
def damaged(draw):
    """A recording that is damaged in one way."""
    rows = [list(row) for row in measured()]
    begin, size = draw(ROWS), draw(st.integers(1, 30))
    block = slice(begin, begin + size)
    column, other = draw(st.permutations(range(5)))[:2]
    kind = draw(
        st.sampled_from(["lost", "twice", "moved", "cell", "stuck", "swapped", "sign", "text"])
    )
    if kind == "lost":
        del rows[block]
    elif kind == "twice":
        rows[block] = rows[block] * 2
    elif kind == "moved":
        rows[block] = draw(st.permutations(rows[block]))
    elif kind == "cell":
        for row in rows[block][:: draw(st.integers(1, 30))]:
            row[column] = draw(CELLS)
    elif kind == "stuck":
        for row in rows[block]:
            row[column] = rows[begin][column]
    elif kind == "swapped":
        for row in rows:
            row[column], row[other] = row[other], row[column]
    elif kind == "sign":
        for row in rows:
            row[column] = repr(-float(row[column]))
    if kind != "text":
        return text_of(rows).encode(errors="surrogatepass")
    separator, ends = draw(st.sampled_from(";\t| ,")), draw(st.sampled_from(["\n", "\r", "\n\n"]))
    titles = draw(st.sampled_from([TITLES, TITLES[:4], TITLES[:1] * 5, ["1", "2", "3", "4", "5"]]))
    data = bytearray(text_of(rows, titles, separator, ends).encode())
    for place in draw(st.lists(st.integers(0, len(data) - 1), max_size=3)):
        data[place] = draw(st.integers(0, 255))
    return bytes(data[: draw(st.integers(0, 2 * len(data)))])


@pytest.mark.slow
@settings(max_examples=4, deadline=None)
@given(damaged(), st.booleans())
def test_damage_is_named_or_does_no_harm(tmp_path_factory, data, rod):
    found = identified(data, tmp_path_factory.mktemp("damaged"), WHISKER if rod else None)
    assert found is None or right(found), found.periods.mu0


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(damaged())
def test_damage_is_imported_or_refused_by_a_message(data):
    found = imported(data)
    assert found is None or len(found.values["footpoint"]) <= 2 * len(measured())


PIECES = st.sampled_from(
    [
        *(b"x [mm]", b"Fx [N]", b"Fy [N]", b";", b",", b"\t", b" ", b"\n", b"\r\n", b"1", b"2,5"),
        *(b"0.5", b"1,234", b"-", b'"', b"\xb5", b"\xff\xfe", b"NaN", b"e5", b"#", b"\x00"),
    ]
)


@pytest.mark.slow
@given(st.lists(PIECES, max_size=60).map(b"".join) | st.binary(max_size=300))
def test_any_bytes_are_a_table_or_a_message(data):
    columns = {"footpoint": "x [mm]", "force_x": "Fx [N]", "force_y": "Fy [N]"}
    try:
        found = import_recording(data, Settings.read(column=columns))
    except VibrissaError as error:
        assert str(error)
    else:
        assert len({len(values) for values in found.values.values()}) == 1


@pytest.mark.slow
def test_a_wrong_number_is_wrong(tmp_path):
    found = identified(text_of(measured()).encode(), tmp_path)
    assert right(found) and not found.periods.notes
    found.periods.mu0[1] += 6.0 * found.periods.deviation[1]
    assert not right(found)
