"""Bytes to text: the encoding is told by its mark, by zero bytes, or as what remains.

A file is UTF-8 if it can be. That a file of another encoding can be is unlikely: each of its
letters beyond ASCII would have to be followed by just such another one. Libraries that guess by the
frequency of letters need much text; a recording has a handful of such letters.
"""

import codecs
from typing import NamedTuple

from vibrissa.errors import ArgumentError, RecordingError

MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
# Western letters as Windows writes them; those that Latin-1 has are the same there.
WESTERN = "cp1252"
# ASCII in UTF-16 has a zero in every second byte: here of so many bytes at least this part.
LOOKED_AT, ZEROS = 4096, 0.8


class Decoded(NamedTuple):
    """Text of a file and the encoding it was in."""

    text: str
    encoding: str


def decoded(data: bytes, name: str, encoding: str | None = None) -> Decoded:
    """Decode a text file.

    Parameters
    ----------
    data : bytes
    name : str
        Of the file, for messages.
    encoding : str, optional
        As Python names it, such as ``latin-1``; found by default.

    Raises
    ------
    ArgumentError
        If there is no such encoding.
    RecordingError
        If it is no text.
    """
    encoding = _known(encoding) if encoding is not None else _encoding_of(data)
    try:
        text = data.decode(encoding)
    except UnicodeError as error:
        raise RecordingError(f"{name}: not a text file in {encoding}: {error}") from None
    if "\0" in text:
        raise RecordingError(
            f"{name}: not a text file, as it has zero bytes: save the table as text (CSV)"
        )
    return Decoded(text, encoding)


def _known(encoding: str) -> str:
    try:
        "".encode(encoding)
    except LookupError:
        raise ArgumentError(
            f"encoding must be one that Python knows, such as utf-8 or latin-1, got {encoding!r}"
        ) from None
    return encoding


def _encoding_of(data: bytes) -> str:
    for mark, encoding in MARKS.items():
        if data.startswith(mark):
            return encoding
    start = data[:LOOKED_AT]
    for encoding, zeros in (("utf-16-le", start[1::2]), ("utf-16-be", start[::2])):
        if zeros.count(0) > ZEROS * len(zeros):
            return encoding
    try:
        data.decode()
    except UnicodeDecodeError:
        return WESTERN if _is(data, WESTERN) else "latin-1"
    return "utf-8"


def _is(data: bytes, encoding: str) -> bool:
    try:
        data.decode(encoding)
    except UnicodeDecodeError:
        return False
    return True
