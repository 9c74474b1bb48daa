"""Boxes against sets of their members."""

from hypothesis import given
from hypothesis import strategies as st

from vibrissa.study import boxes

AXES = ("a", "b", "c")
axis = st.lists(st.integers(0, 4), min_size=1, max_size=4, unique=True).map(
    lambda values: tuple(sorted(values))
)
# In one order, other than of `fixed_dictionaries`.
box = st.tuples(axis, axis, axis).map(lambda values: dict(zip(AXES, values, strict=True)))


def all_of(some):
    """Members of some boxes, each as often as it is there."""
    return [member for one in some for member in boxes.members(one)]


@given(box, box)
def test_two_boxes(one, other):
    first, second = set(boxes.members(one)), set(boxes.members(other))
    assert boxes.size(one) == len(first)
    assert boxes.meets(one)(other) is bool(first & second)
    assert boxes.holds(one)(other) is (first >= second)
    assert set(boxes.members(boxes.common(one, other))) == first & second
    rest = all_of(boxes.without(one, other))
    assert sorted(rest) == sorted(first - second)


@given(st.lists(box, max_size=4), st.lists(box, max_size=3))
def test_many_boxes(some, others):
    every = all_of(boxes.disjoint(some))
    assert sorted(every) == sorted(set(all_of(some)))
    rest = set(all_of(boxes.remaining(some, others)))
    assert rest == set(all_of(some)) - set(all_of(others))


@given(st.lists(box, max_size=4), st.sampled_from(AXES))
def test_boxes_that_differ_along_an_axis_are_put_together(some, along):
    found = boxes.joined(some, along)
    assert set(all_of(found)) == set(all_of(some))
    others = [tuple(one[name] for name in AXES if name != along) for one in found]
    assert len(set(others)) == len(others)


@given(box, st.integers(1, 70))
def test_a_box_is_cut_in_the_order_of_its_members(one, most):
    parts = list(boxes.cut(one, most))
    assert all_of(parts) == list(boxes.members(one))
    assert max(map(boxes.size, parts)) <= most
    # No more parts than twice what a box of another shape would need, and one more for each row.
    assert len(parts) <= 2 * boxes.size(one) / most + len(one["a"]) * len(one["b"])
