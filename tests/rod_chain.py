"""A rod in space that shares no code with the package: rigid links, joined by springs.

Each joint turns by a rotation vector, with stiffnesses for its two bends and for its twist. The
first link is clamped, the end is held at a point of space as by a ball joint. The energy is
minimised under this condition, for bends and twists of any size.
"""

import numpy as np
from scipy.optimize import minimize

POISSON_RATIO = 0.3


def skew(v):
    zero = np.zeros(len(v))
    rows = [[zero, -v[:, 2], v[:, 1]], [v[:, 2], zero, -v[:, 0]], [-v[:, 1], v[:, 0], zero]]
    return np.moveaxis(np.array(rows), -1, 0)


def rotations(v):
    """Rotation matrices of rotation vectors, and the body rotation per change of the vector."""
    angle = np.sqrt((v**2).sum(axis=1) + 1e-30)[:, None, None]
    cross = skew(v)
    square = cross @ cross
    first, second = np.sin(angle) / angle, (1 - np.cos(angle)) / angle**2
    third = (angle - np.sin(angle)) / angle**3
    third = np.where(angle < 1e-3, 1 / 6, third)
    eye = np.eye(3)
    return eye + first * cross + second * square, eye - second * cross + third * square


class Chain:
    """Links of a cone that begins at the clamp and ends at arc length `s_c`."""

    def __init__(self, theta, count, s_c=1.0):
        self.h = s_c / count
        s = self.h * (np.arange(count) + 0.5)
        bend = (1 - (1 - 1 / theta) * s) ** 4 / self.h
        # The tangent is the third axis of a link.
        self.stiffness = np.stack([bend, bend, bend / (1 + POISSON_RATIO)], axis=1)
        # Half a link, whole ones, half a link: the joints lie at s.
        self.lengths = self.h * np.ones(count + 1)
        self.lengths[[0, -1]] /= 2
        # Upright, its first axis along the surface: columns are the axes of a link in space.
        self.clamp = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])

    def ends(self, v):
        """Where the links end, and what the end moves per change of each rotation vector."""
        turns, per_change = rotations(v)
        frames = [self.clamp]
        for turn in turns:
            frames.append(frames[-1] @ turn)
        frames = np.array(frames)
        points = np.cumsum(self.lengths[:, None] * frames[:, :, 2], axis=0)
        arm = skew(points[-1] - points[:-1])
        return points, -arm @ (frames[1:] @ per_change)

    def energy(self, v):
        return 0.5 * (self.stiffness * v**2).sum()

    def minimum(self, target, start):
        """State of least energy near `start` with the end at `target`, and the force there.

        Augmented Lagrangian: each round ends with the force that the penalty has found.
        """
        scale, force, penalty = np.sqrt(self.stiffness), np.zeros(3), 1e3

        def value(u):
            v = u.reshape(-1, 3) / scale
            points, moved = self.ends(v)
            miss = points[-1] - target
            pull = force + penalty * miss
            slope = u.reshape(-1, 3) + np.einsum("i,nij->nj", pull, moved) / scale
            return 0.5 * u @ u + force @ miss + 0.5 * penalty * miss @ miss, slope.ravel()

        u = (start * scale).ravel()
        for _ in range(12):
            options = {"maxiter": 4000, "maxcor": 30, "ftol": 1e-16, "gtol": 1e-9}
            u = minimize(value, u, jac=True, method="L-BFGS-B", options=options).x
            miss = self.ends(u.reshape(-1, 3) / scale)[0][-1] - target
            force = force + penalty * miss
            if np.abs(miss).max() < 1e-9:
                break
        return u.reshape(-1, 3) / scale, -force

    def planar(self, phi):
        """Rotation vectors of a planar shape with the tangent angles phi(s) at the joints' ends."""
        angles = phi(np.append(0, np.cumsum(self.lengths) - self.lengths / 2)[1:])
        angles[0] = np.pi / 2
        v = np.zeros((len(angles) - 1, 3))
        # The second axis of a link is normal to the plane, and points to -z.
        v[:, 1] = -np.diff(angles)
        return v
