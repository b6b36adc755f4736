"""Scene of a run: the simulated world, the robots with their clones, their coordinator, and the truth."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.people.runs import true_detections
from benchmarks.people.runs.faults import BEGIN, DOUBTFUL, MIRRORS, ROBOT, fault_of
from benchmarks.people.runs.group import Group
from benchmarks.people.runs.job import PeopleJob
from benchmarks.people.runs.mirrors import hang_mirrors
from benchmarks.people.runs.patrol import Patrol
from benchmarks.people.runs.robot import MODEL, PeopleRobot
from ppaas.costmap.build_layers import build_layers
from ppaas.messages.people_coordination import PeopleReport, PeopleState, SensorView
from ppaas.robot_model.known_models import robot_model
from robots.demo.people_score import Truth
from robots.demo.people_visibility import visible_shares
from robots.demo.people_world import build_world, present
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.driver import Schedule

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
        self.group = Group(layers.costmap, job.policy)
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
        self._tick = Schedule(RATE, 0.0)

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
                robot.use_measurements(true_detections.measurements(stamp, pose, people, shares, self._rng))
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
