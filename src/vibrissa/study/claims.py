"""The data by which the paper's statements are judged, and what these data must contain."""

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.study.axes import MOUNTING_AXES, Values, spell_values
from vibrissa.study.figures import unknown_name
from vibrissa.study.sections import Mistakes, Section

# Second remedy in messages: the study may be a copy of the paper's study that was changed.
REMEDY = "or remove the optional key `claims`"


class Claims(Section):
    """The grids, the scan and the state by which the paper's statements are judged."""

    setup: ClassVar[dict[str, Values]] = {
        **{"eta": (0.85,), "dx0": (0.001,)},
        **dict.fromkeys(MOUNTING_AXES, (0.0,)),
    }
    # If the paper has one value of an axis, further values are not allowed.
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
        """Find names and values that do not fit the study, a `vibrissa.study.model.Study`."""
        mistakes = Mistakes()
        solved = study.contact, study.section, study.method
        if solved != (Contact.POINT, RodSection.ROUND, Solver.COLLOCATION):
            mistakes.add(
                "the statements need `contact: point`, `section: round` and `method: collocation`: "
                f"set all, {REMEDY}"
            )
        for key, needed in self.needed.items():
            name, source = getattr(self, key), key if key in ("scan", "state") else "grid"
            data: Mapping[str, Any] = getattr(study, f"{source}s")
            if name not in data:
                mistakes.add(f"{unknown_name(name, source, data)}, {REMEDY}", key)
                continue
            if key == "scan" and data[name].cycles < 2:
                mistakes.add(f"{name!r} needs cycles: 2 or more; change it, {REMEDY}", key)
            if source == "grid" and not data[name].is_product:
                text = f"{name!r} does not have all combinations of its values"
                mistakes.add(f"{text}; name another grid, {REMEDY}", key)
                continue
            for axis, values in needed.items():
                found, alone = data[name].axes[axis], len(values) == 1
                # Other values may lie between those of the paper.
                ends = (found[0], found[-1]) == (values[0], values[-1])
                if set(values) - set(found) or not ends:
                    only = "alone" if alone else "and no smaller or larger value"
                    mistakes.add(
                        f"{name!r} has {axis} = {spell_values(found)}, but the paper's statements "
                        f"need {spell_values(values)} {only}; change {axis} of {name!r}, {REMEDY}",
                        key,
                    )
        return mistakes
