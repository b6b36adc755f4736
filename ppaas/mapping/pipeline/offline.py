"""Offline mapping: a map and the poses of all scans, polished by the key frames around, of a recorded drive."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.mapping.alignment import AlignmentSettings, Prior, align
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.graph.pose_graph import measured_odometry
from ppaas.mapping.key_frames import KeyFrames, NearFrames
from ppaas.mapping.laser_motion import resets, velocities
from ppaas.mapping.map_drawing import DEFAULTS as DRAWING
from ppaas.mapping.map_drawing import draw_map
from ppaas.mapping.near_poses import nearest_poses
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.pipeline.graph_mapper import CLOSURES, FRONT_END, GraphMapper
from ppaas.mapping.refinement import refine
from ppaas.mapping.scan_log import ScanLog
from ppaas.mapping.scan_points import ScanPoints, prepare
from ppaas.maps.grid import GridMap
from ppaas.planar_poses import PoseArray, compose, inverse

# -- pose of every scan from the key frames around it ------------------------------------------------------------------

POLISHING = AlignmentSettings(gates=(0.15, 0.1, 0.1, 0.1), deviation=0.06)
"""Settings of the alignment: the pose is nearly right, and several key frames repeat one error."""

DEVIATIONS = (0.02, 0.02, 0.01)
"""Standard deviations of the pose before [m, m, rad]."""

NEAR, RADIUS = 8, 3.0
"""Number of key frames that a scan is aligned with, and their largest distance [m]; see `nearest_poses`."""

LEAST_RATIO = 0.4
"""Least part of the points that fit; otherwise the pose stays."""


class ScanPolisher:
    """Aligns scans with the nearest key frames.

    Parameters
    ----------
    key_frames : KeyFrames
        Scans of the map.
    key_poses : (k, 3) array
        Their refined poses, which stay fixed.
    poses : (n, 3) array
        Pose of the laser in the map frame at each scan of the log.
    """

    def __init__(self, key_frames: KeyFrames, key_poses: PoseArray, poses: PoseArray) -> None:
        self._frames, self._key_poses, self._poses = key_frames, key_poses, poses
        self._near = nearest_poses(poses, key_poses, NEAR + 1, RADIUS)

    def polish(self, number: int, scan: ScanPoints) -> Pose2D:
        """Return the polished pose of a scan.

        Parameters
        ----------
        number : int
            Index of the scan. The key frame that it became, if any, is left out.
        scan : ScanPoints
            Its points.
        """
        pose = Pose2D(*self._poses[number].tolist())
        near = self._near[number]
        near = near[near >= 0]
        near = near[self._frames.scans[near] != number]
        if not len(near):
            return pose
        frames = NearFrames(near, self._key_poses[near])
        aligned = align(scan, pose, self._frames, frames, POLISHING, prior=Prior(pose, DEVIATIONS))
        return aligned.pose if aligned.ratio > LEAST_RATIO else pose


# -- the drive ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class LogMap:
    """Result of mapping a log.

    Parameters
    ----------
    mapper : GraphMapper
        Key frames and pose graph; poses are the laser's.
    stages : dict of str to array
        Poses (n, 3) of the robot at each scan, in the map frame, after each stage: ``tracking`` alone, with
        ``closures``, after the ``refinement`` of key frames, and after the ``polish`` of each scan.
    seconds : dict of str to float
        Time of each part [s].
    """

    mapper: GraphMapper
    stages: dict[str, NDArray[np.float64]]
    seconds: dict[str, float]

    @property
    def poses(self) -> NDArray[np.float64]:
        """Poses (n, 3) of the robot after the last stage: x, y [m], theta [rad]."""
        return list(self.stages.values())[-1]

    def grid(self, resolution: float = DRAWING.resolution) -> GridMap:
        """Return the map, drawn with cells of a size [m]; raises ``QuotaExceeded`` if it is too large."""
        return draw_map(self.mapper.key_frames, self.mapper.key_frames.poses, DRAWING._replace(resolution=resolution))

    def summary(self) -> dict[str, Any]:
        """Return the numbers of scans, key frames and closures, and the times."""
        counts = self.mapper.counts
        return {
            "scans": len(self.poses),
            "key_frames": len(self.mapper.key_frames),
            "closures": counts.closures,
            "closure_edges": counts.edges,
            "distrusted_edges": counts.distrusted,
            "lone_closures": counts.lone,
            "parts": 1 + len(self.mapper.parts.others),
            "refused": dict(counts.refused),
            "seconds": {name: round(value, 3) for name, value in self.seconds.items()},
        }


class _Scans:
    """Points of the scans of a log, calculated when needed, as they are larger than the ranges."""

    def __init__(self, log: ScanLog, parameters: SlamParameters) -> None:
        self._log, self._parameters = log, parameters
        self._velocities: NDArray[np.float64] = np.zeros((len(log), 3))
        if log.geometry.time_increment > 0.0:
            self._velocities = velocities(log.stamps, log.odometry, log.geometry.mount)

    def correct(self, poses: NDArray[np.float64], key_frames: KeyFrames) -> None:
        """Correct the scans, also of the key frames, for the motion along poses (n, 3) of the laser."""
        if self._log.geometry.time_increment == 0.0:
            return
        self._velocities = velocities(self._log.stamps, poses, Pose2D(0.0, 0.0, 0.0))
        for frame, scan in enumerate(key_frames.scans.tolist()):
            key_frames.points[frame], key_frames.normals[frame], key_frames.valid[frame] = self[scan]

    def __getitem__(self, scan: int) -> ScanPoints:
        log = self._log
        return prepare(log.ranges[scan], log.geometry_of(scan), self._parameters, self._velocities[scan])


def map_log(
    log: ScanLog,
    parameters: SlamParameters = FRONT_END,
    closures: ClosureParameters = CLOSURES,
    done: Callable[[int], None] | None = None,
) -> LogMap:
    """Map a log.

    Parameters
    ----------
    log : ScanLog
    parameters : SlamParameters
        Of the front end.
    closures : ClosureParameters
        Of the search for loop closures.
    done : callable, optional
        Called with the number of scans tracked, after each.

    Raises
    ------
    QuotaExceeded
        There are more key frames than allowed.
    """
    mapper, scans = GraphMapper(log.geometry, parameters, closures), _Scans(log, parameters)
    clock = monotonic()
    frames, within = _track(log, scans, mapper, done)
    mapper.finish()
    seconds = {**mapper.seconds, "points": monotonic() - clock - sum(mapper.seconds.values())}
    stages = {
        "tracking": compose(_tracked_frames(mapper)[frames], within),
        "closures": compose(mapper.key_frames.poses[frames], within),
    }
    clock = monotonic()
    scans.correct(stages["closures"], mapper.key_frames)
    mapper.move(refine(mapper.key_frames, mapper.graph.poses, measured_odometry(mapper.graph.edges)).poses)
    stages["refinement"] = compose(mapper.key_frames.poses[frames], within)
    seconds["refinement"], clock = monotonic() - clock, monotonic()
    stages["polish"] = _polished(stages["refinement"], scans, mapper.key_frames)
    seconds["polish"] = monotonic() - clock
    mount = inverse(np.array(log.geometry.mount))
    return LogMap(mapper, {name: compose(poses, mount) for name, poses in stages.items()}, seconds)


def _track(
    log: ScanLog, scans: _Scans, mapper: GraphMapper, done: Callable[[int], None] | None
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Add all scans to a mapper; return the last key frame (n,) at each scan, and the pose (n, 3) in its frame."""
    frames, within = np.empty(len(log), np.int64), np.zeros((len(log), 3))
    doubted: list[tuple[int, Pose2D]] = []  # these scans belong to the part that begins, if the robot is lost
    reset = resets(log.stamps, log.odometry)
    for number, odometry in enumerate(log.odometry.tolist()):
        if reset[number]:
            mapper.rebase(Pose2D(*odometry))
        found = mapper.add(scans[number], Pose2D(*odometry))
        doubted = [*doubted, (number, found.pose)] if found.is_doubted or found.is_lost else []
        for at, pose in doubted if found.is_lost else [(number, found.pose)]:
            frame = Pose2D(*mapper.key_frames.poses[found.key_frame].tolist())
            frames[at], within[at] = found.key_frame, frame.inverse() @ pose
        if found.is_key:
            within[number] = 0.0
        if done is not None:
            done(number + 1)
    return frames, within


def _tracked_frames(mapper: GraphMapper) -> NDArray[np.float64]:
    """Return the poses (k, 3) of the key frames by tracking alone, without closures."""
    poses = [Pose2D(*mapper.key_frames.poses[0].tolist())]
    for step in np.array(mapper.steps[1:]).tolist():
        poses.append(poses[-1] @ Pose2D(*step))
    return np.array(poses)


def _polished(poses: NDArray[np.float64], scans: _Scans, key_frames: KeyFrames) -> NDArray[np.float64]:
    polisher = ScanPolisher(key_frames, key_frames.poses, poses)
    return np.array([polisher.polish(number, scans[number]) for number in range(len(poses))])
