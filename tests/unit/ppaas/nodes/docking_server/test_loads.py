"""Robots that drive under a shelf, carry it away and set it down, in a simulated room on the clock of the test."""

import math

import numpy as np

from benchmarks.building.docking_scene import DockingNoise, DockingScene
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.footprints import Footprint
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Bool, String
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.nav2_servers import DockRobotActionGoal, DockRobotGoal, UndockRobotActionGoal
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.base import Payload
from ppaas.nodes.footprint.node import FootprintNode
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT
from robots.sim.docks.shelf import SimulatedLift, shelf_under

AT = Pose2D(4.0, 4.0, 0.7)
LOAD = ((0.5, 0.35), (-0.5, 0.35), (-0.5, -0.35), (0.5, -0.35))
SHELF = DockType(
    detection="legs", detector={"spacing": 0.58}, distance=-0.44, blind_distance=0.7, staging_distance=1.2,
    docking_threshold=0.03, lateral_tolerance=0.06, load=LOAD,
)  # fmt: skip
QUIET = DockingNoise(0.005, 0.5, 0.01, (0.01, 0.01), (0.02, 0.02), 0.1, 0.0)
PARAMETERS = DockingParameters(dock_types={"shelf": SHELF, "home": DockType()}, lift_timeout=4.0)


class ShelfScene(DockingScene):
    """A robot with a lift, and a shelf."""

    def __init__(self, *, has_lift: bool = True) -> None:
        self.lift: SimulatedLift | None = None
        super().__init__({}, {"shelf 1": AT}, 1, parameters=PARAMETERS, noise=QUIET, dock_type="shelf")
        self.shelf = shelf_under(self._world, AT @ Pose2D(0.05, -0.05, 0.05), LOAD)
        self.lift = SimulatedLift(self.robot, [self.shelf]) if has_lift else None
        self.results: list[tuple[int, int, str]] = []
        self.loads: list[Footprint] = []
        self.said: list[str] = []
        self.scan: LaserScan | None = None
        self.graph.add(lambda context: FootprintNode(context, self.graph, self.loads.append))
        for action in (DOCK_ROBOT, UNDOCK_ROBOT):
            self.graph.tap(action.result.name, self._ended)
        self.graph.tap("lift", self._command)
        self.graph.tap("docking_server/status", self._hear)
        self.graph.tap("scan", self._see)
        self.run(0.2)

    def _ended(self, _: str, message: Payload) -> None:
        self.results.append((message.status.status, message.result.error_code, message.status.text))  # type: ignore[union-attr]

    def _hear(self, _: str, message: Payload) -> None:
        assert isinstance(message, String)
        self.said.append(message.data)

    def _see(self, _: str, message: Payload) -> None:
        assert isinstance(message, LaserScan)
        self.scan = message

    def _command(self, _: str, message: Payload) -> None:
        assert isinstance(message, Bool)
        if self.lift is not None:
            self.lift.command(message.data)

    def step(self) -> None:
        """Simulate one step, with the lift."""
        super().step()
        if self.lift is not None:
            self.lift.after_step(self._world.dt)
            if self._world.steps % 10 == 0:
                self.graph.inject("lift_state", Bool(self.lift.up))

    def run(self, seconds: float) -> None:
        """Simulate for a time [s]."""
        for _ in range(round(seconds * 50)):
            self.step()

    def until_result(self) -> tuple[int, int, str]:
        """Simulate until a goal ends."""
        had = len(self.results)
        for _ in range(9000):
            if len(self.results) > had:
                return self.results[-1]
            self.step()
        raise AssertionError(self.said)

    def send_dock(self, name: str, goal_id: str = "g") -> tuple[int, int, str]:
        """Dock, and return the end."""
        goal = DockRobotActionGoal(goal_id=GoalID(id=goal_id), goal=DockRobotGoal(dock_id=name))
        self.graph.inject(DOCK_ROBOT.goal.name, goal)
        return self.until_result()

    def send_undock(self) -> tuple[int, int, str]:
        """Undock, and return the end."""
        self.graph.inject(UNDOCK_ROBOT.goal.name, UndockRobotActionGoal(goal_id=GoalID(id="u")))
        return self.until_result()

    def drive(self, seconds: float) -> None:
        """Drive ahead and to the left."""
        for _ in range(round(seconds * 50)):
            self.robot.command(Twist(Vector3(x=0.2), Vector3(z=0.1)))
            self.step()
        self.robot.command(Twist())
        self.run(1.0)

    def renew(self) -> None:
        """Continue the node in another executor."""
        state = self.graph.remove("docking_server")
        assert state is not None
        self.add_node(PARAMETERS, {"shelf 1": AT})
        self.node.restore(state)


def test_a_shelf_is_lifted_carried_and_set_down_elsewhere() -> None:
    scene = ShelfScene()
    assert scene.send_dock("shelf 1") == (Status.SUCCEEDED, 0, "")
    assert scene.lift is not None and scene.lift.shelf is scene.shelf
    assert scene.loads == [LOAD]
    scene.run(1.2)
    assert scene.said[-1] == "carries the load of dock 'shelf 1'"
    before = scene.shelf.pose
    scene.renew()
    scene.drive(5.0)
    assert scene.shelf.pose.distance_to(before) > 0.8
    assert scene.scan is not None
    near = np.array([each for each in scene.scan.ranges if each is not None])
    assert not (near < 0.5).any(), "its legs are not in the scans"
    assert sum(not math.isfinite(each) for each in near.tolist()) > 8, "and hide what is behind them"
    place = scene.robot.base.pose
    status, code, text = scene.send_undock()
    assert (status, code) == (Status.SUCCEEDED, 0) and text.startswith("set down at (")
    x, y, _ = (float(each) for each in text.removeprefix("set down at (").rstrip(")").split(", "))
    assert math.dist((x, y), (place.x, place.y)) < 0.1
    assert scene.robot.base.pose.distance_to(place) > 1.1 and scene.shelf.pose.distance_to(place) < 0.15
    assert scene.loads == [LOAD, ()] and scene.said[-1] == ""
    assert not scene._world.contacts.total(0)


def test_a_lift_that_does_not_move_is_a_failure_that_says_so() -> None:
    scene = ShelfScene()
    assert scene.lift is not None
    scene.lift.jammed = True
    status, code, text = scene.send_dock("shelf 1")
    assert (status, code) == (Status.ABORTED, 999)
    assert text == "at dock 'shelf 1' the lift does not go up"
    assert scene.robot.base.pose.distance_to(AT) > 1.0 and scene.loads == []


def test_a_robot_without_a_lift_is_not_loaded() -> None:
    scene = ShelfScene(has_lift=False)
    status, code, text = scene.send_dock("shelf 1")
    assert (status, code) == (Status.ABORTED, 999) and text.endswith("publish lift_state")


def test_a_load_that_does_not_come_down_is_not_left() -> None:
    scene = ShelfScene()
    scene.send_dock("shelf 1")
    assert scene.lift is not None
    scene.lift.jammed = True
    at = scene.robot.base.pose
    assert scene.send_undock() == (Status.ABORTED, 999, "the lift does not go down")
    assert scene.robot.base.pose.distance_to(at) < 0.02 and scene.loads == [LOAD]


def test_a_robot_carries_one_load() -> None:
    scene = ShelfScene()
    scene.send_dock("shelf 1")
    scene.graph.inject(
        DOCK_ROBOT.goal.name, DockRobotActionGoal(goal_id=GoalID(id="h"), goal=DockRobotGoal(dock_id="shelf 1"))
    )
    assert scene.results[-1] == (
        Status.ABORTED, 902, "the robot carries a load already: undock it first, which sets the load down"
    )  # fmt: skip


def test_a_lift_that_is_up_carries_the_only_kind_of_load() -> None:
    scene = ShelfScene()
    scene.graph.inject("lift_state", Bool(True))
    assert scene.loads == [LOAD] and scene.said == ["carries a load of type 'shelf'"]
    scene.graph.inject("lift_state", Bool(False))
    assert scene.loads == [LOAD, ()] and scene.said[-1] == ""


def test_chargers_beside_shelves_are_found_without_a_name() -> None:
    scene = ShelfScene()
    scene.graph.inject(DOCK_ROBOT.goal.name, DockRobotActionGoal(goal_id=GoalID(id="g"), goal=DockRobotGoal()))
    assert scene.results[-1][:2] == (Status.ABORTED, 901)
    assert scene.results[-1][2] == "name a dock, since all are places of loads: 'shelf 1'"
