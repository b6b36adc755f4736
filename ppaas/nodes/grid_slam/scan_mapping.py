"""Scan mapping: tracks scans, closes loops in jobs, and publishes the map and the pose of the robot."""

import logging
from collections.abc import Callable
from functools import partial
from typing import Any

from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.live.refining_mapper import RefiningMapper
from ppaas.mapping.live.refining_work import RefinedMap
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.base import Context, Job
from ppaas.nodes.frames import FrameListener
from ppaas.nodes.grid_slam.laser import MappingLaser
from ppaas.nodes.grid_slam.logbook import Head
from ppaas.nodes.grid_slam.logged_map import LoggedMapNode
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.grid_slam.publishing import MapSaver, MapServices, PosePublisher
from ppaas.nodes.grid_slam.scan_intake import (
    OtherRobots,
    ScanIntake,
    StatusPublisher,
    blindness_status,
    lost_status,
    odometry_status,
)
from ppaas.nodes.jobs import LongWork
from ppaas.nodes.key_frame_path import KeyFramePublisher
from ppaas.nodes.robot_scans import RobotScan
from ppaas.nodes.scan_silence import SILENT

logger = logging.getLogger(__name__)

# -- jobs of ``grid_slam`` that search for loop closures, and thin and refine the map, one after the other -------------

IDLE = 10.0
"""Time without a key frame after which the robot is taken to stand, and its map is refined [s]."""

PERIOD = 1.0
"""Time between two checks whether the robot stands [s]."""


class ClosureJobs:
    """Does the work of a mapper in jobs and applies the results: no scan waits for it.

    Searches and thinnings are done at once, and refinements while the robot stands; one is cancelled by a key frame.

    Parameters
    ----------
    context : Context
        Of the node.
    current : callable
        Returns the mapper whose closures are searched for; what was found for another one is dropped.
    on_moved : callable
        Called with the motion of the robot's pose in the map frame, when key frames have moved.
    """

    def __init__(
        self, context: Context, current: Callable[[], LiveMapper | None], on_moved: Callable[[Pose2D], None]
    ) -> None:
        self._context, self._current, self._on_moved = context, current, on_moved
        self._changed_at = 0.0
        self._refining: Job | None = None

    def watch(self) -> None:
        """Refine the map from now on when the robot stands."""
        self._changed_at = self._context.elapsed()
        self._context.every(PERIOD, self._refine)

    def start(self) -> None:
        """Start the search that is due after a key frame, if there is one and none is running."""
        self._changed_at = self._context.elapsed()
        if self._refining is not None:
            self._refining.cancel()  # without effect if it has ended
            self._refining = None
        self._start_due()

    def _start_due(self) -> None:
        mapper = self._current()
        if mapper is not None and (work := mapper.next_work()) is not None:
            self._context.start(LongWork(work), partial(self._on_closed, mapper))

    def _refine(self) -> None:
        """Start the refinement that is due if the robot stands, and nothing else is."""
        mapper = self._current()
        if not isinstance(mapper, RefiningMapper) or self._context.elapsed() - self._changed_at < IDLE:
            return
        self._start_due()
        if (work := mapper.next_idle_work()) is not None:
            self._refining = self._context.start(LongWork(work), partial(self._on_refined, mapper))

    def _on_refined(self, mapper: RefiningMapper, result: RefinedMap | PPaaSError | None) -> None:
        if isinstance(result, PPaaSError):
            mapper.give_up()
        self._on_closed(mapper, result)

    def _on_closed(self, mapper: LiveMapper, result: Any) -> None:
        if mapper is not self._current():
            return  # the map was cleared meanwhile
        if isinstance(result, PPaaSError):
            logger.warning("a search for loop closures or redundant key frames, or a refinement, failed: %s", result)
            result = None
        motion = mapper.apply(result)
        if motion is not None:
            self._on_moved(motion)
        self._start_due()


# -- scan mapping ------------------------------------------------------------------------------------------------------

MAP_PERIOD = 1.0
"""Time between two publications of changes of the map [s]."""

Preparation = Callable[[], None]
"""Run in a job, such as the loading of kernels."""


class ScanMappingNode(LoggedMapNode):
    """Node that maps scans: they wait until kernels are loaded and a log is read, then each is tracked.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : GridSlamParameters
    save : callable, optional
        Saves a map for ``save_map``.
    prepare : callable, optional
        Run in a job before any scan is used.
    prepare_closures : callable, optional
        Run in a job once scans are used.
    """

    def __init__(
        self,
        context: Context,
        parameters: GridSlamParameters,
        save: MapSaver | None = None,
        prepare: Preparation | None = None,
        prepare_closures: Preparation | None = None,
    ) -> None:
        super().__init__(context, parameters)
        self._prepare, self._prepare_closures = prepare, prepare_closures
        self._frees, self._blindness = parameters.frees, ""
        self._frames, self._status = FrameListener(parameters.frames()), StatusPublisher(context)
        self._intake = ScanIntake(context, self._frames, parameters, self._status)
        self._maps = MapServices(context, parameters.map_update_interval, save)
        self._poses = PosePublisher(context, self._frames, parameters)
        self._key_frames, self._others = KeyFramePublisher(context, self._logbook.times), OtherRobots()
        self._before_odometry: Pose2D | None = None
        self._closures = ClosureJobs(context, lambda: self._mapper, self._on_moved)

    def start(self) -> None:
        """Publish changes of the map from now on, and load the kernels that scans need."""
        self.context.every(MAP_PERIOD, self._publish_map)
        self.context.every(0.5 * SILENT, self._report_silence)
        self._closures.watch()
        if (prepare := self._prepare) is not None:
            self.context.start(LongWork(lambda _cancelled: prepare()), self._on_prepared)

    def _on_prepared(self, outcome: PPaaSError | None) -> None:
        _warn_of(outcome)
        self._prepare = None
        self._begin()

    def _begin(self) -> None:
        """Use the scans that have waited, if nothing else is missing."""
        self._use_scans()
        if self._is_ready and (prepare := self._prepare_closures) is not None:
            self._prepare_closures = None
            self.context.start(LongWork(lambda _cancelled: prepare()), _warn_of)

    # -- scans ---------------------------------------------------------------------------------------------------------

    def _on_scan(self, message: LaserScan) -> None:
        try:
            self._intake.add(message, self._laser)
            errors = self._use_scans()
            if errors:
                raise errors[-1]
            if not self._is_ready:
                self._report_waiting()
        except PPaaSError as error:
            self._status.report(f"scans are refused: {error}")
            raise

    def _report_silence(self) -> None:
        """Report why no scan is used, unless it is reported already why scans are refused or wait."""
        reason = self._intake.silence.reason(self.context.elapsed())
        if reason and self._is_ready and not self._status.reported:
            self._status.report(reason)

    @property
    def _is_ready(self) -> bool:
        """Whether scans are used; until then they wait."""
        return self._prepare is None and self._restoration is None

    def _use_scans(self) -> list[PPaaSError]:
        """Use the scans that odometry has reached; return the errors of those that cannot be used."""
        return self._intake.process(self._process) if self._is_ready else []

    def _report_waiting(self) -> None:
        """Report why scans wait. If the robot has a map, it is where its odometry says."""
        newest = self._frames.newest()
        if newest is not None:
            self._status.report(self._problem())
            if self._restoration is not None or self._mapper is not None:
                self._poses.publish_transform(self._map_to_odom, newest)

    def _process(self, scan: RobotScan, stamp: float) -> None:
        odom, before = self._intake.odometry(scan, stamp)
        if before is not None:
            self._on_odometry_reset(before, odom)
        moment = scan.scan.header.stamp if scan.stamp else Time.of(stamp)
        if not self._paused and self._intake.is_due(stamp):
            self._track(scan, odom, stamp, moment)
        if self._mapper is not None:
            self._poses.publish_transform(self._map_to_odom, stamp)
        self._status.report(self._problem())

    def _problem(self) -> str:
        """Return the reason for which scans or parts of the map are left out now; empty if there is none."""
        if self._prepare is not None:
            return "mapping is being prepared: scans are used in a moment"
        if self._restoration is not None:
            return "the map is being restored: scans are used in a moment"
        if self._paused:
            return "mapping is paused: call 'pause' to resume it"
        problem = self._maps.problem or self._map_error or lost_status(self._mapper) or self._blindness
        return problem or odometry_status(self._frames)

    def _track(self, scan: RobotScan, odom: Pose2D, stamp: float, moment: Time) -> None:
        laser, mapper = self._started(scan)
        laser.check(scan)
        self._settle_mount(scan, laser, mapper)
        points = laser.points(scan, odom, stamp, frees=self._frees(scan.scan.range_max))
        expected = self._map_to_odom @ odom @ laser.geometry.mount
        self._blindness = "" if points.points.any() else blindness_status(scan.scan)
        if is_shared := self._is_shared(mapper):
            points = self._others.cut_from(points, expected, mapper.key_frames, self.context.elapsed())
        tracked = mapper.add(points, odom)
        if tracked.is_lost:
            logger.warning("the robot was carried away: it maps another part until it recognizes a place")
            self._maps.forget()
            self._key_frames.clear()
        robot = tracked.pose @ laser.geometry.mount.inverse()
        self._map_to_odom = robot @ odom.inverse()
        shared = self._others.frame if is_shared and not tracked.is_lost else None
        self._poses.publish(tracked, robot, moment, shared=shared)
        if tracked.is_key:
            self._key_frames.add(mapper.key_frames, stamp)
            self._closures.start()

    def _started(self, scan: RobotScan) -> tuple[MappingLaser, LiveMapper]:
        """Return the laser and the mapper, made for the first scan."""
        if self._laser is None or self._mapper is None:
            self._laser = MappingLaser.of(scan, self._front_end)
            self._mapper = self._new_mapper(self._laser)
            self._logbook.begin(self._laser.frame)
        return self._laser, self._mapper

    def _settle_mount(self, scan: RobotScan, laser: MappingLaser, mapper: LiveMapper) -> None:
        """Take the mount of the laser as soon as a transform says it, if it was only assumed."""
        if self._intake.scan_odometry.assumes(scan.frame):
            laser.is_assumed = True
        elif laser.is_assumed:
            laser.move(scan.laser)
            if len(mapper.key_frames):
                mapper.remount(scan.laser)
                self._map_to_odom = mapper.pose @ scan.laser.inverse() @ mapper.odometry.inverse()
                self._logbook.begin(laser.frame)  # it has the mount

    def _change_odometry(self, before: Pose2D) -> None:
        """Go on with odometry that a robot without any has now, as if it had not moved since the last scan."""
        odom = self._frames.odometry()
        self._on_odometry_reset(before, odom)
        self._intake.rebase(odom)
        if self._restoration is not None:
            self._before_odometry = before
        if self._mapper is not None or self._restoration is not None:
            self._poses.publish_start(self._map_to_odom)

    def restore(self, state: bytes) -> None:
        """Go on without odometry at once if the map was made so; otherwise as `LoggedMapNode.restore`."""
        super().restore(state)
        if isinstance(self._head, Head) and self._head.without_odometry:
            self._intake.scan_odometry.resume()

    @property
    def _is_without_odometry(self) -> bool:
        return self._intake.scan_odometry.is_active

    def _on_odometry_reset(self, before: Pose2D, odom: Pose2D) -> None:
        self._map_to_odom = self._map_to_odom @ before @ odom.inverse()
        if self._mapper is not None and self._laser is not None:
            self._mapper.rebase(odom)
            self._laser.forget_motion()

    # -- map -----------------------------------------------------------------------------------------------------------

    def _on_moved(self, motion: Pose2D) -> None:
        """Publish the map that loop closures have moved; ``tf`` changes with the next scan."""
        self._map_to_odom = motion @ self._map_to_odom
        self._publish_map()
        if self._mapper is not None:
            self._key_frames.publish(self._mapper.key_frames)

    def _publish_map(self) -> None:
        if self._mapper is not None:
            self._maps.publish(self._mapper)
            if self._maps.problem:
                self._status.report(self._maps.problem)

    def _is_shared(self, mapper: LiveMapper) -> bool:
        return mapper.parts.current == 0 and self._others.are_in(mapper.key_frames)

    def _restored(self, mapper: LiveMapper, *, shared: bool) -> None:
        before, self._before_odometry = self._before_odometry, None
        if before is not None:  # odometry came while the map was rebuilt
            self._on_odometry_reset(before, self._frames.odometry())
        if shared:
            self._others.use_frame_of(mapper.key_frames, self._frame_name(mapper))
        self._key_frames.publish(mapper.key_frames)

    def _ready(self) -> None:
        self._publish_map()
        self._begin()


def _warn_of(outcome: PPaaSError | None) -> None:
    if outcome is not None:
        logger.warning("kernels of mapping are loaded at their first call: %s", outcome)
