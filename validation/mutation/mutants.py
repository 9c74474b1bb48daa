"""All mutants of the package, a sample of them, and those that are known to change nothing."""

import random
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import yaml
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code

from validation.mutation.operators import OPERATORS, is_fault

EQUIVALENT = Path(__file__).with_name("equivalent.yaml")
BESIDE = "(beside the packages)"


@dataclass(frozen=True, kw_only=True, order=True)
class Mutant:
    """One fault: the operator's nth opportunity in a module, and the line where it is."""

    module: str
    line: int
    operator: str
    occurrence: int

    @property
    def package(self) -> str:
        first, slash, _ = self.module.partition("/")
        return first if slash else BESIDE

    def mutated(self, source: str) -> str:
        """Return the text of the module with the fault in it."""
        return mutate_code(source, OPERATORS[self.operator], self.occurrence)

    def change(self, source: str) -> tuple[str, str]:
        """Return the lines that the fault changes, and what they become."""
        old, new = source.splitlines(), self.mutated(source).splitlines()
        first = next((n for n, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), 0)
        while old and new and len(old) > first and old[-1] == new[-1]:
            old.pop(), new.pop()
        return tuple(
            "\n".join(" ".join(line.split()) for line in lines[first:]) for lines in (old, new)
        )


def mutants_of(module: str, source: str) -> list[Mutant]:
    """Return all mutants of a module."""
    tree = get_ast(source)
    nodes = list(ast_nodes(tree))
    found = []
    for name, operator in OPERATORS.items():
        places = ((node, place) for node in nodes for place in operator.mutation_positions(node))
        found += [
            Mutant(module=module, line=start[0], operator=name, occurrence=occurrence)
            for occurrence, (node, (start, _)) in enumerate(places)
            if is_fault(name, node)
        ]
    return found


def sample(
    mutants: Iterable[Mutant], sources: dict[str, str], size: int, seed: int, least: int
) -> list[Mutant]:
    """Draw mutants at random: from each package by its number of mutants, and some at least.

    The order is random, too, so that an interrupted run is a smaller sample.
    """
    chance = random.Random(seed)
    packages: dict[str, list[Mutant]] = defaultdict(list)
    for mutant in sorted(mutants):
        packages[mutant.package].append(mutant)
    total = sum(map(len, packages.values()))
    drawn: list[Mutant] = []
    for found in packages.values():
        chance.shuffle(found)
        python = (mutant for mutant in found if is_python(mutant.mutated(sources[mutant.module])))
        drawn += islice(python, max(least, round(size * len(found) / total)))
    chance.shuffle(drawn)
    return drawn


def is_python(text: str) -> bool:
    """Whether a text can be compiled: a few faults break the syntax, which is no test."""
    try:
        compile(text, "mutant", "exec")
    except SyntaxError:
        return False
    return True


@dataclass(frozen=True, kw_only=True)
class Equivalent:
    """A fault that nothing can notice: what it does to a line of a module, and why that is all."""

    module: str
    line: str
    becomes: str
    reason: str


def equivalents() -> dict[tuple[str, str, str], str]:
    """Return the reasons of the equivalent mutants, by module, line and what it becomes."""
    listed = [Equivalent(**entry) for entry in yaml.safe_load(EQUIVALENT.read_text("utf-8")) or []]
    return {(one.module, one.line, one.becomes): one.reason for one in listed}
