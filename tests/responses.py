"""Responses of rods without units."""

from functools import lru_cache

from vibrissa.mechanics.mounting import IDEAL
from vibrissa.outcomes import Contact, RodSection
from vibrissa.scanning.slip_model import SlipModel
from vibrissa.sensor import Whisker


@lru_cache(64)
def respond(theta, eta, contact="point", mounting=IDEAL, section="round"):
    kinds = {"contact": Contact(contact), "section": RodSection(section)}
    return Whisker(theta=theta, eta=eta, mounting=mounting, **kinds).response


def by_law(law, ratio=0.8, zeta=0.1):
    """Model of a slip law; the law damped alone has a damping ratio."""
    return SlipModel.of(law, ratio, zeta if law == "damped" else None)
