"""The data by which the paper's statements are judged, and what these data must contain."""

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from vibrissa.outcomes import Contact, RodSection
from vibrissa.study.axes import Values, spell_values
from vibrissa.study.figures import unknown_name
from vibrissa.study.sections import Mistakes, Section

# A copy of the paper's study that is changed in another way than the statements allow.
REMEDY = "or remove the key `claims`: a study needs none"


class Claims(Section):
    """The grids, the scan and the state by which the paper's statements are judged."""

    # The section that holds each, and the values of the axes that it must have.
    sources: ClassVar[dict[str, str]] = {
        "taper": "grid",
        "friction": "grid",
        "scan": "scan",
        "state": "state",
    }
    # The same in the whole paper: the data have no other values.
    setup: ClassVar[dict[str, Values]] = {"eta": (0.85,), "dx0": (0.001,)}
    needed: ClassVar[dict[str, dict[str, Values]]] = {
        "taper": {"theta": (1.0, 2.0, 3.0), "mu0": (0.2, 0.3, 0.4), **setup},
        "friction": {"theta": (2.0,), **setup},
        "scan": {"theta": (1.0, 2.0, 3.0), "mu0": (0.3, 0.4), **setup},
        "state": {"theta": (1.0,), "eta": (0.55,), "x1": (0.15,)},
    }

    taper: str = Field(description="name of the grid of the paper's Figure 6")
    friction: str = Field(description="name of the grid of the paper's Figure 7")
    scan: str = Field(description="name of the scan of the paper's Figures 3 to 5")
    state: str = Field(description="name of the state of the paper's Figure 8")

    def misfits(self, study: Any) -> Mistakes:
        """Find what does not fit the study, a `vibrissa.study.model.Study`."""
        mistakes = Mistakes()
        for key, needed in (("contact", Contact.POINT), ("section", RodSection.ROUND)):
            if getattr(study, key) is not needed:
                mistakes.add(f"the statements need {key}: {needed}; take that, {REMEDY}")
        for key, source in self.sources.items():
            name, sections = getattr(self, key), getattr(study, f"{source}s")
            if name in sections:
                self._check_data(mistakes, key, sections[name].axes)
            else:
                mistakes.add(f"{unknown_name(name, source, sections)}, {REMEDY}", key)
        return mistakes

    def _check_data(self, mistakes: Mistakes, key: str, axes: Mapping[str, Values]) -> None:
        """Find axes without the values that the statements need."""
        for axis, needed in self.needed[key].items():
            only = axis in self.setup
            if set(needed) - set(axes[axis]) or (only and len(axes[axis]) > 1):
                mistakes.add(
                    f"{getattr(self, key)!r} has {axis} = {spell_values(axes[axis])}, and the "
                    f"paper's statements need {'only ' * only}{spell_values(needed)}; change that, "
                    f"{REMEDY}",
                    key,
                )
