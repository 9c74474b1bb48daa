"""A whisker: a rod clamped below a surface, in units of its own or of a real rod."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from vibrissa.errors import NoResponseError
from vibrissa.mechanics.rod import Rod
from vibrissa.outcomes import Contact
from vibrissa.sensor.heights import Heights, respond_between
from vibrissa.sensor.quantities import Kind, Quantity, Units, chosen, read_rod
from vibrissa.sensor.response import Response, respond

# Told what is being done, how much of it is done, and how much there is to do.
Progress = Callable[[str, int, int], None]


def quiet(what: str, done: int, total: int) -> None:
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class Whisker:
    """A rod, the height of the surface above its clamp, and how it may touch the surface.

    Its response is solved when it is first used, once.

    Attributes
    ----------
    theta : float
        Taper factor, at least 1.
    eta : float
        Height, 0 < eta < 1 (L).
    contact : Contact
        ``point``: the tip alone touches; ``line``: the rod may lie flat along the surface.
    rod : Rod or None
        The real rod; without it everything is nondimensional.
    """

    theta: float
    eta: float
    contact: Contact = Contact.POINT
    rod: Rod | None = None

    @classmethod
    def read(
        cls,
        theta: float,
        eta: Quantity,
        *,
        contact: Contact | str = Contact.POINT,
        modulus: str | None = None,
        diameter: str | None = None,
        length: str | None = None,
    ) -> "Whisker":
        """Read a whisker from quantities with units.

        Parameters
        ----------
        theta : float
            Taper factor, at least 1.
        eta : str or number
            Height: ``"85 mm"``, or 0.85 in units of the length.
        contact : Contact
        modulus, diameter, length : str, optional
            Of the rod: ``"210 GPa"``, ``"1 mm"``, ``"100 mm"``; all three or none.

        Returns
        -------
        Whisker

        Raises
        ------
        ArgumentError
            If an argument is no such quantity.
        """
        units = Units(read_rod(modulus, diameter, length))
        height = float(units.read(eta, Kind.LENGTH, "eta"))
        return cls(
            theta=theta, eta=height, contact=chosen(Contact, contact, "contact"), rod=units.rod
        )

    @property
    def units(self) -> Units:
        """Units of its results."""
        return Units(self.rod)

    @cached_property
    def pushed(self) -> Response:
        """Response where the clamp pushes the tip, x0 ≥ 0."""
        return respond(self.theta, self.eta, self.contact, pull=False)

    @cached_property
    def pulled(self) -> Response:
        """Response where the clamp pushes or pulls the tip."""
        return respond(self.theta, self.eta, self.contact, pull=True)

    def response(self, backward: bool) -> Response:
        """Give the response with x0 < 0 if it has been found: after a long slip the tip is pulled.

        Raises
        ------
        NoResponseError
            If it was not found although the clamp went backward, or there is no response at all.
        """
        try:
            return self.pulled
        except NoResponseError:
            if backward:
                raise
            return self.pushed

    def heights(self, backward: bool, progress: Callable[[int], None]) -> Heights:
        """Solve the response at heights near the given one, as `response` does at one height."""
        try:
            return respond_between(self.theta, self.eta, self.contact, True, progress)
        except NoResponseError:
            if backward:
                raise
            return respond_between(self.theta, self.eta, self.contact, False, progress)
