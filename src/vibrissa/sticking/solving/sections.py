"""Segments are cut where the contact changes its kind: they are smooth only between."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibrissa.numerics.arrays import FloatArray
from vibrissa.outcomes import Contact, Parameter, RodSection
from vibrissa.sticking.solving.cuts import switches_between
from vibrissa.sticking.solving.finishing import Resolved
from vibrissa.sticking.solving.paths import Pieces
from vibrissa.sticking.solving.segments import Segment


class Section(NamedTuple):
    """Part of a segment between two changes of the contact: first and last value, and its kind."""

    start: float
    stop: float
    line: bool


# None where the sections of a branch are not known.
Sections = list[Section] | None


def sections_of(segment: Segment, start: FloatArray, stop: FloatArray) -> list[Sections]:
    """Cut segments where the contact changes its kind.

    Parameters
    ----------
    segment : Segment
        Of n branches.
    start, stop : ndarray, shape (n,)
        Values of its parameter between which each is cut.

    Returns
    -------
    list of list of Section, or None, length n
        None where a change could not be located, or the branch has too few steps.
    """
    inner: list[list[float] | None] = [[] for _ in start]
    last = segment.last
    for k in range(len(segment.steps) - 1):
        changing = np.flatnonzero((segment.line[k] != segment.line[k + 1]) & (k < last))
        if not len(changing):
            continue
        switches = switches_between(segment, k, changing)
        for curve, at in zip(changing.tolist(), switches, strict=True):
            known = inner[curve]
            # Segments are followed on fewer nodes than the switches are solved on.
            place = (at - segment.origin[curve]) / segment.step[curve]
            if known is not None:
                inner[curve] = [*known, float(at)] if k - 0.1 <= place <= k + 1.1 else None
    sections: list[Sections] = []
    for curve, values in enumerate(inner):
        low, high = float(start[curve]), float(stop[curve])
        if values is None or not np.isfinite([low, high]).all() or last[curve] < 2:
            sections.append(None)
            continue
        # A pulled rod is followed downwards.
        bounds = [low, *sorted(min(max(value, low), high) for value in values), high]
        first = bool(segment.line[0 if segment.step[curve] > 0.0 else last[curve], curve])
        parts = [Section(a, b, first ^ bool(i % 2)) for i, (a, b) in enumerate(pairwise(bounds))]
        sections.append([part for part in parts if part.start < part.stop])
    return sections


def pieces_of(
    contact: Contact, segment: Segment, sections: Sequence[Sections], section: RodSection
) -> Pieces:
    """Pieces of a segment that have one kind of contact.

    Parameters
    ----------
    contact : Contact
    segment : Segment
        Of n branches.
    sections : sequence of list of Section, or None, length n
    section : RodSection

    Returns
    -------
    Pieces
    """
    found = [
        (curve, part)
        for curve, parts in enumerate(sections)
        for part in parts or ()
        if part.line == (contact is Contact.LINE)
    ]
    curves = np.array([curve for curve, _ in found], dtype=np.int64)
    start = np.array([part.start for _, part in found], dtype=float)
    return Pieces(
        **segment.branches.take(curves).columns,
        contact=contact,
        parameter=segment.parameter,
        curve=curves,
        start=start,
        length=np.array([part.stop for _, part in found], dtype=float) - start,
        section=section,
    )


def in_order(
    parameter: Parameter, sections: Sections, solved: Sequence[Resolved]
) -> list[Resolved]:
    """Order the resolved pieces of a segment; none if they do not cover it.

    Parameters
    ----------
    parameter : Parameter
        That of the segment.
    sections : list of Section or None
    solved : sequence of Resolved
        Pieces of one branch.

    Returns
    -------
    list of Resolved
    """
    parts = [part for part in solved if part.piece.parameter is parameter]
    length = sum(section.stop - section.start for section in sections or ())
    covered = sum(part.piece.stop - part.piece.start for part in parts)
    if covered <= length * (1.0 - 1e-9):
        return []
    return sorted(parts, key=lambda part: part.piece.start)
