"""3D map whose parts move with the key frames of a 2D map, so that it stays right when a loop is closed.

Its clouds are added to one volume, as OctoMap does, and to submaps that hang on key frames. When key frames move, the
volume is put together again from the submaps at their new places.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.volume.blocks import VoxelBlocks, clear_box
from ppaas.mapping.volume.key_frame_poses import Anchor, KeyFramePoses
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.submap import LEAST_MOTION, VolumeSubmap, add_log_odds
from ppaas.mapping.volume.voxel_volume import VoxelVolume
from ppaas.planar_poses import PoseArray
from ppaas.thread_budget import Threads, one_thread

SUBMAP_TRAVEL = 3.0
"""Default distance between two submaps [m]."""

SPACE = 0.9
"""Part of the allowed blocks that are left when submaps were joined."""


class SubmapVolume:
    """3D map of clouds that hang on key frames.

    ``max_blocks`` limits the blocks of the volume and of all submaps together. If there would be more, successive
    submaps are joined: they move together from then on. If that is not enough, the map no longer moves with the key
    frames: its submaps are dropped.

    Parameters
    ----------
    parameters : VolumeParameters
    threads : callable
        Returns the number of threads of an insertion.
    submap_travel : float
        Distance between key frames on which two successive submaps hang, along the path of the robot [m].

    Attributes
    ----------
    volume : VoxelVolume
        The whole map.
    submaps : list of VolumeSubmap
        Its parts, in the order of their key frames.
    joined : int
        Number of submaps that were joined to others.
    fixed : bool
        Whether the map is too large to move with the key frames.
    """

    def __init__(
        self, parameters: VolumeParameters, threads: Threads = one_thread, submap_travel: float = SUBMAP_TRAVEL
    ) -> None:
        self.volume = VoxelVolume(parameters, threads)
        self.submaps: list[VolumeSubmap] = []
        self.joined, self.fixed = 0, False
        self._last: Anchor | None = None
        self._begun = 0
        self._submap_travel, self._travel = submap_travel, 0.0

    def __len__(self) -> int:
        """Return the number of blocks of the volume and all submaps."""
        return len(self.volume.blocks) + sum(len(submap.blocks) for submap in self.submaps)

    def insert(
        self,
        points: NDArray[np.float32],
        origin: ArrayLike,
        anchor: Anchor | None = None,
        ground: NDArray[np.bool_] | None = None,
    ) -> None:
        """Add a point cloud.

        Parameters
        ----------
        points, origin, ground
            See `VoxelVolume.insert`.
        anchor : Anchor, optional
            Key frame that it hangs on. None if there is no key frame: the cloud then hangs on the last submap, or on
            the first one that begins later.

        Raises
        ------
        InvalidInput, QuotaExceeded
            As `VoxelVolume.insert`.
        """
        submap = None if self.fixed else self._submap(anchor)
        self.volume.insert(points, origin, ground=ground, also=None if submap is None else submap.blocks)
        self._limit()

    def correct(self, before: KeyFramePoses, after: KeyFramePoses) -> bool:
        """Move the submaps with their key frames; return whether the volume has changed.

        Parameters
        ----------
        before, after : KeyFramePoses
            Poses of the key frames up to now, and from now on.
        """
        resolution, changed = self.volume.parameters.resolution, False
        for submap in self.submaps:
            step = after.motion_since(before, submap.stamp)
            submap.motion = step @ submap.motion
            changed |= submap.reach_of_motion(step, resolution) >= LEAST_MOTION * resolution
        self._last = None  # the next cloud begins a submap at the new place of its key frame
        if changed:
            self._assemble()
        return changed

    def moved(self, key_frames: KeyFramePoses, before: PoseArray, after: PoseArray) -> VoxelVolume:
        """Return the volume as it would be if key frames moved; a map that is fixed does not.

        Parameters
        ----------
        key_frames : KeyFramePoses
            Key frames at whose poses the map is.
        before, after : (k, 3) array
            Poses of the robot at key frames, and where they would move to. A submap moves with the one that is nearest
            to its own.

        Raises
        ------
        QuotaExceeded
            There would be more blocks than allowed.
        """
        own = self.volume.parameters
        volume, model = VoxelVolume(own), own.model()
        if not (self.submaps and len(key_frames) and len(before)):
            volume.blocks = self.volume.blocks
            return volume
        for submap in self.submaps:
            pose = key_frames.anchor(submap.stamp).pose
            nearest = int(np.hypot(*(before[:, :2] - pose[:2]).T).argmin())
            old, new = Pose2D(*before[nearest].tolist()), Pose2D(*after[nearest].tolist())
            add_log_odds(volume.blocks, *submap.placed(own.resolution, new @ old.inverse()), model)
        return volume

    def clear_box(self, low: ArrayLike, high: ArrayLike) -> None:
        """Make all known voxels free whose centres are in a box of the map frame, (3,) corners [m]."""
        own = self.volume.parameters
        clear_box(self.volume.blocks, low, high, own)
        for submap in self.submaps:
            clear_box(submap.blocks, low, high, own, submap.motion)

    def clear(self) -> None:
        """Forget all voxels."""
        self.volume.clear()
        self.submaps, self.joined, self.fixed, self._last = [], 0, False, None

    def resume(self, submaps: list[VolumeSubmap], whole: VoxelBlocks | None, *, joined: int, fixed: bool) -> None:
        """Continue another map.

        Parameters
        ----------
        submaps : list of VolumeSubmap
            Its parts.
        whole : VoxelBlocks, optional
            Its voxels; by default put together from the parts.
        joined : int
        fixed : bool
            The other map's.

        Raises
        ------
        QuotaExceeded
            There are more blocks than allowed.
        """
        self.submaps, self.joined, self.fixed, self._last = submaps, joined, fixed, None
        self._begun = max((submap.number for submap in submaps), default=0)
        if whole is None:
            self._assemble()
        else:
            self.volume.blocks = whole

    def _submap(self, anchor: Anchor | None) -> VolumeSubmap | None:
        """Return the submap for a cloud; None as long as there was no key frame."""
        if anchor is None:
            return self.submaps[-1] if self.submaps else None
        begun, submap = bool(self.submaps), self._open(anchor)
        if not begun:  # the clouds before the first key frame move with it
            blocks = self.volume.blocks
            add_log_odds(submap.blocks, blocks.codes, blocks.log_odds, self.volume.parameters.model())
        return submap

    def _open(self, anchor: Anchor) -> VolumeSubmap:
        """Return the submap for a cloud; a new one if the robot has moved far enough since the last one began."""
        last, self._last = self._last, anchor
        if last is not None:
            self._travel += last.pose.distance_to(anchor.pose)
        if last is None or self._travel >= self._submap_travel or not self.submaps:
            if self.submaps:
                self.submaps[-1].blocks.trim()
            self._begun += 1
            self.submaps.append(VolumeSubmap(self._begun, anchor.stamp, 2 * self.volume.parameters.max_blocks))
            self._travel = 0.0
        return self.submaps[-1]

    def _limit(self) -> None:
        """Join submaps if there are more blocks than allowed, so that there is space for some more."""
        most = self.volume.parameters.max_blocks
        if len(self) <= most:
            return
        while len(self) > SPACE * most and len(self.submaps) > 1:
            self._join_smallest()
        if len(self) > most:
            self.submaps, self.fixed = [], True

    def _join_smallest(self) -> None:
        own, sizes = self.volume.parameters, [len(submap.blocks) for submap in self.submaps]
        first = min(range(len(sizes) - 1), key=lambda index: sizes[index] + sizes[index + 1])
        if first == len(sizes) - 2:
            self._last = None  # the next cloud begins a submap
        second = self.submaps.pop(first + 1)
        self.submaps[first].join(second, own.model(), own.resolution)
        self.submaps[first].blocks.trim()
        self.joined += 1

    def _assemble(self) -> None:
        own = self.volume.parameters
        blocks, model = VoxelBlocks(own.max_blocks), own.model()
        for submap in self.submaps:
            add_log_odds(blocks, *submap.placed(own.resolution), model)
        self.volume.blocks = blocks
