"""Points of depth images above the floor on which the robot stands."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.perception.depth_scan import MILLIMETRES, PinholeCamera
from ppaas.perception.kernels.depth import Depths

COLUMNS = 320
"""Number of columns of an image that are used; wider images are thinned out to about as many."""

FLOOR_NEAR, FLOOR_SPREAD, FLOOR_FAR = 0.05, 0.02, 5.0
"""Points that count as floor: up to this height at the camera [m], growing by metre [m/m], up to this distance [m]."""

FEWEST_FLOOR = 50
"""Least number of floor points for a fit."""

STEEPEST = 0.2
"""Largest slope between two points of the floor [m/m]."""

HOLD = 0.05
"""Weight of a level floor at the height of the mount, as a share of the number of points."""

LIMITS = np.array([0.05, 0.05, 0.06])
"""Limits of the correction: slopes [m/m] and height [m]."""

SMOOTHING = 0.3
"""Weight of an image in the average of the correction."""

Plane = tuple[float, float, float]
"""Height of the floor, a·x + b·y + c, in the frame in which the mount was given."""


class FloorPoints(NamedTuple):
    """Points of the pixels of a thinned image, in a frame on the floor below the robot.

    Parameters
    ----------
    x, y, z : (height, width) float32 arrays
        Ahead, to the left, and above the floor [m]; NaN where the image has no reading.
    """

    x: NDArray[np.float32]
    y: NDArray[np.float32]
    z: NDArray[np.float32]


class FloorView:
    """View of one depth camera over the floor.

    The mount gives the floor; since mounts are rarely exact, a plane is fitted to the points near it, and averaged over
    images.

    Parameters
    ----------
    camera : PinholeCamera
        The camera.
    fy : float
        Focal length along columns [pixels].
    mount : (4, 4) array
        Transform from the camera, with x to the right, y down and z ahead, to the robot's frame on the floor.

    Attributes
    ----------
    floor : tuple of three float
        Fitted floor: its slopes along x and y [m/m], and its height at the origin [m].

    Raises
    ------
    InvalidInput
        The mount or the focal length is invalid.
    """

    def __init__(self, camera: PinholeCamera, fy: float, mount: NDArray[np.float64]) -> None:
        if mount.shape != (4, 4) or not np.isfinite(mount).all() or not 0.0 < fy < np.inf:
            raise InvalidInput("the pose of a camera must be a finite matrix of 4×4, and its focal length above 0")
        self.camera, self.fy = camera, fy
        self.stride = max(1, round(camera.width / COLUMNS))
        self.rotation, self.origin = mount[:3, :3].copy(), mount[:3, 3].copy()
        across = (np.arange(0, camera.width, self.stride) - camera.cx) / camera.fx
        down = (np.arange(0, camera.height, self.stride) - camera.cy) / fy
        rays = np.stack(np.broadcast_arrays(across[None, :], down[:, None], 1.0))
        self._rays = np.tensordot(self.rotation, rays, 1).astype(np.float32)
        self.floor: Plane = (0.0, 0.0, 0.0)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a thinned image."""
        return self._rays.shape[1], self._rays.shape[2]

    def points(self, image: Depths) -> FloorPoints:
        """Return the points of an image, (height, width) uint16 [mm] or float32 [m], after a fit of the floor.

        Raises
        ------
        InvalidInput
            The image has another size or type than the camera's images.
        """
        if image.shape != (self.camera.height, self.camera.width) or image.dtype not in (np.uint16, np.float32):
            raise InvalidInput(
                f"a depth image must have {self.camera.width}×{self.camera.height} pixels of uint16 or float32, by its "
                f"camera_info, not shape {image.shape} of {image.dtype}"
            )
        x, y, z = self._back_project(image[:: self.stride, :: self.stride])
        self._fit(x, y, z)
        a, b, c = self.floor
        z -= np.float32(a) * x + np.float32(b) * y + np.float32(c)
        return FloorPoints(x, y, z)

    def pixels(
        self, x: NDArray[np.float32], y: NDArray[np.float32], z: NDArray[np.float32]
    ) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
        """Return the flat indices of the pixels of a thinned image that show points, and which points are in the image.

        Parameters
        ----------
        x, y, z : float32 arrays that broadcast
            Points over the floor [m].
        """
        a, b, c = (np.float32(part) for part in self.floor)
        turn, (ox, oy, oz) = self.rotation.astype(np.float32), self.origin.astype(np.float32)
        dx, dy = x - ox, y - oy
        dz = z + (a * x + b * y + (c - oz))
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = turn[0, 2] * dx + turn[1, 2] * dy + turn[2, 2] * dz
            scale = np.float32(1.0 / self.stride) / depth
            column = (turn[0, 0] * dx + turn[1, 0] * dy + turn[2, 0] * dz) * (scale * np.float32(self.camera.fx))
            row = (turn[0, 1] * dx + turn[1, 1] * dy + turn[2, 1] * dz) * (scale * np.float32(self.fy))
        column += np.float32(self.camera.cx / self.stride + 0.5)
        row += np.float32(self.camera.cy / self.stride + 0.5)
        rows, columns = self.shape
        inside = (depth > 0.0) & (column >= 0.0) & (column < columns) & (row >= 0.0) & (row < rows)
        safe = np.where(inside, row, 0.0).astype(np.int32) * np.int32(columns)
        return safe + np.where(inside, column, 0.0).astype(np.int32), inside

    def _back_project(self, image: Depths) -> NDArray[np.float32]:
        depth = image.astype(np.float32)
        if image.dtype == np.uint16:
            depth[(image == 0) | (image == np.iinfo(np.uint16).max)] = np.nan
            depth *= np.float32(MILLIMETRES)
        else:
            depth[~((depth > 0.0) & (depth < np.inf))] = np.nan
        points: NDArray[np.float32] = self._rays * depth
        points += self.origin.astype(np.float32)[:, None, None]
        return points

    def _fit(self, x: NDArray[np.float32], y: NDArray[np.float32], z: NDArray[np.float32]) -> None:
        """Fit the floor to level points near the floor known so far, of every fourth row and column."""
        x, y, z = (axis[::4, ::4] for axis in (x, y, z))
        with np.errstate(invalid="ignore"):
            # Walls and furniture touch the floor: level points are farther away from the row below, not higher.
            level = np.abs(z[:-1] - z[1:]) < STEEPEST * np.hypot(x[:-1] - x[1:], y[:-1] - y[1:])
        x, y, z = (axis[:-1][level].astype(np.float64) for axis in (x, y, z))
        a, b, c = self.floor
        away = np.hypot(x, y)
        near = (np.abs(z - (a * x + b * y + c)) < FLOOR_NEAR + FLOOR_SPREAD * away) & (away < FLOOR_FAR)
        count = np.count_nonzero(near)
        if count < FEWEST_FLOOR:
            return
        terms = np.stack([x[near], y[near], np.ones(count)], 1)
        held = np.diag([1.0, 1.0, 0.1]) * HOLD * count
        fitted = np.linalg.solve(terms.T @ terms + held, terms.T @ z[near])
        new = np.clip(fitted, -LIMITS, LIMITS)
        a, b, c = ((1.0 - SMOOTHING) * np.array(self.floor) + SMOOTHING * new).tolist()
        self.floor = (a, b, c)
