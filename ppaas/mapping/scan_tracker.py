"""Scan tracker: the pose of each scan from odometry and the last key frames, and the choice of new key frames."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.mapping.alignment import TRACKING, Aligned, CorrelationGrid, Prior, Window, align
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.laser_motion import laser_step, odometry_deviations
from ppaas.mapping.near_poses import nearest_poses
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import ScanPoints
from ppaas.mapping.tracking_doubt import CONTRADICTED, TrackingDoubt
from ppaas.planar_poses import compose, relative

STANDING = 0.02
"""Step of the odometry up to which the start is not searched for [m, rad]."""

UNKNOWN = 0.1
"""Least deviations of a step while the odometry has never changed [m, rad]."""

LEAST_TURN = 0.02
"""Turn to each side that a search covers, besides twice the deviation of the odometry [rad]."""

LOST = 0.4
"""Part of the points that fit below which the odometry may be wrong."""

AGREEING = 3.0
"""Standard deviations of the odometry within which a pose is believed that few points fit."""

BETTER = 0.2
"""Least increase of that part with which a pose away from the odometry is believed."""

SLIP, SLIP_DEVIATIONS = Window(1.0, 0.6, 0.017), (0.1, 0.1, 0.1)
"""Window that is searched where the odometry may be wrong, and the deviations of the pose found [m, m, rad]."""


NEAR = 3.0
"""Largest distance of the key frames of a loaded map that a scan is aligned with [m]; see `nearest_poses`."""


class Tracked(NamedTuple):
    """Pose of a scan.

    Parameters
    ----------
    pose : Pose2D
        Pose of the laser in the map frame.
    is_key : bool
        Whether the scan became a key frame, the last one.
    key_frame : int
        Index of the last key frame, from which the pose hangs when closures move it.
    information : (6,) float64 array
        Information of the pose in the frame of the scan, including the odometry's; 0 for the first scan.
    ratio : float
        Part of the points that fit the key frames; 1 of the first scan.
    is_lost : bool
        Whether the robot is elsewhere than the key frames show, as after it was carried away. The scan is the first key
        frame of another part of the map; where that part lies is unknown.
    is_doubted : bool
        Whether the scan contradicts the key frames, so that the robot may be lost.
    """

    pose: Pose2D
    is_key: bool
    key_frame: int
    information: NDArray[np.float64]
    ratio: float
    is_lost: bool = False
    is_doubted: bool = False


class ScanTracker:
    """Tracks a laser scan by scan. The first scan is a key frame; its pose is the odometry's.

    On a map that was loaded, scans are aligned with the key frames of that map around them as well. The first scan, and
    the next one after `place`, is searched around a given pose.

    Each scan is expected where the odometry moved the last one. A correlative search finds the start, and the alignment
    with the last key frames the pose. A scan far enough from the last key frame becomes the next one.

    Scans that contradict the key frames become none until it is decided whether the robot was carried away; see
    `TrackingDoubt`. If so, another part of the map begins, and scans are aligned with key frames of that part only.

    Parameters
    ----------
    geometry : LaserGeometry
        Laser, and its place on the robot.
    parameters : SlamParameters
        Search window, odometry noise and spacing of key frames.
    """

    def __init__(self, geometry: LaserGeometry, parameters: SlamParameters) -> None:
        self.key_frames = KeyFrames(geometry, parameters.max_key_frames)
        self._parameters, self._mount = parameters, geometry.mount
        self._grid = CorrelationGrid(
            parameters.correlation_search_space_resolution, parameters.correlation_search_space_smear_deviation
        )
        self._scans = 0
        self._pose = self._odometry = Pose2D(0.0, 0.0, 0.0)
        self._near = self.key_frames.latest(0)
        self._loaded, self._keeps = 0, True
        self._start: Pose2D | None = None
        self._doubt, self._part = TrackingDoubt(geometry), 0
        self._has_odometry = False

    @property
    def pose(self) -> Pose2D:
        """Pose of the laser at the last scan, in the map frame."""
        return self._pose

    @property
    def odometry(self) -> Pose2D:
        """Odometry of the robot at the last scan."""
        return self._odometry

    @property
    def nearest(self) -> int | None:
        """Index of the key frame of a loaded map that is nearest to the next scan; None if none is near."""
        return int(self._near.indices[0]) if len(self._near.indices) else None

    @property
    def is_placing(self) -> bool:
        """Whether the next scan is searched around a given pose."""
        return self._start is not None

    def load(self, frames: KeyFrames, start: Pose2D, *, keeps: bool = True) -> None:
        """Continue on another map.

        Parameters
        ----------
        frames : KeyFrames
            Its key frames, of the same laser; at least one.
        start : Pose2D
            Pose of the **robot** near which the next scan is, in the map frame.
        keeps : bool
            Whether new key frames are kept. Otherwise there are only as many as scans are aligned with, and the oldest
            one is removed.

        Raises
        ------
        QuotaExceeded
            There are more key frames than allowed.
        """
        # In a fixed map the latest scans come on top, for as long as they are aligned with.
        frames.limit(self._parameters.max_key_frames + self._parameters.scan_buffer_size * (not keeps))
        self.key_frames, self._loaded, self._keeps = frames, len(frames), keeps
        self._scans = int(frames.scans[-1]) + 1
        self.place(start)

    def resume(self, frames: KeyFrames, pose: Pose2D, odometry: Pose2D) -> None:
        """Continue the map of another tracker after its last scan.

        Parameters
        ----------
        frames : KeyFrames
            Its key frames; at least one.
        pose, odometry : Pose2D
            The other tracker's.
        """
        frames.limit(self._parameters.max_key_frames)
        self.key_frames, self._scans = frames, int(frames.scans[-1]) + 1
        self._pose, self._odometry = pose, odometry
        self._look_around()

    def replace(self, frames: KeyFrames, kept: NDArray[np.bool_]) -> None:
        """Go on with other key frames of the same map, of which some were removed.

        Parameters
        ----------
        frames : KeyFrames
            Those that are left, at their poses, and those that are not in ``kept``.
        kept : (k,) bool array
            Which of the first k key frames are left; the last one is.
        """
        frames.limit(self._parameters.max_key_frames)
        self._loaded = int(kept[: self._loaded].sum())
        self.key_frames = frames
        self._look_around()

    def place(self, robot: Pose2D) -> None:
        """Search the next scan around a pose of the **robot** in the map frame."""
        if self._keeps:
            # The robot may be anywhere now: the nearest key frames count, instead of the latest.
            self._loaded = len(self.key_frames)
        self._doubt.clear()
        self._start = self._pose = robot @ self._mount
        self._look_around()

    def add(self, scan: ScanPoints, odometry: Pose2D) -> Tracked:
        """Track the next scan.

        Parameters
        ----------
        scan : ScanPoints
            Points of the scan; see `ppaas.mapping.scan_points.prepare`.
        odometry : Pose2D
            Pose of the **robot** in the frame of the odometry at the time of the scan.

        Raises
        ------
        QuotaExceeded
            The scan is a key frame, and there are as many as allowed.
        InvalidInput
            The scan does not fit the map around the pose where it was placed; the next scan is searched there again.
        """
        placed = self._start is not None
        if self._start is not None:
            pose, information, ratio, _ = self._placed(scan, self._start)
        elif self._scans:
            pose, information, ratio, _ = self._align(scan, odometry)
        else:
            pose, information, ratio = odometry @ self._mount, np.zeros(6), 1.0
        lost = self._doubt.is_lost
        # A doubtful scan must not become a key frame, which would confirm the next ones at a wrong place.
        is_key = placed or lost or not self._scans or (not self._doubt.is_raised and self._is_far(pose))
        if lost:
            # Where the new part of the map lies is unknown.
            information, ratio = np.zeros(6), 1.0
        if is_key:
            self.key_frames.add(scan, self._scans, pose, information)
        self._pose, self._odometry, self._start = pose, odometry, None
        self._scans += 1
        if lost:
            self.restrict(len(self.key_frames) - 1)
        elif is_key:
            self._forget_oldest()
            self._look_around()
        return Tracked(pose, is_key, len(self.key_frames) - 1, information, ratio, lost, self._doubt.is_raised)

    def restrict(self, first: int) -> None:
        """Align the next scans with the key frames from an index on, which are a part of the map."""
        self._part, self._loaded = first, 0
        self._doubt.clear()
        self._look_around()

    def rebase(self, odometry: Pose2D) -> None:
        """Continue from other odometry, as after a reset: the robot is taken not to have moved since the last scan."""
        self._odometry = odometry

    def remount(self, mount: Pose2D) -> None:
        """Take another pose of the laser in the robot's frame. Key frames are poses of the laser, and stay."""
        geometry = replace(self.key_frames.geometry, mount=mount)
        self._mount, self.key_frames.geometry = mount, geometry
        self._doubt = TrackingDoubt(geometry)

    def correct(self, poses: NDArray[np.float64]) -> None:
        """Move key frames, as after a closure; later key frames and the current pose move with the last one given.

        Parameters
        ----------
        poses : (m, 3) array
            Corrected poses of the first m key frames, m from 1 to the number of key frames.
        """
        count, stored = len(poses), self.key_frames.poses
        last = Pose2D(*stored[count - 1].tolist())
        # Taken before the key frames move, since later ones hang from the last that was corrected.
        later = relative(stored[count - 1], stored[count:])
        stored[:count] = poses
        stored[count:] = compose(stored[count - 1], later)
        self._pose = Pose2D(*stored[count - 1].tolist()) @ (last.inverse() @ self._pose)
        self._look_around()

    def _align(self, scan: ScanPoints, odometry: Pose2D) -> Aligned:
        moved = self._odometry.inverse() @ odometry
        # A robot without odometry reports one pose for ever.
        self._has_odometry |= odometry != self._odometry
        prior = Prior(self._pose @ laser_step(self._odometry, odometry, self._mount), self._deviations(moved))
        start = prior.pose
        if max(abs(moved.x), abs(moved.y), abs(moved.theta), prior.deviations[0]) > STANDING:
            start, _ = self._grid.search(scan, start, self._window(prior))
        aligned = align(scan, start, self.key_frames, self._near, TRACKING, prior=prior)
        if aligned.ratio < LOST:
            aligned = self._recover(scan, prior, aligned)
        confirmed = self._confirmed(scan, aligned)
        if aligned.ratio >= LOST and confirmed < CONTRADICTED:
            # After a slip a scan may fit at a wrong place: look around before it counts as a contradiction.
            again = self._searched(scan, prior)
            if (better := self._confirmed(scan, again)) >= CONTRADICTED:
                aligned, confirmed = again, better
        self._doubt.note(scan, moved, aligned.ratio, confirmed)
        return aligned if confirmed >= CONTRADICTED else _likely(prior, aligned)

    def _deviations(self, moved: Pose2D) -> tuple[float, float, float]:
        """Return the deviations of a step of the odometry; they are large if it has never changed: there is none."""
        along, across, turn = odometry_deviations(moved, self._parameters)
        if self._has_odometry:
            return along, across, turn
        return max(along, UNKNOWN), max(across, UNKNOWN), max(turn, UNKNOWN)

    def _recover(self, scan: ScanPoints, prior: Prior, aligned: Aligned) -> Aligned:
        """Search around a pose that the odometry may have got wrong, as after a slip; return the better alignment."""
        again = self._searched(scan, prior)
        if again.ratio >= max(LOST, aligned.ratio + BETTER):
            return again
        return _likely(prior, aligned)

    def _searched(self, scan: ScanPoints, prior: Prior) -> Aligned:
        """Return the pose of a scan that is searched around the one that the odometry expects."""
        start, _ = self._grid.search(scan, prior.pose, SLIP)
        return align(scan, start, self.key_frames, self._near, TRACKING, prior=Prior(start, SLIP_DEVIATIONS))

    def _confirmed(self, scan: ScanPoints, aligned: Aligned) -> float:
        """Return the share of a scan that the key frames confirm; 1 while the robot is localized in a fixed map."""
        return self._doubt.confirmation(scan, aligned, self.key_frames, self._near) if self._keeps else 1.0

    def _placed(self, scan: ScanPoints, near: Pose2D) -> Aligned:
        start, _ = self._grid.search(scan, near, SLIP)
        aligned = align(scan, start, self.key_frames, self._near, TRACKING, prior=Prior(start, SLIP_DEVIATIONS))
        if aligned.ratio < LOST:
            raise InvalidInput(
                f"the scan does not fit the map within {SLIP.distance:g} m of ({near.x:.2f}, {near.y:.2f}): "
                "publish the pose of the robot on 'initialpose'"
            )
        return aligned

    def _forget_oldest(self) -> None:
        """Remove the oldest new key frame if they are not kept and there are more than scans are aligned with."""
        if not self._keeps and len(self.key_frames) - self._loaded > self._parameters.scan_buffer_size:
            self.key_frames.remove(self._loaded)

    def _window(self, prior: Prior) -> Window:
        parameters, (along, _, turn) = self._parameters, prior.deviations
        distance = parameters.correlation_search_space_dimension + 2.0 * along
        return Window(distance, LEAST_TURN + 2.0 * turn, parameters.coarse_angle_resolution)

    def _is_far(self, pose: Pose2D) -> bool:
        last = Pose2D(*self.key_frames.poses[-1].tolist())
        parameters = self._parameters
        return (
            last.distance_to(pose) >= parameters.minimum_travel_distance
            or abs(wrap_angle(pose.theta - last.theta)) >= parameters.minimum_travel_heading
        )

    def _look_around(self) -> None:
        """Choose the key frames that the next scans are aligned with."""
        self._near = self._around(self._parameters.scan_buffer_size)
        self._grid.draw(self.key_frames, self._around(self._parameters.correlation_scans), self._pose)

    def _around(self, count: int) -> NearFrames:
        """Return the nearest key frames of a loaded map, then the latest, ``count`` in all or as many as there are."""
        frames, loaded = self.key_frames, self._loaded
        if not loaded:
            return frames.latest(min(count, len(frames) - self._part))
        near = nearest_poses(np.array([self._pose]), frames.poses[self._part : loaded], count, NEAR)[0]
        near = self._part + near[near >= 0]
        latest = np.arange(max(loaded, len(frames) - count + len(near)), len(frames))
        chosen = np.concatenate((near, latest))
        return NearFrames(chosen, frames.poses[chosen])


def _likely(prior: Prior, aligned: Aligned) -> Aligned:
    """Return a pose that few points fit if the odometry allows it, otherwise the pose that the odometry expects."""
    apart = prior.pose.inverse() @ aligned.pose
    if all(abs(off) <= AGREEING * deviation for off, deviation in zip(apart, prior.deviations, strict=True)):
        return aligned
    information = np.zeros(6)
    information[[0, 3, 5]] = 1.0 / np.square(prior.deviations)
    return aligned._replace(pose=prior.pose, information=information)
