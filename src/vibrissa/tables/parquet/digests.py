"""Digests of Parquet files, in their own metadata: of all bytes but the digest itself.

The digest of a short file is that of its bytes. A long one is hashed in several threads, each row
group by itself: its digest is that of the digests of its row groups and of what is around them.
"""

import hashlib
import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from vibrissa.tables.parquet import footers

# Names of the digests of short and of long files in their metadata.
DIGEST, DIGEST_OF_PARTS = b"vibrissa.sha256", b"vibrissa.sha256_of_row_groups"
# What stands in the place of a digest while it is computed.
NO_DIGEST = b"0" * hashlib.sha256().digest_size * 2
# Bytes that are read together.
_CHUNK = 2**20


def is_right(path: Path) -> bool:
    """Whether a Parquet file has the digest that it says, or says none."""
    metadata = pq.read_metadata(path)
    said: Mapping[bytes, bytes] = metadata.metadata or {}
    if DIGEST in said:
        return _of_short(path, said[DIGEST]) == said[DIGEST]
    if DIGEST_OF_PARTS not in said:
        return True
    columns = (metadata.row_group(i).column(0) for i in range(metadata.num_row_groups))
    begins = [column.dictionary_page_offset or column.data_page_offset for column in columns]
    places = pairwise([*begins, _start_of_metadata(path)])
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        digests = list(threads.map(lambda place: _sha256(path, *place).digest(), places))
    recorded = said[DIGEST_OF_PARTS]
    with path.open("rb") as file:
        around = file.read(len(footers.MARK)) + _end(path)
    return of_parts(digests, around.replace(recorded, NO_DIGEST)) == recorded


def of_parts(digests: Iterable[bytes], around: bytes) -> bytes:
    """Digest of a long file, as text.

    Parameters
    ----------
    digests : iterable of bytes
        Of its row groups, in the order in which they stand in the file.
    around : bytes
        What is before and behind them, with `NO_DIGEST`.

    Returns
    -------
    bytes
    """
    return hashlib.sha256(b"".join(digests) + around).hexdigest().encode()


def put(path: Path) -> None:
    """Record the digest of a short file in its metadata."""
    digest = _of_short(path, NO_DIGEST)
    with path.open("r+b") as file:
        file.seek(_start_of_metadata(path) + _end(path).index(NO_DIGEST))
        file.write(digest)


def _of_short(path: Path, recorded: bytes) -> bytes:
    """Digest of a file with `NO_DIGEST` in place of the recorded one."""
    digest = _sha256(path, 0, _start_of_metadata(path))
    digest.update(_end(path).replace(recorded, NO_DIGEST))
    return digest.hexdigest().encode()


def _sha256(path: Path, begin: int, end: int) -> Any:
    """Digest of the bytes between two places in a file."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        file.seek(begin)
        while begin < end and (data := file.read(min(end - begin, _CHUNK))):
            digest.update(data)
            begin += len(data)
    return digest


def _start_of_metadata(path: Path) -> int:
    """Where the metadata of a file begin: they are its end."""
    with path.open("rb") as file:
        before = file.seek(-footers.TAIL, os.SEEK_END)
        return before + footers.start(file.read())


def _end(path: Path) -> bytes:
    """Read the metadata of a file and what is behind them."""
    with path.open("rb") as file:
        file.seek(_start_of_metadata(path))
        return file.read()
