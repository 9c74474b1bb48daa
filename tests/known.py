"""Whole results beside the ones that are known, in files of YAML that one can read and review.

What is right is tested elsewhere, against closed forms and other methods. Here a sign, a factor, an
index or a word that has changed is seen wherever it is.
"""

import fcntl
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from decimal import Decimal
from enum import Enum
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from vibrissa.errors import VibrissaError

# How far numbers side by side may be from the known ones: a part of the largest of them, and what
# is nothing but rounding.
WITHIN, FLOOR = 1e-7, 1e-11
# What one sees of a failure; the rest is counted.
SHOWN = 12
# Numbers in a sentence.
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?!\w)")
# The same parser in C takes a tenth of the time.
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
ROOT = Path(__file__).parents[1]


def plain(value: Any) -> Any:
    """A result as mappings, lists, numbers and texts; what stands side by side is one text."""
    if is_dataclass(value):
        value = {one.name: getattr(value, one.name) for one in fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, Enum):
        return plain(value.value)
    if isinstance(value, Real | Decimal):
        number = float(written(value))
        return int(number) if number.is_integer() and abs(number) < 1e12 else number
    if isinstance(value, list | tuple):
        return side_by_side(value)
    text = "" if value is None else str(value)
    return None if value is None else text.splitlines() if "\n" in text else text


def side_by_side(values: list[Any] | tuple[Any, ...]) -> Any:
    """Numbers, or short words, as one text; a single one by itself; other things as a list."""
    if values and all(isinstance(one, Real | Decimal) for one in values):
        return " ".join(map(written, values)) if len(values) > 1 else plain(values[0])
    if values and all(one is None or (isinstance(one, str) and len(one) < 20) for one in values):
        return " | ".join("none" if one is None else str(one) for one in values)
    return [plain(one) for one in values]


def written(value: Real | Decimal) -> str:
    """A number to twelve digits; zero has no sign."""
    return f"{float(value) + 0.0:.12g}"


def numbers(value: Any) -> np.ndarray | None:
    """The numbers of a plain result, if it is one number or several side by side."""
    if isinstance(value, int | float):
        return np.array([value], dtype=float)
    try:
        return np.array(value.split(), dtype=float) if " " in value else None
    except (AttributeError, TypeError, ValueError):
        return None


def short(value: Any) -> str:
    """A text, or the beginning of a long one."""
    text = repr(value)
    return text if len(text) < 300 else f"{text[:300]}…"


@dataclass(frozen=True)
class Bounds:
    """How far numbers may be from the known ones."""

    within: float = WITHIN
    floor: float = FLOOR
    told: bool = False

    def differences(self, found: Any, known: Any, where: str) -> Iterator[str]:
        """Say of each place where a result differs what was found there and what is known."""
        if isinstance(found, dict) and isinstance(known, dict):
            new = [key for key in found if key not in known]
            gone = [key for key in known if key not in found]
            if new or gone:
                yield f"{where}: {new} is new, {gone} is missing"
            elif list(found) != list(known):
                yield f"{where}: found in the order {list(found)}"
            for key in (key for key in known if key in found):
                yield from self.differences(found[key], known[key], f"{where}, {key}")
            return
        if isinstance(found, list) and isinstance(known, list):
            if len(found) != len(known):
                yield f"{where}: found {len(found)} rows, known {len(known)}"
                yield from (f"{where}: {short(one)} is new" for one in found if one not in known)
                yield from (
                    f"{where}: {short(one)} is missing" for one in known if one not in found
                )
                return
            for row, (one, other) in enumerate(zip(found, known, strict=True)):
                yield from self.differences(one, other, f"{where}, row {row}")
            return
        new, old = numbers(found), numbers(known)
        if new is None or old is None:
            if not self.alike(found, known):
                yield f"{where}: found {short(found)}, known {short(known)}"
        elif len(new) != len(old):
            yield f"{where}: found {len(new)} numbers, known {len(old)}: {short(found)}"
        else:
            size = np.abs(old[np.isfinite(old)]).max(initial=0.0)
            bound = self.within * size + self.floor
            same = np.isclose(new, old, rtol=0.0, atol=bound, equal_nan=True)
            for place in np.flatnonzero(~same):
                yield f"{where}, number {place}: found {new[place]:.12g}, known {old[place]:.12g}"

    def alike(self, found: Any, known: Any) -> bool:
        """Whether texts are the same, or what they tell is the same but for rounding."""
        if found == known or not (self.told and isinstance(found, str) and isinstance(known, str)):
            return found == known
        new, old = NUMBER.findall(found), NUMBER.findall(known)
        same = NUMBER.sub("#", found) == NUMBER.sub("#", known)
        return same and all(map(self.rounded_alike, new, old))

    def rounded_alike(self, found: str, known: str) -> bool:
        """Whether numbers are the same, or decimals but for one in the last place."""
        value = Decimal(known)
        last = Decimal(1).scaleb(int(value.as_tuple().exponent))
        bound = max(last, Decimal(self.within) * abs(value), Decimal(self.floor))
        whole = known.lstrip("+-").isdigit()
        return found == known or (not whole and abs(Decimal(found) - value) <= bound)


class Known:
    """What is known of the results of a test module, by name: in X.yaml beside test_X.py."""

    def __init__(self, module: str) -> None:
        self.module = Path(module)
        self.file = self.module.with_name(self.module.stem.removeprefix("test_") + ".yaml")

    @cached_property
    def known(self) -> dict[str, Any]:
        """All that is known, by name."""
        if not self.file.exists():
            return {}
        with self.file.open(encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_SH)
            return yaml.load(file, LOADER) or {}

    def check(
        self,
        name: str,
        result: Any,
        within: float = WITHIN,
        *,
        floor: float = FLOOR,
        told: bool = False,
    ) -> None:
        """Compare a result with the known one.

        Words are the same. Numbers side by side may differ by `floor`, which is rounding, and
        by a part of the largest of them, `within`: more than usual where an iteration ends with
        a remainder. In sentences that are `told` decimals may differ by one in their last place.
        """
        __tracebackhide__ = True
        found = plain(result)
        wrong = [f"{name}: nothing is known of it"]
        if name in self.known:
            wrong = list(Bounds(within, floor, told).differences(found, self.known[name], name))
        if wrong and os.environ.get("KNOWN") == "write":
            self.write(name, found)
        elif wrong:
            more = [f"and {len(wrong) - SHOWN} more places"] if len(wrong) > SHOWN else []
            file, module = (os.path.relpath(path, ROOT) for path in (self.file, self.module))
            advice = (
                f"If this was meant to change: KNOWN=write make test ARGS={module}; "
                f"then git diff {file}"
            )
            pytest.fail("\n".join([*wrong[:SHOWN], *more, advice]), pytrace=False)

    def write(self, name: str, found: Any) -> None:
        """Put a result into the file; other processes may do the same at the same time."""
        layout = {"allow_unicode": True, "sort_keys": False, "width": 2**20}
        with self.file.open("a+", encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            file.seek(0)
            known = yaml.load(file, LOADER) or {}
            file.truncate(0)
            yaml.dump(known | {name: found}, file, DUMPER, **layout)


def result_of(function, *arguments, **others):
    """What a function returns, or says of a mistake."""
    try:
        return function(*arguments, **others)
    except VibrissaError as error:
        return f"{type(error).__name__}: {error}"


def some_rows(columns, count=9):
    """Some rows of columns, and of all rows two means; or how often each word is there."""
    found = {}
    for name, values in columns.items():
        values = np.asarray(values)
        if values.dtype.kind in "US":
            words, counts = np.unique(values, return_counts=True)
            found[name] = dict(zip(words.tolist(), counts.tolist(), strict=True))
            continue
        rows = np.unique(np.linspace(0, len(values) - 1, count).astype(int))
        late = np.arange(len(values)) / len(values)
        means = [values.mean(axis=0), np.tensordot(late, values, axes=1) / len(values)]
        found[name] = np.stack([*values[rows], *means])
    return found
