"""Metadata of Parquet files, written by hand in Thrift's compact protocol."""

import pytest

from vibrissa.tables.parquet import footers


def number(value):
    """A whole number that is not negative: doubled, in groups of seven bits."""
    value *= 2
    groups = [value & 127]
    while value := value >> 7:
        groups.append(value & 127)
    return bytes([*(group | 128 for group in groups[:-1]), groups[-1]])


# What else may stand in a structure: a text, a number of eight bytes with its field's number in
# full, a byte, a truth, and a structure with a list of texts.
ELSE = (
    b"\x28\x03abc"
    + (b"\x07" + number(22) + b"\x01\x02\x03\x04\x05\x06\x07\xff")
    + b"\x11\x12\x13\x00"
    + b"\x1c\x19\x28\x01\x00\x02\x00\x00\x00"
    + b"\x00"
)


def metadata(rows, head, *row_groups):
    """Fields 1, 3 and 4, and what is behind: field 6 and more."""
    before = b"\x15" + number(2) + b"\x26" + number(rows)
    return before + b"\x19" + head + b"".join(row_groups) + ELSE


def row_group(at, place, where):
    """One column whose page is at a place, after its dictionary; and rows and more."""
    pages = b"\x15" + number(7) + b"\x86" + number(place + 50) + b"\x26" + number(place) + b"\x00"
    column = b"\x26" + number(at) + b"\x1c" + pages + b"\x00"
    return b"\x19\x1c" + column + b"\x16" + number(9) + b"\x36" + number(place) + where


def with_number(value):
    """Field 7, whose number stands in full."""
    return b"\x04" + number(7) + number(value) + ELSE


@pytest.mark.parametrize(("by", "count"), [(0, 0), (1, 1), (10**6, 2), (10**11, 300)])
def test_a_row_group_is_moved(by, count):
    one = metadata(9, b"\x1c", row_group(0, 4, with_number(0)))
    assert footers.row_group(one, by, count) == row_group(0, 4 + by, with_number(count))
    said = metadata(9, b"\x1c", row_group(70, 4, with_number(0)))
    assert footers.row_group(said, by, count) == row_group(70 + by, 4 + by, with_number(count))


@pytest.mark.parametrize(
    ("count", "head"),
    [
        (0, b"\x0c"),
        (1, b"\x1c"),
        (14, b"\xec"),
        (15, b"\xfc\x0f"),
        (127, b"\xfc\x7f"),
        (200, b"\xfc\xc8\x01"),
    ],
)
@pytest.mark.parametrize("rows", [0, 63, 64, 10**9])
def test_row_groups_are_put_into_metadata(count, head, rows):
    groups = [row_group(0, 4 + i, with_number(i)) for i in range(count)]
    found = footers.with_row_groups(metadata(0, b"\x0c"), groups, rows)
    assert found == metadata(rows, head, *groups)
    # What is there is passed over.
    assert footers.with_row_groups(found, [], 0) == metadata(0, b"\x0c")


def test_where_metadata_begin():
    assert footers.start(b"PAR1data" + b"m" * 300 + b"\x2c\x01\x00\x00PAR1") == 8
