"""Arrow arrays from columns: those that pyarrow makes, without pandas."""

import numpy as np
import pyarrow as pa
import pytest

from vibrissa.tables.rows import array
from vibrissa.tables.schemas import FLAG, NUMBER, NUMBERS, TEXT, TEXTS, WHOLE


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ([1.0, None, 2], NUMBER),
        ([1, None, 3], WHOLE),
        ([True, None, False] * 6, FLAG),
        (["μ0 = 1", None, "", "slip"], TEXT),
        ([[1.0, np.inf], None, [], np.array([3.0])], NUMBERS),
        ([["theta", ""], None, []], TEXTS),
        *(([], kind) for kind in (NUMBER, WHOLE, FLAG, TEXT, NUMBERS, TEXTS)),
        (np.array([1, 2]), WHOLE),
        (np.array([True, False]), FLAG),
        (np.array(["a", "bc"]), TEXT),
        (np.array([None, "bc"], dtype=object), TEXT),
    ],
)
def test_an_array_is_that_of_pyarrow(values, kind):
    made = array(values, kind)
    made.validate(full=True)
    assert made.equals(pa.array(list(values), kind)) and made.type == kind


@pytest.mark.parametrize("kind", [NUMBER, WHOLE])
def test_nan_becomes_null(kind):
    assert array(np.array([1.0, np.nan, 3.0]), kind).to_pylist() == [1, None, 3]


def test_a_part_of_a_number_is_not_lost():
    with pytest.raises(ValueError, match="whole numbers has other values"):
        array([1, 2.5], WHOLE)


def test_an_unknown_type_is_refused():
    with pytest.raises(TypeError, match="no column has the type date32"):
        array([1], pa.date32())
