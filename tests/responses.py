"""Responses of rods without units."""

from vibrissa.mechanics.mounting import IDEAL
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sensor import Whisker


def respond(theta, eta, contact="point", mounting=IDEAL, section="round"):
    kinds = {"contact": Contact(contact), "section": RodSection(section)}
    return Whisker(theta=theta, eta=eta, mounting=mounting, **kinds).response


def by_law(law, zeta=0.1):
    """Options of a scan by a slip law; the law damped alone has a damping ratio."""
    return {"law": law, "damping": zeta} if law == "damped" else {"law": law}
