"""Stability out of the plane: whether a rod with a round section stays in its plane.

The contact holds the rod as a ball joint does: it takes no moment out of the plane. In line contact
that is so, too, as the tail lies unloaded on the surface and turns freely in its plane. A yielding
clamp yields as much out of the plane as in it, and not about its axis.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Self

import numpy as np

from vibrissa.mechanics.equations import bending_moment, ends
from vibrissa.mechanics.mounting import CLAMP_SLOPE, Mountings
from vibrissa.mechanics.states import RodStates
from vibrissa.numerics.arrays import BoolArray, FloatArray
from vibrissa.numerics.batch import Batch
from vibrissa.numerics.eigenvalues import smallest_eigenvalue
from vibrissa.numerics.spectral import gauss_rule

# Bending over torsional stiffness of a round section is 1 + POISSON_RATIO.
POISSON_RATIO = 0.3
# Part of everything in the vector that an eigenvector is sought from.
A_LITTLE = 0.03


def stability_aside(states: RodStates) -> FloatArray:
    """How far each equilibrium is from leaving its plane, with clamp and contact point held fixed.

    A planar equilibrium is a minimum of the energy among shapes in space if the second variation
    (D1) of docs/lateral.md is positive for every small rotation ω(s) about axes in the plane that
    keeps the contact point in the plane. At a rigid clamp ω(0) = 0. A yielding one turns out of the
    plane by q, which adds (sin γ/γ)·q²/c, where γ is its turn in the plane (D9).

    Parameters
    ----------
    states : RodStates

    Returns
    -------
    ndarray, shape (n,)
        Least second variation per elastic energy of ω: at most 1, positive where the rod stays in
        its plane, zero where it stops doing so.
    """
    known = np.flatnonzero(np.isfinite(states.phi).all(axis=1) & np.isfinite(states.fx))
    margin = np.full(len(states), np.nan)
    if len(known):
        variation = _Variation.of(states.take(known))
        margin[known] = 1.0 + smallest_eigenvalue(variation, variation.start())
    return margin


@dataclass(frozen=True, eq=False, kw_only=True)
class _Variation(Batch):
    """The part of (D1) that is not elastic energy, as a symmetric operator.

    It acts on the roots u of the elastic energy: Σ u² is that of torsion and bending. They are the
    twists at all nodes, then the bends, and last the turn of the clamp if it yields. The last axis
    of all columns counts the rods. In (D1)
    −(F·ω)(ω·t) + (F·t)·|ω|² is (F·t)·(ω·n)² − (F·n)·(ω·t)(ω·n), and −M·(ω×ω')_z is
    M·((ω·n)·(ω'·t) − (ω·t)·(ω'·n)).

    Attributes
    ----------
    cos, sin : ndarray, shape (nodes, n)
        Of the slope.
    twist, bend : ndarray, shape (nodes, n)
        ω'·t and ω'·n for u = 1, times the weights of the nodes.
    pull, shear : ndarray, shape (nodes, n)
        F·t and half of F·n, integrated.
    half_moment : ndarray, shape (nodes, n)
    length : ndarray, shape (nodes, n)
        Arc lengths that the nodes stand for.
    clamp : ndarray, shape (2, n), or None
        ω(0) for u = 1; None where the clamps are rigid.
    """

    cos: FloatArray
    sin: FloatArray
    twist: FloatArray
    bend: FloatArray
    pull: FloatArray
    shear: FloatArray
    half_moment: FloatArray
    length: FloatArray
    clamp: FloatArray | None

    @classmethod
    def of(cls, states: RodStates) -> "_Variation":
        rule = gauss_rule(states.nodes)
        density, compliance = states.densities(rule.nodes)
        phi = np.ascontiguousarray(states.phi.T)
        cos, sin = np.cos(phi), np.sin(phi)
        length = np.ascontiguousarray((rule.weights * density).T)
        root = np.ascontiguousarray(np.sqrt(rule.weights * compliance).T)
        return cls(
            cos=cos,
            sin=sin,
            twist=root * np.sqrt(1.0 + POISSON_RATIO),
            bend=root,
            pull=length * (states.fx * cos + states.fy * sin),
            shear=0.5 * length * (states.fy * cos - states.fx * sin),
            half_moment=0.5 * bending_moment(states).T,
            length=length,
            clamp=None if states.mounting is None else _clamp_turn(states.mounting, states),
        )

    @cached_property
    def held(self) -> FloatArray:
        """Direction of u that moves the contact point out of the plane (D2), shape (size, n)."""
        moved = self._transposed(np.zeros_like(self.length), self.length)
        return moved / np.linalg.norm(moved, axis=0)

    def chosen(self, which: BoolArray) -> Self:
        """Select rods."""
        return self.each(lambda values: values[..., which])

    def start(self) -> FloatArray:
        """Where an eigenvector is sought from: (D4), and a little of everything."""
        nodes, turn = len(self.cos), self.half_moment * self.bend
        start = np.full_like(self.held, A_LITTLE)
        start[nodes : 2 * nodes] += turn / np.linalg.norm(turn, axis=0)
        return start

    def image(self, u: FloatArray) -> FloatArray:
        """Apply the operator to vectors."""
        nodes, integral = len(self.cos), _integral(len(self.cos))
        twist, bend = self.twist * u[:nodes], self.bend * u[nodes : 2 * nodes]
        x = integral @ (self.cos * twist - self.sin * bend)
        y = integral @ (self.sin * twist + self.cos * bend)
        if self.clamp is not None:
            clamp_x, clamp_y = self.clamp
            x, y = x + clamp_x * u[-1], y + clamp_y * u[-1]
        along, across = self.cos * x + self.sin * y, self.cos * y - self.sin * x
        image = self._transposed(
            -self.half_moment * bend - self.shear * across,
            self.half_moment * twist + self.pull * across - self.shear * along,
        )
        image[:nodes] += self.twist * self.half_moment * across
        image[nodes : 2 * nodes] -= self.bend * self.half_moment * along
        return image

    def _transposed(self, along: FloatArray, across: FloatArray) -> FloatArray:
        """Apply the transpose of what maps u to the rotations along the rod and across it."""
        integral = _integral(len(self.cos)).T
        x, y = self.cos * along - self.sin * across, self.sin * along + self.cos * across
        of_x, of_y = integral @ x, integral @ y
        parts = [
            self.twist * (self.cos * of_x + self.sin * of_y),
            self.bend * (self.cos * of_y - self.sin * of_x),
        ]
        if self.clamp is not None:
            clamp_x, clamp_y = self.clamp
            parts.append((clamp_x * x + clamp_y * y).sum(axis=0, keepdims=True))
        return np.concatenate(parts)

    def free(self, u: FloatArray) -> FloatArray:
        """Leave out what moves the contact point."""
        u -= np.einsum("ij,ij->j", self.held, u) * self.held
        return u


@lru_cache
def _integral(nodes: int) -> FloatArray:
    """Matrix from values at the nodes, times their weights, to ∫₀^τ at the nodes."""
    rule = gauss_rule(nodes)
    return rule.from_start / rule.weights


def _clamp_turn(mounting: Mountings, states: RodStates) -> FloatArray:
    """Rotation ω(0) of a yielding clamp whose energy grows by 1/2, as (D9) has it."""
    axis = CLAMP_SLOPE + mounting.clamp_angle
    turn = mounting.clamp_compliance * ends(states).moment
    # np.sinc has π in it.
    across, along = np.sinc(turn / np.pi), 0.5 * turn * np.sinc(0.5 * turn / np.pi) ** 2
    q = np.sqrt(mounting.clamp_compliance / across)
    return np.array(
        [
            q * (-across * np.sin(axis) - along * np.cos(axis)),
            q * (across * np.cos(axis) - along * np.sin(axis)),
        ]
    )
