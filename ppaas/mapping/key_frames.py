"""Key frames: the scans that the map consists of, stacked in growing arrays."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_points import ScanPoints

FIRST_SIZE = 64
"""Number of key frames that the arrays have space for at first."""

GROWTH = 1.5
"""Factor by which full arrays grow."""


class NearFrames(NamedTuple):
    """Key frames that a scan is aligned with.

    Parameters
    ----------
    indices : (m,) int64 array
        Indices into the arrays of the key frames.
    poses : (m, 3) float64 array
        Poses at which they are held: x, y [m], theta [rad] of the laser in the map frame.
    """

    indices: NDArray[np.int64]
    poses: NDArray[np.float64]


class _Arrays(NamedTuple):
    """Arrays of the properties of `KeyFrames` of the same names, with spare rows."""

    poses: NDArray[np.float64]
    information: NDArray[np.float64]
    scans: NDArray[np.int64]
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    valid: NDArray[np.bool_]

    @classmethod
    def of(cls, size: int, beams: int) -> "_Arrays":
        """Return arrays of zeros with space for ``size`` frames."""
        return cls(
            np.zeros((size, 3)),
            np.zeros((size, 6)),
            np.zeros(size, np.int64),
            np.zeros((size, beams, 2), np.float32),
            np.zeros((size, beams, 2), np.float32),
            np.zeros((size, beams), np.bool_),
        )


class KeyFrames:
    """Key frames of one laser, in the order of their scans. A frame takes 80 bytes, and 17 bytes per beam.

    The arrays returned are views of those stored; only `add` replaces them.

    Parameters
    ----------
    geometry : LaserGeometry
        Laser of all scans.
    most : int
        Largest number of key frames.
    """

    def __init__(self, geometry: LaserGeometry, most: int = 100_000) -> None:
        self.geometry = geometry
        self._most, self._count = most, 0
        self._arrays = _Arrays.of(min(FIRST_SIZE, most), geometry.beams)

    def __len__(self) -> int:
        return self._count

    @property
    def poses(self) -> NDArray[np.float64]:
        """Poses of the laser in the map frame, (k, 3): x, y [m], theta [rad]; may be written to."""
        return self._arrays.poses[: self._count]

    @property
    def information(self) -> NDArray[np.float64]:
        """Information of each frame's pose when it was tracked, (k, 6), in its own frame; 0 of the first."""
        return self._arrays.information[: self._count]

    @property
    def scans(self) -> NDArray[np.int64]:
        """Index of the scan that each frame is, (k,), ascending."""
        return self._arrays.scans[: self._count]

    @property
    def points(self) -> NDArray[np.float32]:
        """Points of the scans, (k, b, 2), each in its own frame [m]."""
        return self._arrays.points[: self._count]

    @property
    def normals(self) -> NDArray[np.float32]:
        """Normals of the scans, (k, b, 2), each in its own frame; (0, 0) = none."""
        return self._arrays.normals[: self._count]

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Mask of the beams with a reading, (k, b)."""
        return self._arrays.valid[: self._count]

    def scan_points(self, index: int | slice | NDArray[Any]) -> ScanPoints:
        """Return the scan of one key frame, or the scans of several, stacked."""
        return ScanPoints(self.points[index], self.normals[index], self.valid[index])

    def add(self, scan: ScanPoints, number: int, pose: Pose2D, information: NDArray[np.float64]) -> int:
        """Append a key frame and return its index.

        Parameters
        ----------
        scan : ScanPoints
            Points of the scan; copied.
        number : int
            Index of the scan.
        pose : Pose2D
            Pose of the laser in the map frame.
        information : (6,) array
            Information of the pose in the frame of the scan.

        Raises
        ------
        QuotaExceeded
            There are as many key frames as allowed.
        """
        if self._count >= self._most:
            raise QuotaExceeded(f"the map has {self._most} key frames, the most allowed: raise max_key_frames")
        if self._count == len(self._arrays.poses):
            self._grow(min(int(GROWTH * self._count) + 1, self._most))
        index, arrays = self._count, self._arrays
        arrays.points[index], arrays.normals[index], arrays.valid[index] = scan
        arrays.poses[index], arrays.scans[index], arrays.information[index] = pose, number, information
        self._count += 1
        return index

    def extend(
        self,
        poses: NDArray[np.float64],
        information: NDArray[np.float64],
        numbers: NDArray[np.int64],
        scans: ScanPoints,
    ) -> None:
        """Append copies of k key frames.

        Parameters
        ----------
        poses : (k, 3) array
            Poses of the laser in the map frame.
        information : (k, 6) array
            Information of the poses in the frames of the scans.
        numbers : (k,) array
            Indices of the scans.
        scans : ScanPoints
            Their points, normals and readings, stacked: (k, b, 2), (k, b, 2), (k, b).

        Raises
        ------
        QuotaExceeded
            There would be more key frames than allowed.
        """
        begin, end = self._count, self._count + len(poses)
        if end > self._most:
            raise QuotaExceeded(
                f"the map has {end} key frames, and at most {self._most} are allowed: raise max_key_frames"
            )
        if end > len(self._arrays.poses):
            self._grow(end)
        arrays: tuple[NDArray[Any], ...] = self._arrays
        rows: tuple[NDArray[Any], ...] = (poses, information, numbers, *scans)
        for stored, given in zip(arrays, rows, strict=True):
            stored[begin:end] = given
        self._count = end

    def limit(self, most: int) -> None:
        """Set the largest number of key frames; raises ``QuotaExceeded`` if there are more."""
        if self._count > most:
            raise QuotaExceeded(
                f"the map has {self._count} key frames, and at most {most} are allowed: raise max_key_frames"
            )
        self._most = most

    def remove(self, index: int) -> None:
        """Remove a key frame; later ones move up. Not while a snapshot is in use."""
        arrays: tuple[NDArray[Any], ...] = self._arrays
        for array in arrays:
            array[index : self._count - 1] = array[index + 1 : self._count]
        self._count -= 1

    def snapshot(self) -> "KeyFrames":
        """Return the key frames as they are now, for another thread. None may be added to a snapshot.

        It shares the scans, which never change, and has its own poses.
        """
        taken = KeyFrames.__new__(KeyFrames)
        taken.geometry, taken._most, taken._count = self.geometry, self._count, self._count
        taken._arrays = self._arrays._replace(poses=self.poses.copy())
        return taken

    def at(self, poses: NDArray[np.float64]) -> "KeyFrames":
        """Return a snapshot at other poses (k, 3), which are copied."""
        taken = self.snapshot()
        taken.poses[:] = poses
        return taken

    def latest(self, count: int) -> NearFrames:
        """Return the last ``count`` key frames, or all if there are fewer, at the poses stored."""
        indices = np.arange(max(0, self._count - count), self._count)
        return NearFrames(indices, self.poses[indices])

    def _grow(self, size: int) -> None:
        grown = _Arrays.of(size, self.geometry.beams)
        for name in _Arrays._fields:
            getattr(grown, name)[: self._count] = getattr(self._arrays, name)[: self._count]
        self._arrays = grown
