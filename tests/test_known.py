"""What is compared with the known: each kind of difference is seen, and said with its place."""

from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from known import Bounds, Known, plain
from vibrissa.outcomes import Contact


@dataclass(frozen=True)
class Thing:
    name: str
    values: np.ndarray


def test_a_result_is_plain():
    thing = Thing("a\nb", np.array([[1.0, -0.0], [np.nan, np.inf]]))
    assert plain([thing, Contact.LINE, None]) == [
        {"name": ["a", "b"], "values": ["1 0", "nan inf"]},
        "line",
        None,
    ]
    assert plain(("slip", None)) == "slip | none" and plain([]) == []
    assert plain({0.1: [True, 2]}) == {"0.1": "1 2"} and plain(np.array([2.5])) == 2.5
    assert [plain(one) for one in (np.float64(3), Decimal("0.5"), 1 / 3)] == [
        3,
        0.5,
        0.333333333333,
    ]


@pytest.mark.parametrize(
    ("found", "known", "said"),
    [
        ("1 2 3", "1 2 3.0000001", ""),
        ("1 2 3", "1 2 3.000001", "x, number 2: found 3, known 3.000001"),
        ("1 -2", "1 2", "x, number 1: found -2, known 2"),
        ("1 nan inf", "1 nan inf", ""),
        ("1 nan", "1 2", "x, number 1: found nan, known 2"),
        ("1e-13 2e-12", "0 0", ""),
        ("1 2", "1 2 3", "x: found 2 numbers, known 3: '1 2'"),
        (2.0, 2, ""),
        (2, 3, "x, number 0: found 2, known 3"),
        (2, "2", "x: found 2, known '2'"),
        (None, 2, "x: found None, known 2"),
        ("at 0.25 mm", "at 0.24 mm", "x: found 'at 0.25 mm', known 'at 0.24 mm'"),
        ({"a": 1, "b": 2}, {"a": 1}, "x: ['b'] is new, [] is missing"),
        (
            {"a": 1, "b": 2},
            {"b": 2, "a": 1},
            "x: found in the order ['a', 'b']",
        ),
        ({"a": ["p", "q"]}, {"a": ["p", "r"]}, "x, a, row 1: found 'q', known 'r'"),
        (["q"], ["p", "q"], "x: found 1 rows, known 2; x: 'p' is missing"),
        (["p", "q"], ["q"], "x: found 2 rows, known 1; x: 'p' is new"),
    ],
)
def test_a_difference_is_said_with_its_place(found, known, said):
    assert "; ".join(Bounds().differences(found, known, "x")) == said


@pytest.mark.parametrize(
    ("found", "known", "same"),
    [
        ("at 0.25 mm", "at 0.24 mm", True),
        ("at 0.25 mm", "at 0.23 mm", False),
        ("at 1.5e-7 of 3", "at 1.6e-7 of 3", True),
        ("at 0.2512345678", "at 0.2512345000", False),
        ("at 0.25123450000000001", "at 0.25123450000000", True),
        ("0.25123450000001", "0.25123450000000", True),
        ("-2e-15 N", "7e-14 N", True),
        ("row 3 of 8", "row 4 of 8", False),
        ("0.25 mm", "0.25 cm", False),
        ("0.25 mm", "0.25 and 0.3 mm", False),
    ],
)
def test_decimals_that_are_told_may_differ_in_their_last_place(found, known, same):
    assert Bounds(told=True).alike(found, known) == same


def test_a_result_that_was_meant_to_change_is_written(tmp_path, monkeypatch):
    module = str(tmp_path / "test_things.py")
    monkeypatch.delenv("KNOWN", raising=False)
    with pytest.raises(pytest.fail.Exception, match="one: nothing is known of it"):
        Known(module).check("one", [1.0, 2.0])
    monkeypatch.setenv("KNOWN", "write")
    for name, result in {"one": [1.0, 2.0], "two": "µ", "one ": range(0)}.items():
        Known(module).check(name, list(result))
    Known(module).check("one", [1.0, 2.0 + 1e-9])
    text = "one: 1 2\ntwo: µ\n'one ': []\n"
    assert Path(tmp_path, "things.yaml").read_text(encoding="utf-8") == text
    monkeypatch.setenv("KNOWN", "")
    Known(module).check("one", [1.0, 2.0])
    Known(module).check("one", [1.0, 2.1], within=0.06)
    with pytest.raises(pytest.fail.Exception) as caught:
        Known(module).check("one", [1.0] * 2)
    first, last = str(caught.value).splitlines()
    assert first == "one, number 1: found 1, known 2"
    assert "KNOWN=write make test ARGS=" in last and last.endswith("things.yaml")


def test_of_many_differences_the_first_are_said(tmp_path, monkeypatch):
    monkeypatch.setenv("KNOWN", "write")
    known = Known(str(tmp_path / "test_things.py"))
    known.check("many", np.zeros(40))
    monkeypatch.delenv("KNOWN")
    with pytest.raises(pytest.fail.Exception, match=r"number 11: found 1, .*\nand 28 more places"):
        Known(known.module).check("many", np.ones(40))
