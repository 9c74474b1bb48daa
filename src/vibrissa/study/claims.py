"""The data that the paper's statements are judged by, and what these data have to be about."""

from collections.abc import Iterator, Mapping
from decimal import Decimal
from typing import ClassVar

from pydantic import Field

from vibrissa.study.mistakes import Mistake, spell_axis, unknown_name
from vibrissa.study.values import Points, Section

Values = dict[str, tuple[Decimal, ...]]


def _values(**axes: str) -> Values:
    return {axis: tuple(map(Decimal, texts.split())) for axis, texts in axes.items()}


class Claims(Section):
    """The grids, the scan and the state by which the paper's statements are judged.

    Attributes
    ----------
    sources : dict
        What each key is the name of.
    needed : dict
        Values of the axes that the data of each key need to have.
    setup : dict
        Values of the axes that are the same in the whole paper: the data have no others.
    """

    sources: ClassVar[dict[str, str]] = {
        "taper": "grid",
        "friction": "grid",
        "scan": "scan",
        "state": "state",
    }
    setup: ClassVar[Values] = _values(eta="0.85", dx0="0.001")
    needed: ClassVar[dict[str, Values]] = {
        "taper": _values(theta="1 2 3", mu0="0.2 0.3 0.4") | setup,
        "friction": _values(theta="2") | setup,
        "scan": _values(theta="1 2 3", mu0="0.3 0.4") | setup,
        "state": _values(theta="1", eta="0.55", x1="0.15"),
    }

    taper: str = Field(description="name of the grid of the paper's Figure 6")
    friction: str = Field(description="name of the grid of the paper's Figure 7")
    scan: str = Field(description="name of the scan of the paper's Figures 3 to 5")
    state: str = Field(description="name of the state of the paper's Figure 8")

    def mistakes(self, named: Mapping[str, Mapping[str, Points]]) -> Iterator[Mistake]:
        """Find names that nothing has, and data that are not about what the statements are about.

        Parameters
        ----------
        named : mapping
            Sections by name, for each of the `sources`.

        Yields
        ------
        Mistake
        """
        for key, source in self.sources.items():
            name, sections = getattr(self, key), named[source]
            if name not in sections:
                yield unknown_name(("claims", key), name, source, sections)
                continue
            for axis, needed in self.needed[key].items():
                values, only = sections[name].axes[axis], axis in self.setup
                if set(needed) - set(values) or (only and len(values) > 1):
                    text = (
                        f"{name!r} has {axis} = {spell_axis(values)}; the paper's statements are "
                        f"about {'only ' * only}{spell_axis(needed)}"
                    )
                    yield Mistake(location=("claims", key), text=text)
