"""Arrays of poses in the plane: x, y [m], theta [rad] along the last axis."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def wrap_angles(angles: ArrayLike) -> NDArray[np.float64]:
    """Wrap angles to [−π, π)."""
    wrapped: NDArray[np.float64] = (np.asarray(angles, np.float64) + np.pi) % (2.0 * np.pi) - np.pi
    return wrapped


def compose(base: ArrayLike, other: ArrayLike) -> NDArray[np.float64]:
    """Return ``base @ other`` for each pair of poses: ``other`` transformed from the frame at ``base``.

    Parameters
    ----------
    base, other : (..., 3) array
        Shapes are broadcast.

    Returns
    -------
    (..., 3) float64 array
    """
    a, b = np.broadcast_arrays(np.asarray(base, np.float64), np.asarray(other, np.float64))
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    composed = np.empty(a.shape)
    composed[..., 0] = a[..., 0] + c * b[..., 0] - s * b[..., 1]
    composed[..., 1] = a[..., 1] + s * b[..., 0] + c * b[..., 1]
    composed[..., 2] = wrap_angles(a[..., 2] + b[..., 2])
    return composed


def relative(base: ArrayLike, other: ArrayLike) -> NDArray[np.float64]:
    """Return the pose of ``other`` in the frame at ``base`` for each pair of poses; see `compose` for the shapes."""
    a, b = np.broadcast_arrays(np.asarray(base, np.float64), np.asarray(other, np.float64))
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    dx, dy = b[..., 0] - a[..., 0], b[..., 1] - a[..., 1]
    found = np.empty(a.shape)
    found[..., 0], found[..., 1] = c * dx + s * dy, c * dy - s * dx
    found[..., 2] = wrap_angles(b[..., 2] - a[..., 2])
    return found
