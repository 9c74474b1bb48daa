"""Responses of rods without units."""

from vibrissa.mechanics.mounting import IDEAL
from vibrissa.outcomes import Contact, RodSection
from vibrissa.sensor import Whisker


def respond(theta, eta, contact="point", mounting=IDEAL, section="round"):
    kinds = {"contact": Contact(contact), "section": RodSection(section)}
    return Whisker(theta=theta, eta=eta, mounting=mounting, **kinds).response
