"""A rod in space that shares no code with the package: rigid links, joined by springs.

Each joint turns by a rotation vector, with stiffnesses for its two bends and for its twist. The
first link is fixed in the clamp, or joined to it by a spring that bends but does not twist. The
contact point is held at a point of space, as by a ball joint. The energy is minimised under this
constraint, for bends and twists of any size.
"""

import numpy as np
from scipy.linalg import eigh, null_space
from scipy.optimize import minimize

POISSON_RATIO = 0.3
# Spring at the clamp: ratio of its torsional to its bending stiffness.
RIGID = 1e4
# Components of a rotation vector that leave the plane: the bend out of it, and the twist.
ASIDE = [0, 2]
# Tolerance for the position of the contact point (L), and largest number of rounds.
MISSED, MOST_ROUNDS = 1e-8, 100
# A round should reduce the error of this position to this share; if not, the penalty is raised.
NEARER = 0.5


def skew(v):
    """Return the matrices of the cross products with vectors, shape (n, 3, 3)."""
    zero = np.zeros(len(v))
    rows = [[zero, -v[:, 2], v[:, 1]], [v[:, 2], zero, -v[:, 0]], [-v[:, 1], v[:, 0], zero]]
    return np.moveaxis(np.array(rows), -1, 0)


def rotations(v):
    """Return the matrices of rotation vectors, and the body rotation per change of a vector."""
    angle = np.sqrt((v**2).sum(axis=1) + 1e-30)[:, None, None]
    cross = skew(v)
    square = cross @ cross
    first, second = np.sin(angle) / angle, (1 - np.cos(angle)) / angle**2
    third = (angle - np.sin(angle)) / angle**3
    third = np.where(angle < 1e-3, 1 / 6, third)
    eye = np.eye(3)
    return eye + first * cross + second * square, eye - second * cross + third * square


class Chain:
    """Chain of `count` links for a tapered rod, from the clamp to the contact point at `s_c`.

    With `tail`, further links follow up to s = 1. The first of these, whose middle is the contact
    point, lies in the plane of the surface, in any direction; the others are free. The clamp leans
    by `clamp_angle` (rad) and turns by `compliance` per moment; `curvature` has the coefficients of
    1, s, s², … in the natural curvature. `factor` maps arc lengths to the stiffness over that of a
    solid cone of one material.
    """

    def __init__(
        self,
        theta,
        count,
        s_c=1.0,
        *,
        tail=False,
        clamp_angle=0.0,
        compliance=0.0,
        curvature=(0,),
        factor=np.ones_like,
    ):
        self.h = s_c / count
        # The joints lie at s: the first link has half a length, the last one the remaining length.
        joints = count + round((1 - s_c) / self.h) * tail
        s = self.h * (np.arange(joints) + 0.5)
        bend = (1 - (1 - 1 / theta) * s) ** 4 * factor(s) / self.h
        # The tangent is the third axis of a link.
        self.stiffness = np.stack([bend, bend, bend / (1 + POISSON_RATIO)], axis=1)
        self.lengths = self.h * np.ones(joints + 1)
        self.lengths[0] /= 2
        self.lengths[-1] = (1.0 if tail else s_c) - s[-1]
        self.contact, self.tail = count, tail
        # Without load: the second axis of a link is normal to the plane, and points to -z.
        self.unloaded = np.zeros((joints, 3))
        self.unloaded[:, 1] = -self.h * np.polynomial.Polynomial(curvature)(s)
        if compliance:
            # One more joint, at the clamp, and a link without length before it.
            spring = np.array([[1.0, 1.0, RIGID]]) / compliance
            self.stiffness = np.concatenate([spring, self.stiffness])
            self.unloaded = np.concatenate([np.zeros((1, 3)), self.unloaded])
            self.lengths, self.contact = np.append(0.0, self.lengths), count + 1
        # Columns are the axes of a link in space; the first axis of an upright link is along x.
        self.slope = np.pi / 2 + clamp_angle
        cos, sin = np.cos(clamp_angle), np.sin(clamp_angle)
        lean = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
        self.clamp = lean @ np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])

    def links(self, v):
        """Return contact point, tangents and ends of links, and rotation per change of `v`."""
        turns, per_change = rotations(v)
        frames = [self.clamp]
        for turn in turns:
            frames.append(frames[-1] @ turn)
        frames = np.array(frames)
        tangents = frames[:, :, 2]
        ends = np.cumsum(self.lengths[:, None] * tangents, axis=0)
        # The contact point is the middle of a link, or the end of the last link.
        contact = ends[self.contact - 1] + self.h / 2 * tangents[self.contact]
        return contact, tangents, ends, frames[1:] @ per_change

    def misses(self, v, target):
        """Return the residuals of the contact conditions, and their derivatives by `v`."""
        contact, tangents, ends, turned = self.links(v)
        arms = contact - ends[:-1]
        arms[self.contact :] = 0
        moved = -skew(arms) @ turned
        missed, slopes = [contact - target], [np.moveaxis(moved, 1, 0)]
        if self.tail:
            rise = -skew(tangents[self.contact :][:1])[0, 1] @ turned
            missed.append(tangents[self.contact, 1:2])
            slopes.append((rise * (np.arange(len(v)) < self.contact)[:, None])[None])
        return np.concatenate(missed), np.concatenate(slopes)

    def energy(self, v):
        """Energy of the springs (E·I0/L)."""
        return 0.5 * (self.stiffness * (v - self.unloaded) ** 2).sum()

    def minimum(self, target, start):
        """Return the state of least energy near `start` with contact at `target`, and the force.

        Augmented Lagrangian: each round adds the force of the penalty to the contact force. Raises
        RuntimeError if the rounds do not converge.
        """
        scale, penalty, before = np.sqrt(self.stiffness), 1e3, np.inf
        forces = np.zeros(len(self.misses(start, target)[0]))

        def value(u):
            v = u.reshape(-1, 3) / scale
            missed, moved = self.misses(v, target)
            pull = forces + penalty * missed
            bend = u.reshape(-1, 3) - self.unloaded * scale
            slope = bend + np.einsum("i,inj->nj", pull, moved) / scale
            elastic = 0.5 * (bend**2).sum()
            return elastic + forces @ missed + 0.5 * penalty * missed @ missed, slope.ravel()

        u = (start * scale).ravel()
        for _ in range(MOST_ROUNDS):
            options = {"maxiter": 4000, "maxcor": 30, "ftol": 1e-16, "gtol": 1e-9}
            u = minimize(value, u, jac=True, method="L-BFGS-B", options=options).x
            missed, _ = self.misses(u.reshape(-1, 3) / scale, target)
            forces = forces + penalty * missed
            if np.abs(missed).max() < MISSED:
                return u.reshape(-1, 3) / scale, -forces[:3]
            # If a round reduces the error too little, the penalty is raised.
            if np.abs(missed).max() > NEARER * before:
                penalty *= 4
            before = np.abs(missed).max()
        raise RuntimeError(f"the contact is missed by {np.abs(missed).max():.1e}")

    def lateral_margin(self, v, force):
        """Return the smallest second variation out of the plane, per elastic energy.

        `v` is a planar state. Computed from differences of the gradient of the elastic energy minus
        the work of the contact force.
        """

        def moved(v):
            return self.misses(v, np.zeros(3))[1][:3]

        def slope(v):
            return self.stiffness * (v - self.unloaded) - np.einsum("i,inj->nj", force, moved(v))

        step, columns = 1e-5, []
        for joint, axis in np.ndindex(len(v), len(ASIDE)):
            away = np.zeros_like(v)
            away[joint, ASIDE[axis]] = step
            difference = slope(v + away) - slope(v - away)
            columns.append(difference[:, ASIDE].ravel() / (2 * step))
        half = np.array(columns) / 2
        free = null_space(moved(v)[2][:, ASIDE].reshape(1, -1))
        elastic = np.diag(self.stiffness[:, ASIDE].ravel())
        return eigh(free.T @ (half + half.T) @ free, free.T @ elastic @ free)[0][0]

    def planar(self, phi):
        """Return the rotation vectors of a planar shape with angle phi(s) at each link's middle."""
        angles = phi(np.cumsum(self.lengths) - self.lengths / 2)
        angles[0] = self.slope
        v = np.zeros((len(angles) - 1, 3))
        # The second axis of a link is normal to the plane, and points to -z.
        v[:, 1] = -np.diff(angles)
        return v
