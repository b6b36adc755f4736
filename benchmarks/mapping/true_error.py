"""Errors of estimated poses where the true ones are known."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.relations import Relations
from ppaas.planar_poses import relative

NEAR, APART = 3.0, 100
"""Largest distance of the two poses of a relation [m], and smallest number of scans between them."""


def random_relations(stamps: NDArray[np.float64], true: NDArray[np.float64], seed: int, most: int = 3000) -> Relations:
    """Return true relations between random pairs of poses that are near each other, but not in time.

    Parameters
    ----------
    stamps : (n,) array
        Distinct times of the poses [s].
    true : (n, 3) array
        True poses: x, y [m], theta [rad].
    seed : int
        Seed of the choice.
    most : int
        Largest number of relations.
    """
    random = np.random.default_rng(seed)
    pairs = random.integers(0, len(true), (100 * most, 2))
    first, second = pairs.T
    gap = np.hypot(*(true[first, :2] - true[second, :2]).T)
    pairs = pairs[(gap < NEAR) & (np.abs(first - second) > APART)][:most]
    return Relations(stamps[pairs], relative(true[pairs[:, 0]], true[pairs[:, 1]]))


def absolute_errors(true: NDArray[np.float64], estimated: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances (n,) of the positions [m], after the rotation and shift that fit best (Kabsch 1976)."""
    a, b = (poses[:, :2] - poses[:, :2].mean(axis=0) for poses in (true, estimated))
    left, _, right = np.linalg.svd(b.T @ a)
    rotation = left @ np.diag((1.0, np.sign(np.linalg.det(left @ right)))) @ right
    errors: NDArray[np.float64] = np.hypot(*(b @ rotation - a).T)
    return errors
