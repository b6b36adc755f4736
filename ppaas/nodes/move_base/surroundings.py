"""Surroundings of a robot: its pose, its scans, people and other robots, and the local costmap."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ppaas.controllers.base import Velocity
from ppaas.controllers.loop_delay import LoopDelay
from ppaas.costmap.causes import Body, Causes
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.moving_obstacles import Disc, MovingObstacle, swept_discs
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.costmap.obstacle_memory import ObstacleMemory
from ppaas.costmap.social_layer import PersonNearby
from ppaas.errors import InvalidInput, PPaaSError, TransformError
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.base.std_msgs import String
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.people_coordination import PeopleState
from ppaas.messages.people_msgs import People
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.frames import MAP, FrameListener, FrameNames
from ppaas.nodes.message_checks import finite_pose
from ppaas.nodes.move_base.people import RecentPeople
from ppaas.nodes.move_base.pose_watch import PoseWatch
from ppaas.nodes.other_robots import OTHERS_FRESH, OTHERS_MARGIN, others_of
from ppaas.nodes.robot_scans import RobotScan, ScanReader, WaitingScans
from ppaas.people.following.places import Places
from ppaas.perception.tracking import MovingObjects
from ppaas.recoveries.base import AffectedMaps

LAST = 1.0
"""Age up to which the last scan of a laser is marked again after obstacles were cleared [s]."""

JUMP, JUMP_TURN = 0.3, 0.15
"""Correction of the pose by localization beyond which observed obstacles are cleared [m, rad].

They are elsewhere after a loop closure of a map that the robot makes, or when a lost robot was found."""

JUMP_TIME = 1.0
"""Time within which it is corrected so: between two transforms of localization, poses are interpolated [s]."""

SHIFT = 0.1
"""Distance that the robot must move before the local costmap is updated without new sensor data [m]."""

AHEAD = 2.0
"""Time for which the predicted paths of movers are marked in the costmap, if the controller does not predict [s]."""

LEGS = 0.3
"""Distance from the position of a person within which the laser sees the legs [m]."""


class Surroundings:
    """Maintains the local costmap of a robot in the map frame.

    Parameters
    ----------
    costmap : LocalCostmap
        Window around the robot.
    memory : ObstacleMemory
        Obstacles outside the window.
    robot_radius : float
        Radius of this robot, and of others that do not report theirs [m].
    people : RecentPeople
        People around the robot.
    moving : MovingObjects
        Moving objects that the laser sees.
    tolerance : float
        Largest age of localization and odometry [s].
    names : FrameNames, optional
        Names of the robot's frames.

    Attributes
    ----------
    frames : FrameListener
        Frames of the robot.
    velocity : Velocity
        Velocity by the last odometry.
    loop : LoopDelay
        Delay from a command to the odometry that shows it.
    costs : Costmap or None
        The local costmap.
    """

    def __init__(
        self,
        costmap: LocalCostmap,
        memory: ObstacleMemory,
        robot_radius: float,
        *,
        people: RecentPeople,
        moving: MovingObjects,
        tolerance: float,
        names: FrameNames | None = None,
    ) -> None:
        self.frames = FrameListener(names)
        self._watch = PoseWatch(self.frames, tolerance)
        self.velocity = Velocity()
        self.loop = LoopDelay()
        self._local = costmap
        self._memory = memory
        self.costs: Costmap | None = None
        self._robot_radius = robot_radius
        self._scans = ScanReader(self.frames)
        self._waiting = WaitingScans()
        self._last: dict[str, tuple[float, LaserReading]] = {}
        self._people = people
        self._moving = moving
        self._looked: tuple[Pose2D, tuple[Disc, ...], tuple[PersonNearby, ...]] | None = None
        self._correction: tuple[float, Pose2D] | None = None
        self._in_odom: dict[str, Pose2D] = {}
        self._others: tuple[MovingObstacle, ...] = ()
        self._others_at = float("-inf")
        self._names: tuple[str, ...] = ()
        self._nearby: tuple[Body, ...] = ()
        self._keep_away: tuple[bool, ...] = ()
        self._trusts_grants = False
        self._ahead = AHEAD

    def take(
        self,
        topic: str,
        message: LaserScan | Odometry | TFMessage | RobotStates | People | PeopleState | String,
        now: float,
        stamp: float | None = None,
    ) -> None:
        """Take what the robot, localization or another robot says at ``now`` [s]; ``stamp`` replaces zero stamps [s].

        Raises
        ------
        InvalidInput
            A number is not finite, numbers of parts differ, there are too many people, or a laser is tilted too much.
        TransformError
            A frame is unknown.
        """
        match message:
            case LaserScan():
                self._take_scan(message, now)
            case Odometry():
                self._take_odometry(message, now)
            case TFMessage():
                self.frames.hear(topic, message, now, stamp)
            case RobotStates():
                self._take_robots(message, now)
            case People():
                self._people.take(message, self.frames.tree, now)
            case PeopleState():
                self._people.take_state(message, now)
            case String():
                self._watch.localization = message.data

    def _take_odometry(self, odometry: Odometry, now: float) -> None:
        """Take the velocity, if the message is valid."""
        twist = odometry.twist.twist
        try:
            finite_pose(odometry.pose.pose, "odometry")
            if not math.isfinite(twist.linear.x + twist.angular.z):
                raise InvalidInput("the twist of odometry must be finite")
        except PPaaSError as error:
            self._watch.odometry_refused(error)
            raise
        self.velocity = Velocity(twist.linear.x, twist.angular.z)
        self.loop.measure(now, self.velocity, odometry.header.stamp.seconds())
        self._watch.odometry_came(now, odometry.header.frame_id, odometry.child_frame_id)

    def _take_scan(self, scan: LaserScan, now: float) -> None:
        """Store a scan for the next update."""
        try:
            read = self._scans.read(scan, now)
        except PPaaSError as error:
            self._watch.scan_refused(error)
            raise
        self._watch.scan_came(now)
        self._waiting.add(read, self.frames.newest())

    def _take_robots(self, message: RobotStates, now: float) -> None:
        """Store the poses and velocities of the other robots in the map frame."""
        self._others = others_of(message, self._robot_radius)
        self._keep_away = tuple(message.granted) or (False,) * len(self._others)
        self._names = tuple(message.names) or ("",) * len(self._others)
        self._others_at = now

    def trust_grants(self, trusts: bool) -> None:
        """Set whether to avoid no robots that drive by grants of the same traffic node: they keep out of its way."""
        self._trusts_grants = trusts

    def expect_no_scans(self) -> None:
        """Take it that the robot localizes itself, for the text that says what is missing."""
        self._watch.expects_scans = False

    def mark_ahead(self, wanted: bool) -> None:
        """Set whether the local costmap also contains the predicted positions of movers."""
        self._ahead = AHEAD if wanted else 0.0

    def movers(self, pose: Pose2D, now: float) -> tuple[MovingObstacle, ...]:
        """Return nearby robots and all other movers, at their predicted current positions."""
        robots = tuple(mover.after(now - self._others_at) for mover in self._near(pose, now))
        return robots + self.walkers(pose, now)

    def walkers(self, pose: Pose2D, now: float) -> tuple[MovingObstacle, ...]:
        """Return the moving objects that the laser sees, without robots, and people, at their predicted positions.

        People behind walls of the map are left out: they cannot walk up to the robot, whose laser does not see them.
        """
        seen = tuple(mover.after(now - self._moving.at) for mover in self._seen_moving(now))
        return seen + tuple(body for body in self._people.bodies(now) if self._may_meet(pose, body))

    def _may_meet(self, pose: Pose2D, body: MovingObstacle) -> bool:
        reach = self._local.reach + OTHERS_MARGIN
        near = math.hypot(body.x - pose.x, body.y - pose.y) <= reach
        return near and Places(self.layers).sees((pose.x, pose.y), (body.x, body.y))

    def pose(self, now: float) -> Pose2D:
        """Return the pose of the robot in the map frame.

        Raises
        ------
        TransformError
            Odometry or localization is missing or too old; the text says which.
        """
        self._watch.check(now)
        return self.frames.in_map()

    def look_around(self, pose: Pose2D, now: float) -> Costmap:
        """Update the local costmap and return it; the last one is returned if nothing has changed."""
        own = pose.x, pose.y, self._robot_radius
        self._clear_after_jump(pose, now)
        readings = self._readings(now)
        others = tuple(swept_discs((*self._near(pose, now), *self._seen_moving(now)), self._ahead, own))
        people_near = self._bodies(pose, now)
        self._nearby = (*self._named(now), *(Body("person", *body) for body in people_near))
        others += people_near
        people, between = self._people.now(now), self._people.between(now)
        if self.costs is None or readings or self._is_elsewhere(pose, others, people + between):
            self._looked = pose, others, people + between
            for reading in readings[1:]:
                self._local.see(pose, reading)
            self.costs = self._local.update(pose, readings[0] if readings else None, others, people, between)
            self._memory.update(self._local.obstacles, others)
        return self.costs

    def _clear_after_jump(self, pose: Pose2D, now: float) -> None:
        """Clear the observed obstacles if localization has corrected the pose by much within about `JUMP_TIME`.

        The last scans, which are marked again, are moved with the robot.
        """
        odom, last = self.frames.odometry(), self._correction
        if last is None or now - last[0] > JUMP_TIME:
            self._correction = now, pose @ odom.inverse()
        expected = pose if last is None else last[1] @ odom
        if expected.distance_to(pose) > JUMP or abs(wrap_angle(expected.theta - pose.theta)) > JUMP_TURN:
            correction = pose @ odom.inverse()
            self._last = {
                frame: (at, replace(reading, origin=correction @ self._in_odom[frame]))
                for frame, (at, reading) in self._last.items()
            }
            self._correction = now, correction
            self.clear()

    def _is_elsewhere(self, pose: Pose2D, others: tuple[Disc, ...], people: tuple[PersonNearby, ...]) -> bool:
        """Return whether the robot, another robot or a person has moved since the local costmap was updated."""
        return (
            self._looked is None or self._looked[1:] != (others, people) or self._looked[0].distance_to(pose) >= SHIFT
        )

    @property
    def fits(self) -> Callable[[Pose2D], bool] | None:
        """Check of the outline of a robot that is longer than wide, at a pose in the map frame; None for others."""
        return self._local.fits if self._local.has_outline else None

    @property
    def layers(self) -> MapLayers:
        """Layers of the map."""
        return self._local.layers

    @property
    def static(self) -> Costmap:
        """Costmap of the map alone."""
        return self._local.layers.costmap

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map; the next update marks the last scans again."""
        self._memory.use_layers(layers)
        self._local.use_layers(layers)
        self._moving.use_layers(layers)
        self._looked = None

    def seen(self) -> Costmap:
        """Return the costmap of the map with all observed obstacles; `static` itself if there are none."""
        return self.overlay(self.static)

    def overlay(self, costmap: Costmap) -> Costmap:
        """Return a costmap of the whole map with all observed obstacles, or the given one if there are none."""
        current = self._memory.overlay(self._local.overlay(costmap))
        return current if current is costmap else replace(current, causes=self._causes())

    def way_out(self) -> Costmap | None:
        """Return the costs by which the robot leaves a keep-out zone that it is in, or None if it is in none."""
        costs = self._local.way_out
        return None if costs is None else self.overlay(costs)

    def _causes(self) -> Causes:
        """Return what makes places lethal now."""
        memory = self.layers.grid.info.to_world(self._memory.cells).reshape(-1, 2)
        return Causes(self._local.map_layers, self._nearby, np.concatenate((self._local.seen_points, memory)))

    def clear(self, around: Pose2D | None = None, beyond: float = 0.0, affected_maps: AffectedMaps = "both") -> None:
        """Clear the observed obstacles, or only those farther than ``beyond`` [m] from a pose.

        ``affected_maps`` selects the window of the local costmap, the memory of obstacles across the map, or both. The
        next update marks the last scans again.
        """
        if affected_maps != "local":
            self._memory.clear(around, beyond)
        if affected_maps != "global":
            self._local.clear(around, beyond)
        self._looked = None

    def _readings(self, now: float) -> list[LaserReading]:
        """Return, once each, the newest scan of each laser whose time the transforms have reached.

        After obstacles were cleared, the last scan of each laser is returned again, as costmap_2d marks its last
        observations again: a plan before the next scan must not lead through what the robot has just seen.
        """
        newest = self.frames.tree.common_time(MAP, self.frames.base)
        ready = {scan.frame: scan for scan in self._waiting.ready(newest, now)}
        read = {frame: (scan.at, reading) for frame, scan in ready.items()
                if (reading := self._reading(scan, now)) is not None}  # fmt: skip
        self._last = {frame: last for frame, last in self._last.items() if now - last[0] <= LAST} | read
        self._in_odom = {frame: self._in_odom[frame] for frame in self._last}
        return [reading for _, reading in (self._last if self._looked is None else read).values()]

    def _reading(self, scan: RobotScan, now: float) -> LaserReading | None:
        try:
            origin = self.frames.in_map(scan.stamp or None) @ scan.laser
            self._in_odom[scan.frame] = self.frames.odometry(scan.stamp or None) @ scan.laser
        except TransformError:
            return None  # it is older than the transforms
        reading = LaserReading.of(scan.scan, origin)
        self._moving.see(reading, scan.stamp or now, now)
        # Beams without a hit may not clear cells, so what moving people have left is cleared here.
        self._local.free(self._moving.left())
        return reading

    def _seen_moving(self, now: float) -> list[MovingObstacle]:
        """Return the moving objects that the laser saw, without other robots, which report their own state."""
        seen = self._moving.now(now)
        robots = self._others if now - self._others_at <= OTHERS_FRESH else ()
        return [
            mover
            for mover in seen
            if all(math.hypot(mover.x - robot.x, mover.y - robot.y) > mover.radius + robot.radius for robot in robots)
        ]

    def _bodies(self, pose: Pose2D, now: float) -> tuple[Disc, ...]:
        """Return the bodies of people in the window, without those that touch the robot: it must be able to leave.

        People whom no camera sees any more are there as long as the laser sees legs where they stood.
        """

        def is_near(body: MovingObstacle) -> bool:
            apart = math.hypot(body.x - pose.x, body.y - pose.y)
            return body.radius + self._robot_radius < apart < self._local.reach + body.radius

        seen = [body for body in self._people.bodies(now) if is_near(body)]
        near = filter(is_near, self._people.unseen(now))
        legs = [body for body in near if self._local.sees_at(body.x, body.y, LEGS)]
        return tuple((body.x, body.y, body.radius) for body in seen + legs)

    def _named(self, now: float) -> list[Body]:
        """Return the other robots with their names, for texts."""
        robots = self._others if now - self._others_at <= OTHERS_FRESH else ()
        return [
            Body("robot", each.x, each.y, each.radius, name) for each, name in zip(robots, self._names, strict=False)
        ]

    def _near(self, pose: Pose2D, now: float) -> list[MovingObstacle]:
        """Return the other robots near the window, from the last message, unless that is too old."""
        if now - self._others_at > OTHERS_FRESH:
            return []
        reach = self._local.reach + self._robot_radius + OTHERS_MARGIN
        trusted = self._keep_away if self._trusts_grants else (False,) * len(self._others)
        others = [other for other, keeps_away in zip(self._others, trusted, strict=True) if not keeps_away]
        distances = [math.hypot(other.x - pose.x, other.y - pose.y) for other in others]
        # A robot at this robot's own position is its echo.
        return [other for other, far in zip(others, distances, strict=True) if self._robot_radius < far < reach]
