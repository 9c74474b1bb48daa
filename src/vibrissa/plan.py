"""Which block holds which curve: kept in a file, so that an extended study keeps its blocks.

No rule that only looks at the values of a grid can cut every longer grid into the same blocks plus
new ones (unless each block is a single curve), so the cut is remembered.
"""

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from vibrissa.files import write_atomically
from vibrissa.grid import Blocks, CurveKey, block_name, partition


class PlanError(RuntimeError):
    """A plan that cannot be read or written; the message says what to do."""


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
            name: tuple(tuple(str(value) for value in key) for key in members)
            for name, members in json.loads(data).items()
        }
    except (ValueError, AttributeError, TypeError):
        raise PlanError(f"the plan of blocks is damaged; {remedy}") from None
    if any(name != block_name(members) for name, members in blocks.items()):
        raise PlanError(f"the plan of blocks was changed; {remedy}")
    return blocks


def _write(path: Path, blocks: Blocks) -> None:
    lines = (f"{json.dumps(name)}: {json.dumps(members)}" for name, members in blocks.items())
    text = "{\n" + ",\n".join(lines) + "\n}\n"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with write_atomically(path) as temporary:
            temporary.write_text(text)
    except OSError as error:
        raise PlanError(f"cannot write the plan of blocks: {error}") from None
