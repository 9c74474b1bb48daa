"""Whole results beside the ones that are known, in files of YAML that one can read and review."""

from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path

import numpy as np
import pytest
import yaml

# Of numbers of a result, relative to the largest beside them; less where they are next to nothing.
RELATIVE, ABSOLUTE = 1e-7, 1e-9


def plain(value):
    """A result as mappings, lists and words; numbers side by side are one line of text."""
    if is_dataclass(value):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, dict):
        return {str(name): plain(one) for name, one in value.items()}
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, str | None | Path):
        return None if value is None else str(value)
    if isinstance(value, list | tuple) and not all(isinstance(one, float | int) for one in value):
        if value and all(one is None or (isinstance(one, str) and len(one) < 20) for one in value):
            return " | ".join("none" if one is None else str(one) for one in value)
        return [plain(one) for one in value]
    array = np.asarray(value)
    if array.dtype.kind in "OU":
        return plain(array.tolist()) if array.ndim else str(value)
    if array.ndim > 1:
        return [plain(row) for row in array]
    digits = ".12g" if array.dtype.kind == "f" else ""
    # Zero has no sign, and a number by itself is one, too.
    return "numbers " + " ".join(format(one + 0, digits) for one in np.atleast_1d(array).tolist())


def assert_alike(found, known, relative=RELATIVE, where=""):
    """Compare two plain results: words and shapes are the same, numbers nearly."""
    if isinstance(found, str) and found.startswith("numbers "):
        assert isinstance(known, str) and known.startswith("numbers "), where
        new, old = (np.array(text.split()[1:]) for text in (found, known))
        assert new.shape == old.shape, f"{where}: {found} instead of {known}"
        if set(found) <= set("numbers TrueFals"):
            assert list(new) == list(old), where
            return
        new, old = new.astype(float), old.astype(float)
        size = np.abs(old[np.isfinite(old)]).max(initial=0.0)
        wanted = pytest.approx(old, rel=0.0, abs=ABSOLUTE + relative * size, nan_ok=True)
        assert new == wanted, f"{where}: {found} instead of {known}"
    elif isinstance(found, dict) and isinstance(known, dict):
        assert list(found) == list(known), where
        for name, one in found.items():
            assert_alike(one, known[name], relative, f"{where} {name}")
    elif isinstance(found, list) and isinstance(known, list):
        assert len(found) == len(known), where
        for place, (one, other) in enumerate(zip(found, known, strict=True)):
            assert_alike(one, other, relative, f"{where} {place}")
    else:
        assert found == known, where


class Known:
    """Known results in a file, by their names."""

    def __init__(self, file):
        self.file = Path(file)
        self.known = yaml.safe_load(self.file.read_text("utf-8")) if self.file.exists() else {}
        self.new = dict(self.known)

    def compare(self, name, result, folder, relative=RELATIVE):
        """Compare a result with the known one; of another one all are written into a folder."""
        found = self.new[name] = plain(result)
        try:
            assert name in self.known
            assert_alike(found, self.known[name], relative)
        except AssertionError:
            path = folder / self.file.name
            path.write_text(
                yaml.safe_dump(self.new, allow_unicode=True, sort_keys=False, width=1000), "utf-8"
            )
            print(f"If this was meant to change: review {path}, and copy it over {self.file}.")
            raise
