"""Blocks of curves: what one job solves, and which block holds which curve.

A *block* is a box of curves (`vibrissa.study.boxes`): some values of each axis, and all their
combinations. It is named by a hash of its contents. Which blocks there are is kept in a file, the
plan, so that an extended study keeps its blocks. No rule that only looks at the values of a grid
can do that: cut every longer grid into the same blocks plus new ones (unless each block is a single
curve). No curve is named by itself, so that a plan of millions of curves is small.
"""

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from vibrissa.errors import ArgumentError, PlanError
from vibrissa.files import write_atomically
from vibrissa.study.boxes import Box, cut, holds, joined, meets, remaining, size
from vibrissa.study.codec import Gap, decode_box, encode_box
from vibrissa.study.grid import Grid, Refinement

Blocks = dict[str, Box]


def partition(curves: Sequence[Box], most: int, known: Mapping[str, Box]) -> Blocks:
    """Distribute curves over blocks, keeping every block that exists.

    An extended grid adds blocks for what is new and leaves the rest as it is, wherever on an axis
    the new values lie: nothing is renamed and nothing solved twice.

    Parameters
    ----------
    curves : sequence of Box
        Curves that are needed, in boxes that have none in common.
    most : int
        Largest number of curves in a new block.
    known : mapping of Box
        Blocks that exist, by name.

    Returns
    -------
    dict of Box
        Blocks that hold at least one needed curve, known ones first.

    Raises
    ------
    ArgumentError
        If the size is not positive.
    """
    if most < 1:
        raise ArgumentError(f"a block holds at least one curve, got block_size {most}")
    needed = list(map(meets, curves))
    blocks = {
        name: block for name, block in known.items() if any(meets_it(block) for meets_it in needed)
    }
    held = joined(list(blocks.values()), "eta")
    for box in remaining(curves, held):
        blocks |= {block_name(part): part for part in cut(box, most)}
    return blocks


def block_name(block: Box) -> str:
    """Name of a block: a hash of its axes, the same wherever and whenever it is made."""
    axes = encode_box(block).items()
    text = ";".join(f"{axis}={','.join(values)}" for axis, values in axes)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def grids_of_blocks(grids: Mapping[str, Grid]) -> Callable[[Box], dict[str, Grid]]:
    """Return what tells the parts of a study's grids that lie on the curves of a block.

    Parameters
    ----------
    grids : mapping of Grid
        The study's grids by name.

    Returns
    -------
    callable
        Of the grids that have a point on a curve of the block it returns the parts, by name. Values
        of θ and η that the block has no curve for are left out, and so are steps where each curve
        has its own: a grid that grows elsewhere leaves the part as it is.
    """
    held = {
        name: {axis: frozenset(values) for axis, values in vars(grid).items()}
        for name, grid in grids.items()
    }

    def parts(block: Box) -> dict[str, Grid]:
        found = {}
        for name, grid in grids.items():
            # A block has few values of a long axis.
            axes = vars(grid) | {
                axis: tuple(value for value in values if value in held[name][axis])
                for axis, values in block.items()
                if values != (None,)
            }
            if all(axes.values()):
                found[name] = Grid(**axes)
        return found

    return parts


def gaps_of_block(
    block: Box, grids: Mapping[str, Grid], refinements: Mapping[str, Refinement]
) -> dict[str, dict[str, list[Gap]]]:
    """Gaps that begin at curves of a block, of grids to which curves are added.

    So each gap of a study belongs to one block, whichever its other end is in.

    Parameters
    ----------
    block : Box
    grids : mapping of Grid
        The study's grids by name.
    refinements : mapping of Refinement
        Of those to which points are added.

    Returns
    -------
    dict
        By grid and axis, in increasing order.
    """
    found: dict[str, dict[str, list[Gap]]] = {}
    refined = {name: one for name, one in refinements.items() if one.curve_axes}
    for name, part in grids_of_blocks({name: grids[name] for name in refined})(block).items():
        for axis in refined[name].curve_axes:
            following = dict(pairwise(getattr(grids[name], axis)))
            begun = [(v, following[v]) for v in getattr(part, axis) if v in following]
            if begun:
                found.setdefault(name, {})[axis] = begun
    return found


def ends_of_gaps(
    block: Box, grids: Mapping[str, Grid], gaps: Mapping[str, Mapping[str, Sequence[Gap]]]
) -> list[Box]:
    """Curves at which the gaps end that begin in a block; see `gaps_of_block`."""
    parts = grids_of_blocks({name: grids[name] for name in gaps})(block)
    return [
        {**parts[name].curves(by_step=False), axis: tuple(stop for _, stop in some)}
        for name, of_axes in gaps.items()
        for axis, some in of_axes.items()
    ]


def planned_blocks(
    path: Path,
    curves: Sequence[Box],
    most: int,
    is_solved: Callable[[str], bool] = lambda name: True,
    remember: bool = True,
) -> Blocks:
    """Blocks for the given curves, extending the plan in a file where it lacks some.

    Parameters
    ----------
    path : Path
        The plan; it need not exist.
    curves : sequence of Box
        Curves that are needed, in boxes that have none in common.
    most : int
        Largest number of curves in a new block.
    is_solved : callable, optional
        Tells by its name whether a block has been solved. One that has not is kept only if the
        study still needs it as it is: a mistaken grid leaves no traces.
    remember : bool, optional
        Whether to write the extended plan; not if nothing is to be done by it.

    Returns
    -------
    dict of Box
        Blocks that hold at least one needed curve, by name.

    Raises
    ------
    PlanError
        If the file is damaged or cannot be written.
    """
    planned = known_blocks(path)
    whole = list(map(holds, curves))

    def is_needed(block: Box) -> bool:
        # Most blocks lie in one box.
        return any(has(block) for has in whole) or not remaining([block], curves)

    known = {
        name: block
        for name, block in planned.items()
        if is_solved(name) or (size(block) <= most and is_needed(block))
    }
    blocks = partition(curves, most, known)
    if remember and known | blocks != planned:
        _write(path, known | blocks)
    return blocks


def known_blocks(path: Path) -> Blocks:
    """Read a plan; see `planned_blocks`."""
    remedy = f"delete {path} and run again (blocks that fit the new plan are used again)"
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise PlanError(f"cannot read the plan of blocks: {error}") from None
    try:
        blocks = {name: decode_box(axes) for name, axes in json.loads(data).items()}
    except (ValueError, AttributeError, TypeError, KeyError, ArithmeticError):
        raise PlanError(f"the plan of blocks is damaged; {remedy}") from None
    if any(name != block_name(block) for name, block in blocks.items()):
        raise PlanError(f"the plan of blocks was changed; {remedy}")
    return blocks


def _write(path: Path, blocks: Blocks) -> None:
    lines = (
        f"{json.dumps(name)}: {json.dumps(encode_box(block))}" for name, block in blocks.items()
    )
    text = "{\n" + ",\n".join(lines) + "\n}\n"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with write_atomically(path) as temporary:
            temporary.write_text(text)
    except OSError as error:
        raise PlanError(f"cannot write the plan of blocks: {error}") from None
