"""Whole results as they were: each number of a result is compared with the one that is kept.

What the numbers should be is tested elsewhere, against closed forms and other methods. Here a sign,
a factor or an index is seen wherever it is.
"""

from dataclasses import fields, is_dataclass
from decimal import Decimal
from math import inf, isfinite
from numbers import Real
from pathlib import Path

import numpy as np
import pytest
import yaml

from vibrissa.errors import VibrissaError

# Of the largest number of an array.
WITHIN = 1e-7
DIGITS = 11
# Rounding of what would be zero.
FLOOR = 1e-11


def plain(value):
    """Return a result as lists, dictionaries, numbers and words."""
    if is_dataclass(value):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, Real | Decimal):
        return float(f"{float(value):.{DIGITS}g}")
    return None if value is None else str(value)


def result_of(function, *arguments, **others):
    """What a function returns, or says of a mistake."""
    try:
        return plain(function(*arguments, **others))
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


class Kept:
    """Results in a YAML file, by name."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.known = yaml.safe_load(path.read_text(encoding="utf-8")) if path.exists() else {}

    def check(self, name, result, within=WITHIN):
        """Compare a result with the one that is kept, and show the new one if it is another."""
        found = plain(result)
        print(f"If this was meant to change: review it and put it into {self.path}:")
        print(yaml.safe_dump({name: found}, allow_unicode=True, sort_keys=False, width=1000))
        assert name in self.known
        compare(found, self.known[name], name, within)


def compare(found, known, where, within):
    """Compare two results; numbers of one list have one size."""
    if isinstance(known, dict):
        assert list(found) == list(known), where
        for key, one in known.items():
            compare(found[key], one, f"{where}, {key}", within)
    elif isinstance(known, list) and known:
        assert len(found) == len(known), where
        numbers = [isinstance(one, float) for one in known]
        if all(numbers):
            size = max((abs(one) for one in known if isfinite(one)), default=0.0)
            assert found == pytest.approx(known, rel=0.0, abs=within * size + FLOOR, nan_ok=True), (
                where
            )
        else:
            for number, (one, other) in enumerate(zip(found, known, strict=True)):
                compare(one, other, f"{where}, {number}", within)
    elif isinstance(known, float) and abs(known) < inf:
        assert found == pytest.approx(known, rel=within, abs=FLOOR), where
    else:
        assert found == known or (found != found and known != known), where
