"""Node that docks a robot, with a simulated robot and charger on the clock of the test."""

import numpy as np
import pytest

from benchmarks.building.docking_scene import DockingNoise, DockingScene
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Duration, Header, String
from ppaas.messages.geometry_msgs import Pose, PoseStamped, Twist, Vector3
from ppaas.messages.health.stops import StopState
from ppaas.messages.nav2_motions import WaitActionGoal, WaitGoal
from ppaas.messages.nav2_servers import DockRobotActionGoal, DockRobotGoal, UndockRobotActionGoal
from ppaas.messages.operators.teleoperation import TeleopState
from ppaas.messages.sensor_msgs import BatteryState
from ppaas.nodes.base import Payload
from ppaas.nodes.nav2_actions import DOCK_ROBOT, UNDOCK_ROBOT, WAIT
from robots.sim.bodies.furniture import table
from robots.sim.docks.charger import Charger, ChargerFault, ChargerModel

AT = Pose2D(4.0, 4.0, 0.7)
QUIET = DockingNoise(0.005, 0.5, 0.01, (0.01, 0.01), (0.02, 0.02), 0.1, 0.0)


class Scene(DockingScene):
    """Scene with one dock, that keeps what the node publishes."""

    def __init__(self, fault: ChargerFault = ChargerFault.NOTHING, **parameters: object) -> None:
        made = DockingParameters(**parameters)  # type: ignore[arg-type]
        super().__init__({"a": Charger(AT, 0.18, fault=fault)}, {"a": AT}, 1, parameters=made, noise=QUIET)
        self.said: list[str] = []
        self.text = ""
        self.results: list[tuple[int, int, str]] = []
        self.graph.tap("docking_server/status", self._hear)
        self.graph.tap(DOCK_ROBOT.status.name, self._hear)
        for action in (DOCK_ROBOT, UNDOCK_ROBOT):
            self.graph.tap(action.result.name, self._ended)
        self.run(0.2)

    def _hear(self, _: str, message: Payload) -> None:
        if isinstance(message, String):
            self.said.append(message.data)
        elif isinstance(message, GoalStatusArray) and message.status_list:
            self.text = message.status_list[-1].text

    def _ended(self, _: str, message: Payload) -> None:
        self.results.append((message.status.status, message.result.error_code, message.status.text))  # type: ignore[union-attr]

    def send(self, name: str = "a", goal_id: str = "g") -> None:
        """Send a goal to dock."""
        self.say(
            DOCK_ROBOT.goal.name, DockRobotActionGoal(goal_id=GoalID(id=goal_id), goal=DockRobotGoal(dock_id=name))
        )

    def say(self, topic: str, message: Message) -> None:
        """Publish a message of a client."""
        self.graph.inject(topic, message)

    def run(self, seconds: float) -> None:
        """Simulate for a time [s]."""
        for _ in range(round(seconds * 50)):
            self.step()

    def until_result(self) -> tuple[int, int, str]:
        """Simulate until a goal ends."""
        had = len(self.results)
        for _ in range(12000):
            if len(self.results) > had:
                return self.results[-1]
            self.step()
        raise AssertionError(self.text)

    @property
    def stands(self) -> bool:
        """Whether the robot is at rest."""
        wheels = self.robot.base.wheels
        return abs(wheels.linear) < 0.01 and abs(wheels.angular) < 0.02


def nothing_sent(scene: Scene, seconds: float) -> bool:
    """Return whether no velocity is published for a time [s]."""
    heard: list[Payload] = []
    end = scene.graph.tap("cmd_vel", lambda _, message: heard.append(message))
    scene.run(seconds)
    end()
    return not heard


def test_a_robot_docks_and_a_charge_that_ends_is_noticed() -> None:
    scene = Scene(not_charging_timeout=5.0)
    scene.send()
    assert scene.until_result() == (Status.SUCCEEDED, 0, "")
    assert scene.battery.flow > 0.0
    scene.run(8.0)
    assert scene.said == ["docked at dock 'a'"]
    scene.chargers["a"].fault = ChargerFault.DEAD
    scene.run(8.0)
    assert scene.said[1].startswith("the robot stands at dock 'a' without charge for ")
    scene.say(UNDOCK_ROBOT.goal.name, UndockRobotActionGoal(goal_id=GoalID(id="u")))
    assert scene.until_result() == (Status.SUCCEEDED, 0, "")
    assert scene.said[-1] == ""
    assert scene.robot.base.pose.distance_to(AT) > 0.6
    assert nothing_sent(scene, 1.0)


def test_a_robot_that_drives_away_is_not_docked_any_more() -> None:
    scene = Scene()
    scene.send()
    scene.until_result()
    scene.robot.command(Twist(Vector3(x=-0.3)))
    scene.run(0.4)
    scene.robot.command(Twist(Vector3(x=-0.3)))
    scene.run(3.0)
    assert scene.said[-1] == ""


@pytest.mark.parametrize(
    ("topic", "message", "reason"),
    [
        ("goal_pose", PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(1.0, 1.0))), "Replaced by another goal: a"),
        (WAIT.goal.name, WaitActionGoal(goal_id=GoalID(id="w"), goal=WaitGoal(Duration(1))), "another goal: w"),
        ("move_base/cancel", GoalID(), "The goal was cancelled."),
        (DOCK_ROBOT.cancel.name, GoalID(id="g"), "The goal was cancelled."),
        (DOCK_ROBOT.goal.name, DockRobotActionGoal(goal_id=GoalID(id="h"), goal=DockRobotGoal()), "another goal: h"),
    ],
)
def test_other_goals_and_cancels_end_docking(topic: str, message: Message, reason: str) -> None:
    scene = Scene()
    scene.send()
    scene.run(2.0)
    scene.say(topic, message)
    assert scene.results[0][0] == Status.PREEMPTED
    assert reason in scene.results[0][2]


@pytest.mark.parametrize(
    ("topic", "held", "free", "text"),
    [
        ("stop/state", StopState(True, text="stopped by ann"), StopState(), "waiting: stopped by ann"),
        (
            "teleop_state", TeleopState(Header(), 1, "x", "bob"), TeleopState(Header(), 2),
            "waiting: bob drives the robot by hand",
        ),
    ],
)  # fmt: skip
def test_a_robot_that_is_held_waits_and_goes_on(topic: str, held: Message, free: Message, text: str) -> None:
    scene = Scene()
    scene.send()
    scene.run(2.0)
    scene.say(topic, held)
    scene.run(45.0)
    assert scene.stands and scene.text == text
    scene.say(topic, free)
    assert scene.until_result()[0] == Status.SUCCEEDED


@pytest.mark.parametrize("seconds", [0.05, 2.0])
def test_a_goal_goes_on_in_another_executor(seconds: float) -> None:
    scene = Scene()
    scene.send()
    scene.run(seconds)
    state = scene.graph.remove("docking_server")
    assert state is not None
    scene.add_node(DockingParameters(), {"a": AT})
    scene.node.restore(state)
    assert scene.until_result() == (Status.SUCCEEDED, 0, "")
    again = scene.graph.remove("docking_server")
    assert again is not None
    scene.add_node(DockingParameters(), {"a": AT})
    scene.node.restore(again)
    scene.run(1.2)
    assert scene.said[-1] == "docked at dock 'a'"
    gone = scene.node.checkpoint().replace(b'"dock":null', b'"dock":{"id":"x","stamp":1.0,"dock":"gone"}')
    scene.node.restore(gone)
    assert scene.results[-1][1] == 901


def test_a_robot_that_is_charged_need_not_dock_again() -> None:
    scene = Scene()
    scene.send()
    scene.until_result()
    scene.run(3.0)
    at = scene.robot.base.pose
    for number, name in enumerate(("a", "")):
        scene.send(name, f"again {number}")
        assert scene.results[-1] == (Status.SUCCEEDED, 0, "the robot stands there, and is charged")
    scene.run(1.0)
    assert scene.robot.base.pose.distance_to(at) < 0.005
    scene.chargers["a"].fault = ChargerFault.DEAD
    scene.run(8.0)
    scene.send("a", "without charge")
    scene.chargers["a"].fault = ChargerFault.NOTHING
    assert scene.until_result()[0] == Status.SUCCEEDED
    assert scene.battery.flow > 0.0


def test_the_same_goal_twice_is_one_goal() -> None:
    scene = Scene()
    scene.send()
    scene.run(1.0)
    scene.send()
    assert scene.until_result()[0] == Status.SUCCEEDED
    assert len(scene.results) == 1


def test_poses_of_another_detector_lead_the_robot() -> None:
    scene = Scene(dock_types={"tag": DockType(detection="pose")})
    scene.send()
    for _ in range(3000):
        if scene.results:
            break
        scene.step()
        at = scene.robot.base.pose.inverse() @ scene.chargers["a"].face
        scene.say("detected_dock_pose", PoseStamped(Header(frame_id="base_link"), Pose.of(at)))
    assert scene.results == [(Status.SUCCEEDED, 0, "")]
    scene.send(goal_id="again")
    with pytest.raises(InvalidInput, match=r"needs header\.frame_id"):
        scene.say("detected_dock_pose", PoseStamped(Header(), Pose.of(Pose2D(0.0, 0.0))))
    with pytest.raises(PPaaSError, match="moon"):
        scene.say("detected_dock_pose", PoseStamped(Header(frame_id="moon"), Pose.of(Pose2D(0.0, 0.0))))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_robot_drives_under_a_cart_by_its_legs(seed: int) -> None:
    """The cart is a table of four legs, 1 m long and 0.7 m wide; its front legs are 0.44 m from its middle."""
    cart = DockType(
        detection="legs", detector={"spacing": 0.58}, distance=-0.44, blind_distance=0.7, staging_distance=1.2,
        docking_threshold=0.03, lateral_tolerance=0.06,
    )  # fmt: skip
    moved = AT @ Pose2D(0.1, 0.1, 0.1)
    parameters = DockingParameters(dock_types={"cart": cart})
    legs = table(moved, 1.0, 0.7)
    scene = DockingScene({}, {"cart": AT}, seed, parameters=parameters, noise=QUIET, furniture=[legs])
    outcome = scene.dock("cart")
    assert outcome.status is Status.SUCCEEDED, outcome
    off = moved.inverse() @ scene.robot.base.pose
    assert abs(off.x) < 0.08 and abs(off.y) < 0.05


def test_a_robot_docks_between_the_arms_of_a_v() -> None:
    """The arms are 0.23 m long, and their ends stand 0.12 m before the apex."""
    charger = Charger(AT @ Pose2D(0.05, -0.1, 0.05), 0.21, ChargerModel(angle=2.1))
    kind = DockType(detection="v_shape", detector={"arm": 0.23, "angle": 2.1}, distance=0.21)
    parameters = DockingParameters(dock_types={"v": kind})
    outcome = DockingScene({"a": charger}, {"a": AT}, 1, parameters=parameters, noise=QUIET).dock("a")
    assert outcome.status is Status.SUCCEEDED and outcome.current > 0.0, outcome


def test_odometry_that_never_comes_ends_the_goal() -> None:
    scene = Scene()
    scene.graph.remove("docking_server")
    scene.add_node(DockingParameters(), {"a": AT})
    scene.send()
    for _ in range(600):
        scene.clock.advance(0.02)
        scene.graph.run_due()
    assert scene.results == [(Status.ABORTED, 905, "the robot sends no odometry")]


def test_readings_that_are_not_finite_are_none() -> None:
    scene = Scene()
    scene.send()
    scene.run(1.0)
    for value in (np.nan, np.inf):
        scene.say("battery_state", BatteryState(current=float(value), percentage=float(value)))
    assert scene.until_result()[0] == Status.SUCCEEDED
