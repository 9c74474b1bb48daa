"""Blocks of curves: what one job solves, and which block holds which curve.

A *block* is a fixed set of curve keys, named by a hash of its contents. Which block holds which
curve is kept in a file, the plan, so that an extended study keeps its blocks. No rule that only
looks at the values of a grid can do that: cut every longer grid into the same blocks plus new ones
(unless each block is a single curve).
"""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from vibrissa.errors import ArgumentError, PlanError
from vibrissa.files import write_atomically
from vibrissa.study.codec import decode_key, encode_key
from vibrissa.study.grid import CurveKey, Grid

Blocks = dict[str, tuple[CurveKey, ...]]


def partition(keys: Sequence[CurveKey], size: int, known: Blocks) -> Blocks:
    """Distribute curves over blocks, keeping every block that exists.

    An extended grid adds blocks for what is new and leaves the rest as it is, wherever on an axis
    the new values lie: nothing is renamed and nothing solved twice.

    Parameters
    ----------
    keys : sequence of CurveKey
        Curves that are needed.
    size : int
        Largest number of curves in a new block.
    known : dict
        Blocks that exist, by name.

    Returns
    -------
    dict
        Blocks that hold at least one needed curve, known ones first.

    Raises
    ------
    ArgumentError
        If the size is not positive.
    """
    if size < 1:
        raise ArgumentError(f"a block holds at least one curve, got block_size {size}")
    wanted = set(keys)
    blocks = {name: members for name, members in known.items() if not wanted.isdisjoint(members)}
    wanted.difference_update(*blocks.values())
    new = [key for key in keys if key in wanted]
    for first in range(0, len(new), size):
        members = tuple(new[first : first + size])
        blocks[block_name(members)] = members
    return blocks


def block_name(members: Sequence[CurveKey]) -> str:
    """Name of a block: a hash of its curves, the same wherever and whenever it is made."""
    text = ";".join(",".join(encode_key(key)) for key in members)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def grids_of_block(members: Sequence[CurveKey], grids: Mapping[str, Grid]) -> dict[str, Grid]:
    """Parts of a study's grids that lie on the curves of a block.

    Parameters
    ----------
    members : sequence of CurveKey
    grids : mapping of Grid
        The study's grids by name.

    Returns
    -------
    dict of Grid
        Of the grids that have a point on a curve of the block, by name. Values of θ and η that the
        block has no curve for are left out, and so are steps where each curve has its own: a grid
        that grows elsewhere leaves the part as it is.
    """
    held = {name: {getattr(key, name) for key in members} for name in CurveKey._fields}
    parts = {}
    for name, grid in grids.items():
        axes = {
            axis: tuple(value for value in values if {None, value} & held.get(axis, {None}))
            for axis, values in vars(grid).items()
        }
        if all(axes.values()):
            parts[name] = Grid(**axes)
    return parts


def planned_blocks(
    path: Path,
    keys: Sequence[CurveKey],
    size: int,
    is_solved: Callable[[str], bool] = lambda name: True,
    remember: bool = True,
) -> Blocks:
    """Blocks for the given curves, extending the plan in a file where it lacks some.

    Parameters
    ----------
    path : Path
        The plan; it need not exist.
    keys : sequence of CurveKey
        Curves that are needed.
    size : int
        Largest number of curves in a new block.
    is_solved : callable, optional
        Tells by its name whether a block has been solved. One that has not is kept only if the
        study still needs it as it is: a mistaken grid leaves no traces.
    remember : bool, optional
        Whether to write the extended plan; not if nothing is to be done by it.

    Returns
    -------
    dict
        Blocks that hold at least one needed curve, by name.

    Raises
    ------
    PlanError
        If the file is damaged or cannot be written.
    """
    planned = _read(path)
    wanted = set(keys)
    known = {
        name: members
        for name, members in planned.items()
        if is_solved(name) or (len(members) <= size and wanted.issuperset(members))
    }
    blocks = partition(keys, size, known)
    if remember and known | blocks != planned:
        _write(path, known | blocks)
    return blocks


def _read(path: Path) -> Blocks:
    remedy = f"delete {path} and run again (blocks that fit the new plan are used again)"
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise PlanError(f"cannot read the plan of blocks: {error}") from None
    try:
        blocks = {
            name: tuple(decode_key(texts) for texts in members)
            for name, members in json.loads(data).items()
        }
    except (ValueError, AttributeError, TypeError):
        raise PlanError(f"the plan of blocks is damaged; {remedy}") from None
    if any(name != block_name(members) for name, members in blocks.items()):
        raise PlanError(f"the plan of blocks was changed; {remedy}")
    return blocks


def _write(path: Path, blocks: Blocks) -> None:
    lines = (
        f"{json.dumps(name)}: {json.dumps([encode_key(key) for key in members])}"
        for name, members in blocks.items()
    )
    text = "{\n" + ",\n".join(lines) + "\n}\n"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with write_atomically(path) as temporary:
            temporary.write_text(text)
    except OSError as error:
        raise PlanError(f"cannot write the plan of blocks: {error}") from None
