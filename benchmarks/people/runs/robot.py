"""Robot of the people bench: its simulated body, its clone with the nodes for people, and its patrol."""

from collections.abc import Callable
from typing import Any

from benchmarks.navigation.goals.clone import MODEL, ClonedRobot, InProcessClone
from benchmarks.people.runs.job import Detections
from ppaas.clone.plugins import DEFAULT_CONTROLLER
from ppaas.costmap.map_layers import MapLayers
from ppaas.messages.people_coordination import PeopleReport, PeopleState, SensorView
from ppaas.messages.people_msgs import PositionMeasurementArray
from ppaas.nodes import topics
from ppaas.nodes.base import Payload
from robots.demo.contact_referee import Referee
from robots.demo.people_patrol import is_wanted
from robots.sim.robot import SimulatedRobot
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World

__all__ = ["MODEL", "NODES", "PeopleRobot"]

NODES: dict[Detections, dict[str, Any]] = {
    "camera": {"torso_detector": {}, "follow_person": {}},
    "laser": {"leg_detector": {}, "follow_person": {}},
    "truth": {"people_tracker": {}, "follow_person": {}},
}
"""Parameters of a robot for each kind of detections."""


class PeopleRobot(ClonedRobot):
    """One robot.

    Parameters
    ----------
    world : World
    number : int
        Number of the robot in the world; its id is ``r`` and this number.
    layers : MapLayers
    detections : str
        One of `benchmarks.people.runs.job.DETECTIONS`.
    report : callable
        Called with each report of its people tracker.

    Attributes
    ----------
    id : str
    body : SimulatedRobot
    clone : InProcessClone
    referee : Referee
    """

    def __init__(
        self,
        world: World,
        number: int,
        layers: MapLayers,
        *,
        detections: Detections,
        report: Callable[[PeopleReport], None],
    ) -> None:
        self.id = f"r{number}"
        self._report = report
        body: SimulatedRobot = world.robots[number]
        parameters = {**NODES[detections], "amcl": {"seed": number}}
        clone = InProcessClone(layers, body.base.pose, DEFAULT_CONTROLLER, parameters, world.stamp, robot=self.id)
        super().__init__(world, body, clone)
        self.clone.graph.tap(topics.PEOPLE_REPORT.name, self._hear)
        camera = self.body.model.camera
        if camera is not None:
            self.clone.graph.inject(topics.TF_STATIC.name, camera.transforms(self.body.model.base_frame))
        self.referee = Referee(world, self.body)
        self.referee.begin()

    def image(self) -> None:
        """Pass a depth image to the clone."""
        self.clone.graph.inject(topics.DEPTH_CAMERA_INFO.name, self.body.camera_info())
        self.clone.graph.inject(topics.DEPTH_IMAGE.name, self.body.depth_image())

    def use_view(self, view: SensorView) -> None:
        """Pass the view of the detector that `use_measurements` stands for to the clone."""
        self.clone.graph.inject(topics.TORSO_VIEW.name, view)

    def use_measurements(self, measurements: PositionMeasurementArray) -> None:
        """Pass measurements to the clone in place of those of its detector."""
        self.clone.graph.inject(topics.TORSO_MEASUREMENTS.name, measurements)

    def take_state(self, state: PeopleState) -> None:
        """Pass the state of the coordinator to the clone."""
        self.clone.graph.inject(topics.PEOPLE_STATE.name, state)

    def _hear(self, _topic: str, message: Payload) -> None:
        if isinstance(message, PeopleReport):
            self._report(message)


# -- patrol ------------------------------------------------------------------------------------------------------------

IDLE = 5.0
"""Time without people and orders after which a robot is sent to another place [s]."""
AWAY = 5.0
"""Smallest distance to that place if the map is large enough [m]."""


class Patrol:
    """Sends a robot to random places until it sees a person, and again after that.

    A robot that has a goal of a user is not free to follow anybody, so the goal is cancelled then.

    Parameters
    ----------
    robot : PeopleRobot
    ways : ShortestPaths
        Places for robots.
    """

    def __init__(self, robot: PeopleRobot, ways: ShortestPaths) -> None:
        self._robot, self._ways = robot, ways
        self._idle_since = 0.0
        self._driving = False

    def take(self, state: PeopleState, now: float) -> None:
        """Begin or end the way to a place, by the state of the coordinator at a time [s]."""
        clone = self._robot.clone
        if is_wanted(self._robot.id, state):
            # This cancels all goals, which pauses following; a patrol that has just arrived has nothing to cancel.
            if self._driving and clone.end is None:
                clone.cancel()
            self._driving, self._idle_since = False, now
        elif self._driving and clone.end is not None:
            self._driving, self._idle_since = False, now
        elif not self._driving and now - self._idle_since >= IDLE:
            self._driving = True
            clone.send_to(self._ways.away_from(self._robot.body.base.pose, AWAY))
