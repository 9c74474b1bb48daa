"""Rows of the table of friction: a row for each recording and method of reading it."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa

from vibrissa.computing.columns import axis_columns, spell_point
from vibrissa.computing.surfaces import slip_model_of, surface_of
from vibrissa.outcomes import Contact, Method, RodSection
from vibrissa.quantities.units import Kind, Quantity
from vibrissa.readings.prediction import predicted_of
from vibrissa.readings.reading import (
    Bench,
    Reading,
    Stated,
    generator_of,
    read_once,
    setup_of,
)
from vibrissa.tables.rows import table_of
from vibrissa.tables.schemas import FRICTION


def read_chunk(
    readings: str,
    point: Mapping[str, Any],
    first: int,
    last: int,
    *,
    rod: Mapping[str, Any],
    methods: Sequence[str],
    errors: Mapping[str, Quantity] | None,
    tolerances: Mapping[str, Quantity],
    assume: bool,
    seed: int,
    to: Sequence[float] | None,
    cycles: int | None,
    study: str,
    contact: Contact,
    section: RodSection,
) -> Iterator[pa.Table]:
    """Simulate and read the recordings of a chunk, and yield the rows of each.

    The arguments are those of `vibrissa.study.readings.ReadingChunk`, and the study's own.
    """
    stated = Stated(
        rod={key: value for key, value in rod.items() if value is not None},
        tolerances=tolerances,
        assume=assume,
        contact=contact,
        section=section,
    )
    bench = Bench(
        setup=setup_of(point, stated),
        surface=surface_of(point),
        dx0=point["dx0"],
        to=to,
        cycles=cycles,
        model=slip_model_of(point),
        tip_radius=point.get("tip_radius", 0.0),
        errors=errors,
    )
    same = {
        "study": study,
        "readings": readings,
        **axis_columns(point),
        "transducer": point["transducer"],
        **{name: bench.setup.in_si(name) for name in ("modulus", "diameter", "length")},
        "predicted": predicted_of(point, stated),
    }
    chosen = [Method(method) for method in methods]
    for recording in range(first, last + 1):
        found = read_once(bench, chosen, generator_of(point, seed, recording))
        for method, reading in zip(chosen, found, strict=True):
            print(readings, spell_point(point), recording, method, reading.status, reading.message)
        length = bench.setup.whisker.units.unit(Kind.LENGTH)
        yield friction_table(same, recording, chosen, found, length)


def friction_table(
    same: Mapping[str, Any],
    recording: int,
    methods: Sequence[Method],
    found: Sequence[Reading],
    length: float,
) -> pa.Table:
    """Make the rows of one recording.

    Parameters
    ----------
    same : mapping
        Values that all recordings of the point have.
    length : float
        Length of the rod (m).
    """
    rows = [
        {
            **same,
            "recording": recording,
            "read_by": method,
            "way": reading.way * length,
            "limit_name": list(reading.limits or {}),
            "limit_share": list((reading.limits or {}).values()),
            "message": reading.message or None,
        }
        for method, reading in zip(methods, found, strict=True)
    ]
    columns = {
        field.name: [
            _known(row[field.name] if field.name in row else getattr(reading, field.name))
            for row, reading in zip(rows, found, strict=True)
        ]
        for field in FRICTION
    }
    return table_of(FRICTION, columns)


def _known(value: Any) -> Any:
    """Return None for a number that is not known."""
    return None if isinstance(value, float) and np.isnan(value) else value
