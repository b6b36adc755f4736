"""Node ``leg_detector``: finds people in the scans of the robot's lasers, for robots without a depth camera."""

import math
from typing import ClassVar

import numpy as np

from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import SensorView
from ppaas.messages.people_msgs import PositionMeasurement, PositionMeasurementArray
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.base import Context, Demands, Node, Payload, Topic
from ppaas.nodes.frames import FrameListener, FrameNames
from ppaas.nodes.message_checks import expect
from ppaas.nodes.other_robots import OTHERS_FRESH, others_of
from ppaas.nodes.robot_scans import RobotScan, ScanReader, WaitingScans
from ppaas.nodes.topics import LEG_MEASUREMENTS, LEG_VIEW, ROBOTS, SCAN, SCAN_RATE, TF, TF_STATIC
from ppaas.perception.legs.detector import LegDetection, LegDetector, MapInFrame
from ppaas.perception.legs.parameters import LegDetectorParameters

MOST_LASERS = 8
"""Largest number of lasers of a robot, by the frames of their scans."""


WIDEST_SPACING = 0.07
"""Distance between two beams up to which few legs are missed [m]."""


ROBOT = 0.35
"""Distance from another robot within which a detection is that robot [m]."""


class LegDetectorNode(Node):
    """Subscribes to scans, ``tf`` and ``robots``; publishes ``leg_tracker_measurements`` and ``leg_detector/view``.

    Scans wait until odometry has reached their stamps. Measurements have the stamp of their scan and are in the robot's
    frame. If the robot is localized on a published map, hits on what is in the map are left out, and so are the other
    robots on it.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : LegDetectorParameters
    layers : MapLayers, optional
        The map; without one, a robot that makes it knows nothing of what stands around.
    names : FrameNames, optional
        Names of the robot's frames.
    """

    name: ClassVar[str] = "leg_detector"
    demands: ClassVar[Demands] = Demands(0.1, rates={SCAN.name: SCAN_RATE})
    subscribes: ClassVar[tuple[Topic, ...]] = (SCAN, TF, TF_STATIC, ROBOTS)
    publishes: ClassVar[tuple[Topic, ...]] = (LEG_MEASUREMENTS, LEG_VIEW)

    def __init__(
        self,
        context: Context,
        parameters: LegDetectorParameters,
        layers: MapLayers | None = None,
        names: FrameNames | None = None,
    ) -> None:
        super().__init__(context)
        self._parameters, self._layers = parameters, layers if parameters.use_map else None
        self._frames = FrameListener(names)
        self._scans, self._waiting = ScanReader(self._frames), WaitingScans()
        self._detectors: dict[str, LegDetector] = {}
        self._view: SensorView | None = None
        self._robots: tuple[MovingObstacle, ...] = ()
        self._robots_at = -math.inf

    def use_layers(self, layers: MapLayers) -> None:
        """Replace the map by another in the same frame."""
        if self._layers is not None:
            self._layers = layers

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a scan, transforms, or the states of the other robots on the map.

        Raises
        ------
        InvalidInput
            A number is not finite, or the angles are not a scan's.
        TransformError
            The frame of the scan is unknown, or a transform is invalid.
        """
        if topic == SCAN.name:
            read = self._scans.read(expect(message, LaserScan), self.context.elapsed())
            self._waiting.add(read, self._frames.newest())
            self._publish_view(read)
        elif topic == ROBOTS.name:
            self._robots = others_of(expect(message, RobotStates), 0.0)
            self._robots_at = self.context.elapsed()
        else:
            self._frames.hear(topic, expect(message, TFMessage), self.context.elapsed(), self.context.now())
        errors = self._waiting.process(self._frames.newest(), self.context.elapsed(), self._detect)
        if errors:
            raise errors[-1]

    def _detect(self, scan: RobotScan, stamp: float) -> None:
        detector = self._detector_of(scan.frame)
        if detector is None:
            return
        robot = self._frames.odometry(stamp)
        reading = LaserReading.of(scan.scan, robot @ scan.laser)
        known = self._map(robot, stamp)
        found = detector.detect(reading, stamp, known)
        if known is not None:
            found = [each for each in found if not self._is_robot(known.pose @ Pose2D(each.x, each.y))]
        header = Header(stamp=scan.scan.header.stamp if scan.stamp else Time.of(stamp), frame_id=self._frames.base)
        inverse = robot.inverse()
        people = [_message(header, number, each, inverse) for number, each in enumerate(found)]
        self.context.publish(LEG_MEASUREMENTS.name, PositionMeasurementArray(header, people))

    def _detector_of(self, frame: str) -> LegDetector | None:
        if frame not in self._detectors and len(self._detectors) < MOST_LASERS:
            self._detectors[frame] = LegDetector(self._parameters)
        return self._detectors.get(frame)

    def _is_robot(self, place: Pose2D) -> bool:
        """Return whether another robot is at a place on the map."""
        age = self.context.elapsed() - self._robots_at
        now = [robot.after(age) for robot in self._robots] if age <= OTHERS_FRESH else []
        return any(math.hypot(robot.x - place.x, robot.y - place.y) < ROBOT for robot in now)

    def _map(self, robot: Pose2D, stamp: float) -> MapInFrame | None:
        """Return the map in the frame of the odometry; None if the robot's place on it is not known at that time."""
        if self._layers is None:
            return None
        try:
            return MapInFrame(self._layers, self._frames.in_map(stamp) @ robot.inverse())
        except TransformError:
            return None

    def _publish_view(self, read: RobotScan) -> None:
        """Publish where this laser sees people, if that has changed; farther away it misses some."""
        scan, own = read.scan, self._parameters
        angles = scan.angle_min + scan.angle_increment * np.array((0, len(scan.ranges) - 1))
        first, last = angles.tolist()
        view = SensorView(
            x=read.laser.x,
            y=read.laser.y,
            yaw=Pose2D(0.0, 0.0, read.laser.theta + 0.5 * (first + last)).theta,
            field_of_view=min(abs(last - first) + abs(scan.angle_increment), 2.0 * math.pi),
            range_min=max(own.min_range, scan.range_min),
            range_max=min(own.max_range, scan.range_max, WIDEST_SPACING / (abs(scan.angle_increment) or 1.0)),
        )
        if view != self._view:
            self._view = view
            self.context.publish(LEG_VIEW.name, view)


def _message(header: Header, number: int, found: LegDetection, to_base: Pose2D) -> PositionMeasurement:
    place = to_base @ Pose2D(found.x, found.y)
    variance = found.sigma**2
    return PositionMeasurement(
        header, LegDetectorNode.name, str(number), Point(place.x, place.y), found.score,
        [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, 1.0], int(found.may_begin),
    )  # fmt: skip
