"""The faults: operators of Cosmic Ray that make plausible mistakes, and some more of their kind."""

from ast import literal_eval
from collections.abc import Iterator
from itertools import pairwise

import parso
from cosmic_ray.operators.operator import Example, Operator
from cosmic_ray.operators.provider import OperatorProvider
from parso.tree import NodeOrLeaf

Span = tuple[tuple[int, int], tuple[int, int]]

# Cosmic Ray also puts << in the place of +. Nobody writes that by mistake, and any test notices.
CHOSEN = (
    *(
        f"ReplaceComparisonOperator_{old}_{new}"
        for old, news in {
            "Lt": ("LtE", "Gt"),
            "LtE": ("Lt", "GtE"),
            "Gt": ("GtE", "Lt"),
            "GtE": ("Gt", "LtE"),
            "Eq": ("NotEq",),
            "NotEq": ("Eq",),
            "Is": ("IsNot",),
            "IsNot": ("Is",),
        }.items()
        for new in news
    ),
    "ReplaceBinaryOperator_Add_Sub",
    "ReplaceBinaryOperator_Sub_Add",
    "ReplaceBinaryOperator_Mul_Div",
    "ReplaceBinaryOperator_Div_Mul",
    "ReplaceBinaryOperator_FloorDiv_Div",
    "ReplaceBinaryOperator_Pow_Mul",
    "ReplaceBinaryOperator_BitAnd_BitOr",
    "ReplaceBinaryOperator_BitOr_BitAnd",
    "ReplaceUnaryOperator_Delete_Not",
    "ReplaceUnaryOperator_Delete_USub",
    "ReplaceUnaryOperator_Delete_Invert",
    "AddNot",
    "ReplaceTrueWithFalse",
    "ReplaceFalseWithTrue",
    "ReplaceAndWithOr",
    "ReplaceOrWithAnd",
    "ReplaceBreakWithContinue",
    "ReplaceContinueWithBreak",
    "NumberReplacer",
    "ZeroIterationForLoop",
)

# One more or less is no mistake that anybody makes, or notices, of a larger number.
LARGE = 1000
# Of numbers that are no sizes, as 0o755 and 0x7F.
PREFIXES = ("0b", "0o", "0x")
# Arguments that guard against mistakes of programmers; without one nothing runs differently.
GUARDS = frozenset({"strict", "frozen", "kw_only", "eq", "slots", "repr"})
# What tells a union of types from a union of sets or masks.
TYPES = frozenset("None str int float bool bytes Path Decimal FloatArray".split())


class DropCondition(Operator):
    """One of several conditions is left out: `a and b` becomes `a`, a mask `a & b` becomes `b`."""

    joined = frozenset({"and_test", "or_test", "and_expr", "expr"})

    def mutation_positions(self, node: NodeOrLeaf) -> Iterator[Span]:
        if node.type in self.joined:
            for operand in node.children[::2]:
                yield operand.start_pos, operand.end_pos

    def mutate(self, node: NodeOrLeaf, index: int) -> NodeOrLeaf:
        kept = [operand for n, operand in enumerate(node.children[::2]) if n != index]
        parts = [kept[0], *(part for operand in kept[1:] for part in (node.children[1], operand))]
        return replaced(node, "".join(part.get_code() for part in parts).strip())

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        return (Example("x and y", "y"), Example("x & y & z", "x & z", occurrence=1))


class DropCall(Operator):
    """A function that makes a value fit is left out: `abs(x)` becomes `x`."""

    names = frozenset(
        "abs sorted reversed round np.abs np.sqrt np.radians np.degrees np.unique np.sort"
        " np.deg2rad np.rad2deg np.tan np.sin np.cos np.arctan np.flip np.cumsum np.log".split()
    )

    def mutation_positions(self, node: NodeOrLeaf) -> Iterator[Span]:
        if node.type in ("power", "atom_expr") and self._argument(node):
            yield node.start_pos, node.end_pos

    def _argument(self, node: NodeOrLeaf) -> str | None:
        *function, call = node.children
        name = "".join(part.get_code(include_prefix=False) for part in function)
        if name in self.names and call.type == "trailer" and len(call.children) == 3:
            argument = call.children[1]
            if argument.type not in ("arglist", "argument"):
                return argument.get_code()
        return None

    def mutate(self, node: NodeOrLeaf, index: int) -> NodeOrLeaf:
        return replaced(node, f"({self._argument(node)})")

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        return (Example("y = abs(x)", "y = (x)"), Example("y = np.sqrt(x)", "y = (x)"))


class CatchNothing(Operator):
    """An exception is not caught. (Cosmic Ray's own does not know `except module.Error`.)"""

    def mutation_positions(self, node: NodeOrLeaf) -> Iterator[Span]:
        for name in self._names(node):
            yield name.start_pos, name.end_pos

    def _names(self, node: NodeOrLeaf) -> list[NodeOrLeaf]:
        if node.type != "except_clause":
            return []
        caught = node.children[1]
        if caught.type != "atom":
            return [caught]
        inner = caught.children[1]
        return inner.children[::2] if inner.type == "testlist_comp" else [inner]

    def mutate(self, node: NodeOrLeaf, index: int) -> NodeOrLeaf:
        name = self._names(node)[index]
        siblings = name.parent.children
        siblings[siblings.index(name)] = replaced(name, "GeneratorExit")
        return node

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        return (
            Example("try: x\nexcept A: pass", "try: x\nexcept GeneratorExit: pass"),
            Example("try: x\nexcept a.B as e: pass", "try: x\nexcept GeneratorExit as e: pass"),
            Example(
                "try: x\nexcept (A, b.C): pass",
                "try: x\nexcept (A, GeneratorExit): pass",
                occurrence=1,
            ),
        )


class SwapNeighbours(Operator):
    """Two names next to each other are swapped: arguments, items of a list, columns."""

    groups = frozenset({"arglist", "exprlist", "testlist", "testlist_comp", "testlist_star_expr"})
    # Functions and tests in which the order does not matter.
    unordered = frozenset(
        "in except isinstance min max np.minimum np.maximum np.hypot set frozenset".split()
    )

    def mutation_positions(self, node: NodeOrLeaf) -> Iterator[Span]:
        if node.type in self.groups:
            for one, other in self._pairs(node):
                yield one.start_pos, other.end_pos

    def _pairs(self, node: NodeOrLeaf) -> list[tuple[NodeOrLeaf, NodeOrLeaf]]:
        before = node.parent.get_previous_sibling()
        if before and before.get_code(include_prefix=False) in self.unordered:
            return []
        columns = node.type != "testlist_comp" or node.parent.parent.type == "trailer"
        return [
            (one, other)
            for one, other in pairwise(node.children[::2])
            if one.type == other.type and one.type in ("name", "string")
            if one.value != other.value
            # Not the classes of an isinstance, nor the words of a list.
            if (one.type == "name" and not one.value[0].isupper())
            or (one.type == "string" and columns)
        ]

    def mutate(self, node: NodeOrLeaf, index: int) -> NodeOrLeaf:
        one, other = self._pairs(node)[index]
        one.value, other.value = other.value, one.value
        return node

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        return (Example("f(x, y)", "f(y, x)"), Example("a, b = x", "b, a = x"))


def replaced(node: NodeOrLeaf, code: str) -> NodeOrLeaf:
    """Return other code with the white space that stood before a node."""
    return parso.parse(node.get_first_leaf().prefix + code)


def is_fault(name: str, node: NodeOrLeaf) -> bool:
    """Whether an operator makes a mistake of a node that can matter when the code runs."""
    if name == "NumberReplacer":
        return node.value[:2].lower() in PREFIXES or abs(literal_eval(node.value)) < LARGE
    argument = node.parent
    if argument is not None and argument.type == "argument":
        if argument.children[0].get_code(include_prefix=False) in GUARDS:
            return False
    return not _annotation(node)


def _annotation(node: NodeOrLeaf) -> bool:
    """Whether a node is a part of a type."""
    union = node if node.type == "expr" else node.parent
    if union is not None and union.type == "expr":
        if any(operand.get_code().strip() in TYPES for operand in union.children[::2]):
            return True
    while node.parent is not None:
        parent, place = node.parent, node.parent.children.index(node)
        if (parent.type, place) in (("annassign", 1), ("tfpdef", 2)):
            return True
        if parent.type == "funcdef" and parent.children[place - 1] == "->":
            return True
        node = parent
    return False


OPERATORS: dict[str, Operator] = {name: OperatorProvider()[name]() for name in CHOSEN} | {
    operator.__name__: operator()
    for operator in (DropCondition, DropCall, CatchNothing, SwapNeighbours)
}
