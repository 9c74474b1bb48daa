"""The end of a Parquet file, for row groups that were encoded one by one.

pyarrow encodes the row groups of a file one after the other. To encode them in several threads each
is made a file of its own, and then put into the file of all. There only the numbers that say where
it is are others. They are in the metadata that a file ends with, before their length and a mark.

The metadata are a structure of Thrift's compact protocol [1]_; its fields have the numbers of [2]_.

.. [1] https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md
.. [2] https://github.com/apache/parquet-format/blob/master/src/main/thrift/parquet.thrift
"""

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias, Union

# At both ends of a file; and the bytes of the length and the mark behind the metadata.
MARK = b"PAR1"
TAIL = 8

# What becomes of fields, by their numbers: of whole numbers, or of structures and lists of them.
Change: TypeAlias = Union[Callable[[int], int], "Changes"]
Changes: TypeAlias = Mapping[int, Change]

# Types of fields. A truth is its type, without further bytes.
_TRUTHS, _BYTE, _WHOLE, _DOUBLE, _BYTES, _LIST, _STRUCTURE = (1, 2), 3, (4, 5, 6), 7, 8, 9, 12
# Fields of a file's metadata.
_ROWS, _ROW_GROUPS = 3, 4
# A list of so many elements and more has their number behind its head.
_LONG = 15


def start(file: bytes | memoryview) -> int:
    """Where the metadata begin in a file, or in as much of its end as there is."""
    return len(file) - TAIL - int.from_bytes(file[-TAIL : -len(MARK)], "little")


def row_group(metadata: bytes, by: int, number: int) -> bytes:
    """Metadata of a row group as they are in another file.

    Parameters
    ----------
    metadata : bytes
        Of a file with one row group.
    by : int
        How many bytes further on the row group is in the other file.
    number : int
        How many row groups are before it.

    Returns
    -------
    bytes
    """

    def moved(offset: int) -> int:
        return offset + by if offset else 0  # 0 where it is not said

    columns: Changes = {2: moved, 3: {9: moved, 11: moved}}
    # Behind the head of a list of one element
    first = _fields(metadata)[_ROW_GROUPS].start + 1
    found = bytearray()
    _copy(metadata, first, _STRUCTURE, {1: columns, 5: moved, 7: lambda _: number}, found)
    return bytes(found)


def with_row_groups(metadata: bytes, row_groups: Sequence[bytes], rows: int) -> bytes:
    """Put row groups into the metadata of a file that has none.

    Parameters
    ----------
    metadata : bytes
    row_groups : sequence of bytes
        As `row_group` returns them.
    rows : int
        In all of them.

    Returns
    -------
    bytes
    """
    fields = _fields(metadata)
    count = len(row_groups)
    short = count < _LONG
    head = bytes([(count if short else _LONG) << 4 | _STRUCTURE])
    return b"".join(
        [
            metadata[: fields[_ROWS].start],
            _spelled(_signless(rows)),
            metadata[fields[_ROWS].stop : fields[_ROW_GROUPS].start],
            head if short else head + _spelled(count),
            *row_groups,
            metadata[fields[_ROW_GROUPS].stop :],
        ]
    )


def _fields(metadata: bytes) -> dict[int, slice]:
    """Where the values of the fields of a structure are."""
    found = {}
    at = number = 0
    while metadata[at]:
        number, kind, begin = _head(metadata, at, number)
        at = _copy(metadata, begin, kind, {}, bytearray())
        found[number] = slice(begin, at)
    return found


def _copy(data: bytes, at: int, kind: int, change: Change, out: bytearray) -> int:
    """Append a value, changed, to other bytes, and return where it ends."""
    if callable(change):
        value, end = _number(data, at)
        out += _spelled(_signless(change(value >> 1 ^ -(value & 1))))
        return end
    end = at
    if kind == _STRUCTURE:
        number = 0
        while data[end]:
            number, inner, begin = _head(data, end, number)
            out += data[end:begin]
            end = _copy(data, begin, inner, change.get(number, {}), out)
        out.append(0)
        return end + 1
    if kind == _LIST:
        count, inner, end = _list_head(data, at)
        out += data[at:end]
        for _ in range(count):
            end = _copy(data, end, inner, change, out)
        return end
    if kind == _BYTES:
        length, end = _number(data, at)
        end += length
    elif kind in _WHOLE:
        _, end = _number(data, at)
    elif kind not in _TRUTHS:
        end += {_BYTE: 1, _DOUBLE: 8}[kind]
    out += data[at:end]
    return end


def _head(data: bytes, at: int, before: int) -> tuple[int, int, int]:
    """Return number and type of a field, and where its value begins."""
    step, kind = divmod(data[at], 16)
    if step:
        return before + step, kind, at + 1
    value, begin = _number(data, at + 1)
    return value >> 1, kind, begin


def _list_head(data: bytes, at: int) -> tuple[int, int, int]:
    """Return number and type of the elements of a list, and where they begin."""
    count, kind = divmod(data[at], 16)
    if count < _LONG:
        return count, kind, at + 1
    count, begin = _number(data, at + 1)
    return count, kind, begin


def _number(data: bytes, at: int) -> tuple[int, int]:
    """Read a number of seven bits in each byte, the least first, and return where it ends."""
    value = shift = 0
    while (byte := data[at]) & 0x80:
        value |= (byte & 0x7F) << shift
        shift += 7
        at += 1
    return value | byte << shift, at + 1


def _spelled(value: int) -> bytes:
    """Inverse of `_number`."""
    found = bytearray()
    while value > 0x7F:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    found.append(value)
    return bytes(found)


def _signless(value: int) -> int:
    """Spell a number with its sign as its last bit; none here is negative."""
    return value << 1
