"""Scene of a run: the simulated world with its mirrors, the robots with their clones, their coordinator, the truth."""

import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.people.runs.faults import BEGIN, DOUBTFUL, MIRRORS, ROBOT, fault_of
from benchmarks.people.runs.group import CoordinatedGroup
from benchmarks.people.runs.job import PeopleJob
from benchmarks.people.runs.robot import MODEL, Patrol, PeopleRobot
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.raycast import cast_rays
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.people_coordination import PeopleReport, PeopleState, SensorView
from ppaas.messages.people_msgs import PositionMeasurement, PositionMeasurementArray
from ppaas.robot_model.known_models import robot_model
from robots.demo.people_score import HALF, Truth
from robots.demo.people_world import build_world, present, visible_shares
from robots.sim.bodies.furniture import mirror
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.driver import FixedRate
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World

WIDTH = 1.2
"""Width of a mirror [m]."""
NEAREST, FARTHEST = 0.6, 4.0
"""Distance to a wall at which a place for a mirror is looked for [m]."""
TRIES = 50
"""Number of places examined for each mirror."""
GAP = 0.03
"""Distance of a mirror from its wall [m]."""


def hang_mirrors(world: World, ways: ShortestPaths, number: int) -> int:
    """Hang mirrors on straight walls that face places where people walk; return how many found a wall.

    Parameters
    ----------
    world : World
    ways : ShortestPaths
        Source of random places.
    number : int
        Number of mirrors.
    """
    hung = 0
    for _ in range(number * TRIES):
        if hung == number:
            break
        place = _on_wall(world, ways.anywhere())
        if place is not None:
            world.add_furniture(mirror(place, WIDTH, 0.2, 2.0))
            hung += 1
    return hung


def _on_wall(world: World, here: Pose2D) -> Pose2D | None:
    """Return the pose of a mirror on the wall that one of the axes of the map meets from here; None without one."""
    info = world.grid.info
    heading = info.origin.theta + 0.5 * math.pi * round(here.theta / (0.5 * math.pi))
    eye = Pose2D(here.x, here.y, heading)
    sides = [eye @ Pose2D(0.0, offset) for offset in np.linspace(-0.5 * WIDTH, 0.5 * WIDTH, 7).tolist()]
    ranges = np.array([cast_rays(world.occupied, info, side, np.zeros(1), FARTHEST)[0] for side in sides])
    if not (np.isfinite(ranges).all() and ranges.min() >= NEAREST and np.ptp(ranges) < 0.5 * info.resolution):
        return None
    # The front of a mirror faces the room.
    return eye @ Pose2D(float(ranges.min()) - GAP, 0.0, math.pi)


Floats = NDArray[np.float64]

RATE = 5.0
"""Rate of depth images, of the coordinator, and of the score [Hz]."""
TRUE_VIEW = SensorView(0.0, 0.0, 0.0, float(np.radians(57.0)), 0.5, 5.0)
"""View of the detector that true positions stand for."""
MIRRORS_ON_WALLS = 8
"""Number of mirrors in a run with them."""
DOUBT = 0.3
"""Largest share of a torso in the view of a robot that has a fault: its people are at the edge, and not in view."""


class PeopleScene:
    """World, robots and coordinator, step by step.

    Parameters
    ----------
    job : PeopleJob

    Attributes
    ----------
    state : PeopleState or None
        Last state of the coordinator.
    truth : Truth or None
        Truth at that time.
    """

    def __init__(self, job: PeopleJob) -> None:
        self.job = job
        rng = np.random.default_rng((job.seed, job.robots, job.people))
        camera = DepthCameraModel(*job.size) if job.detections == "camera" else None
        self.world, keepout, self._surroundings, ways = build_world(job.grid, job.robots, job.people, camera, rng)
        if job.fault == MIRRORS:
            hang_mirrors(self.world, ways, MIRRORS_ON_WALLS)
        layers = build_layers(job.grid, robot_radius=robot_model(MODEL).robot_radius, keepout=keepout)
        self.group = CoordinatedGroup(layers.costmap, job.policy)
        self.robots = [
            PeopleRobot(self.world, number, layers, detections=job.detections, report=self._report)
            for number in range(job.robots)
        ]
        self.state: PeopleState | None = None
        self.truth: Truth | None = None
        self._patrols = [Patrol(robot, ways) for robot in self.robots]
        self._views = {robot.id: [TRUE_VIEW] for robot in self.robots}
        if job.detections == "truth":
            for robot in self.robots:
                robot.use_view(TRUE_VIEW)
        self._fault = fault_of(job.fault)
        self._rng = rng
        self._tick = FixedRate(RATE, 0.0)

    def step(self) -> bool:
        """Simulate a step of the world; return whether `state` and `truth` are new."""
        for robot in self.robots:
            robot.step()
        due = self._tick.take(self.world.time())
        if due:
            self._sense()
            self._coordinate()
        self.world.step()
        for robot in self.robots:
            robot.referee.look()
        return due

    def contacts(self) -> int:
        """Return the number of contacts that robots caused so far, with people, walls and each other."""
        touches = [robot.referee.touches for robot in self.robots]
        return sum(each.walls + each.caused for each in touches) + self.world.contacts.robot_contacts.total() // 2

    def _report(self, report: PeopleReport) -> None:
        if report.views:
            self._views[report.robot] = report.views
        for arriving in self._fault(report, self.world.time()):
            self.group.report(arriving, self.world.stamp())

    def _sense(self) -> None:
        """Give each robot an image, or what stands for it, and note the truth at this time."""
        people = present(self.world)
        best = np.zeros(len(people))
        for robot in self.robots:
            shares = visible_shares(self._surroundings, robot.body.base.pose, self._views[robot.id], people)
            best = np.maximum(best, np.minimum(shares, DOUBT) if self._is_doubtful(robot) else shares)
            if self.job.detections == "camera":
                robot.image()
            elif self.job.detections == "truth":
                pose, stamp = robot.body.base.pose, self.world.stamp()
                robot.use_measurements(measurements(stamp, pose, people, shares, self._rng))
        places = {robot.id: robot.body.base.pose[:2] for robot in self.robots}
        self.truth = Truth(self.world.time(), people, best, places)

    def _is_doubtful(self, robot: PeopleRobot) -> bool:
        """Return whether a fault makes it uncertain that the people count whom only this robot sees."""
        return self.job.fault in DOUBTFUL and robot.id == ROBOT and self.world.time() >= BEGIN

    def _coordinate(self) -> None:
        self.state = self.group.step(self.world.stamp())
        for robot, patrol in zip(self.robots, self._patrols, strict=True):
            robot.take_state(self.state)
            patrol.take(self.state, self.world.time())


# -- detections from the truth, with noise, in place of a detector -----------------------------------------------------

NAME = "truth"
"""Name of the detector in its measurements."""

BASE_LINK = "base_link"
MISSED = 0.02
"""Share of detections that are missed."""
SIGMA, SIGMA_DEPTH = 0.03, 1.425e-3
"""Standard deviation of a position [m], and its growth with the square of the distance [1/m], as of a Kinect."""
TORSO_HEIGHT = 1.2
"""Height of the measured points [m]."""


def measurements(
    stamp: float, robot: Pose2D, people: Floats, shares: Floats, rng: np.random.Generator
) -> PositionMeasurementArray:
    """Return measurements of the people that a robot has in view, in its base frame.

    Parameters
    ----------
    stamp : float
        [s since the epoch].
    robot : Pose2D
        True pose of the robot.
    people : (n, 2) array
        True positions of all people [m].
    shares : (n,) array
        Share of each torso that the robot has in view.
    rng : numpy.random.Generator
        Random source of the noise and of the missed people.
    """
    header = Header(stamp=Time.of(stamp), frame_id=BASE_LINK)
    seen = np.flatnonzero((shares >= HALF) & (rng.random(len(people)) >= MISSED))
    return PositionMeasurementArray(header, [_measurement(header, robot, people[each], rng) for each in seen])


def _measurement(header: Header, robot: Pose2D, person: Floats, rng: np.random.Generator) -> PositionMeasurement:
    x, y, _ = robot.inverse() @ Pose2D(*person.tolist())
    sigma = SIGMA + SIGMA_DEPTH * (x * x + y * y)
    x, y = (rng.normal((x, y), sigma)).tolist()
    variance = sigma * sigma
    covariance = [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
    return PositionMeasurement(header, NAME, "", Point(x, y, TORSO_HEIGHT), 0.9, covariance)
