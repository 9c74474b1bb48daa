"""The data by which the paper's statements are judged, and what these data must contain."""

from typing import Any, ClassVar, Self

from pydantic import Field, ValidationInfo, model_validator

from vibrissa.outcomes import Contact
from vibrissa.study.axes import Mistake, Values, refuse, spell_values
from vibrissa.study.figures import unknown_name
from vibrissa.study.sections import Section

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

    @model_validator(mode="after")
    def _fits(self, info: ValidationInfo) -> Self:
        context: dict[str, Any] = info.context or {}
        mistakes: list[Mistake] = []
        if context.get("contact", Contact.POINT) is not Contact.POINT:
            mistakes.append(((), f"the paper has contact: point; take that, {REMEDY}"))
        for key, source in self.sources.items():
            name, sections = getattr(self, key), context.get(f"{source}s")
            if sections is None:  # it has mistakes of its own
                continue
            if name not in sections:
                text = f"{unknown_name(name, source, sections)}, {REMEDY}"
                mistakes.append(((key,), text))
                continue
            for axis, needed in self.needed[key].items():
                values, only = sections[name].axes[axis], axis in self.setup
                if set(needed) - set(values) or (only and len(values) > 1):
                    text = (
                        f"{name!r} has {axis} = {spell_values(values)}, and the paper's statements "
                        f"need {'only ' * only}{spell_values(needed)}; change that, {REMEDY}"
                    )
                    mistakes.append(((key,), text))
        if mistakes:
            refuse(mistakes)
        return self
