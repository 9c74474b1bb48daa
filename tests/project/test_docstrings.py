"""Docstrings: their examples are true, and those of public names say what they must."""

import doctest
import re
from dataclasses import fields, is_dataclass
from importlib import import_module
from inspect import getdoc
from pathlib import Path

import pytest
from numpydoc.validate import validate

SRC = Path(__file__).parents[2] / "src"
MODULES = {
    ".".join(path.relative_to(SRC).with_suffix("").parts): path
    for path in sorted(SRC.glob("vibrissa/**/*.py"))
    if path.stem != "__init__"
}
WITH_EXAMPLES = [name for name, path in MODULES.items() if ">>> " in path.read_text()]
PUBLIC = {
    f"{thing.__module__}.{name}": thing
    for package in ("vibrissa", "vibrissa.sensor", "vibrissa.design")
    for name in import_module(package).__all__
    if callable(thing := getattr(import_module(package), name))
}
# No docstring; no summary, or one that is indented, without a period or of several lines.
OF_ALL = {"GL08", "SS01", "SS03", "SS04", "SS06"}
# Arguments that are missing, unknown, in another order, or without a type.
OF_FUNCTIONS = OF_ALL | {"PR01", "PR02", "PR03", "PR04"}


@pytest.mark.slow
@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_examples_are_true(module):
    # An ellipsis stands for digits that depend on the machine.
    result = doctest.testmod(import_module(module), optionflags=doctest.ELLIPSIS)
    assert result.attempted and not result.failed


@pytest.mark.parametrize("name", PUBLIC)
def test_public_names_are_described(name):
    refused = OF_ALL if isinstance(PUBLIC[name], type) else OF_FUNCTIONS
    problems = [f"{code}: {what}" for code, what in validate(name)["errors"] if code in refused]
    assert problems == []


@pytest.mark.parametrize("name", [name for name in PUBLIC if is_dataclass(PUBLIC[name])])
def test_attributes_of_public_classes_are_described(name):
    # What a class inherits is described where it comes from.
    text = "\n".join(getdoc(one) or "" for one in PUBLIC[name].__mro__)
    for field in fields(PUBLIC[name]):
        assert field.name.startswith("_") or re.search(rf"\b{field.name}\b.* : ", text), field.name
