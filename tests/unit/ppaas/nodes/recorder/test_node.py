"""Node ``recorder``: what it hears and hands over, recordings, and the ring."""

from dataclasses import dataclass, field

import pytest

from ppaas.errors import Conflict, InvalidParameter, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, TransformStamped, Twist
from ppaas.messages.health.watching import RecorderState, StartRecordingRequest
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav_msgs import MapMetaData, OccupancyGrid, Path
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.recorder.node import MOST_SECONDS, RecorderNode
from ppaas.recording.batches import Batch, batch_of
from ppaas.recording.parameters import RecorderParameters
from ppaas.transforms.planar import transform_message
from tests.support.recordings.entries import ABOUT, scan

START = 1_800_000_000.0
RING = RecorderParameters(ring_minutes=1.0)


class Driver(Node):
    """Node that hears scans, and publishes velocities."""

    name = "driver"
    subscribes = (topics.SCAN, topics.TF_STATIC, topics.MOVE_BASE_GOAL)
    publishes = (
        topics.CMD_VEL,
        topics.AMCL_STATUS,
        topics.MOVE_BASE_RESULT,
        topics.LOCAL_COSTMAP,
        topics.TF_STATIC,
        topics.PLAN,
    )

    def on_message(self, topic: str, message: Payload) -> None:
        """Answer a scan by a velocity."""
        if topic == "scan":
            self.context.publish("cmd_vel", Twist())


@dataclass
class Machine:
    """Clone with a recorder, and the batches that its machine got."""

    parameters: RecorderParameters = field(default_factory=RecorderParameters)
    takes: bool = True
    batches: list[Batch] = field(default_factory=list)
    now: float = 0.0

    def __post_init__(self) -> None:
        self.graph = Graph(clock=lambda: self.now, stamp_clock=lambda: START + self.now)
        self.driver = self.graph.add(Driver)
        self.driver.context.publish("amcl/status", String("ok"))
        self.node = self.graph.add(self._recorder)

    def _recorder(self, context: Context) -> RecorderNode:
        return RecorderNode(context, self.graph, self.parameters, lambda: ABOUT, self._take)

    def _take(self, batch: bytes) -> bool:
        if self.takes:
            self.batches.append(batch_of(batch))
        return self.takes

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.5)):
            self.now += 0.5
            self.graph.run_due()

    def call(self, service: str, request: Message) -> RecorderState:
        answers: list[Payload | PPaaSError] = []
        self.graph.call(f"recorder/{service}", request, answers.append)
        (answer,) = answers
        if isinstance(answer, PPaaSError):
            raise answer
        assert isinstance(answer, RecorderState)
        return answer

    @property
    def heard(self) -> list[tuple[str, bool]]:
        """Topics of the entries so far, and whether they came from outside."""
        return [(entry.topic, entry.up) for batch in self.batches for entry in batch.entries]


def goal(id: str) -> MoveBaseActionGoal:  # noqa: A002
    return MoveBaseActionGoal(
        MoveBaseGoal(PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(1.0, 2.0)))), GoalID(id=id)
    )


def test_nothing_is_heard_without_a_ring_or_a_recording() -> None:
    machine = Machine()
    machine.graph.inject("scan", scan())
    machine.wait(2.0)
    assert machine.batches == []
    assert not machine.graph.has_taps("scan")


def test_ring_has_what_robot_and_clone_send_with_latched_messages_first() -> None:
    machine = Machine(RING)
    machine.graph.inject("scan", scan())
    machine.wait(0.5)
    # A message is heard after the nodes that use it, and so after what they publish at once.
    assert machine.heard == [("amcl/status", False), ("cmd_vel", False), ("scan", True)]
    batch = machine.batches[0]
    assert (batch.ring_seconds, batch.ring_bytes, batch.recording) == (60.0, 64_000_000, "")
    assert [entry.kept for entry in batch.entries] == [True, False, False]
    assert batch.entries[2].publish_time == 1_800_000_000 * 10**9  # its stamp
    assert machine.call("state", Empty()).messages == 3


def test_static_transforms_are_those_of_all_messages() -> None:
    machine = Machine(RING)
    for child in ("laser", "camera"):
        machine.graph.inject("tf_static", TFMessage([_static(child)]))
    machine.wait(0.5)
    last = machine.batches[0].entries[-1]
    assert last.payload.count(b"child_frame_id") == 2
    assert last.up


def test_recording_ends_by_itself_and_by_request() -> None:
    machine = Machine()
    started = machine.call("start", StartRecordingRequest(2.0, ["/scan"]))
    assert started.recording == "20270115T080000Z"
    machine.graph.inject("scan", scan())
    machine.wait(1.0)
    assert machine.heard == [("scan", True)]
    assert machine.batches[-1].recording_topics == ("scan",)
    with pytest.raises(Conflict, match="in progress"):
        machine.call("start", StartRecordingRequest(2.0))
    machine.wait(2.0)
    assert machine.batches[-1].recording == ""
    assert not machine.graph.has_taps("scan")
    assert not machine.graph._published_taps
    machine.call("start", StartRecordingRequest(60.0))
    assert machine.call("stop", Empty()).recording == ""


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), MOST_SECONDS + 1.0])
def test_invalid_times_are_refused(seconds: float) -> None:
    with pytest.raises(InvalidParameter, match="a recording takes"):
        Machine().call("start", StartRecordingRequest(seconds))


def test_container_that_replaces_another_continues_its_recording() -> None:
    machine, other = Machine(), Machine()
    machine.call("start", StartRecordingRequest(60.0, ["scan"]))
    other.graph.restore(machine.graph.checkpoints())
    other.graph.inject("scan", scan())
    other.wait(0.5)
    assert other.batches[-1].recording == "20270115T080000Z"
    assert Machine().graph.checkpoints() == []


def test_goal_is_kept_until_its_result() -> None:
    machine = Machine(RING)
    machine.graph.inject("move_base/goal", goal("g1"))
    machine.wait(0.5)
    assert machine.batches[0].entries[-1].kept
    assert not machine.batches[0].entries[-1].latched
    status = GoalStatus(GoalID(id="g1"), Status.SUCCEEDED)
    machine.driver.context.publish("move_base/result", MoveBaseActionResult(Header(), status))
    machine.wait(0.5)
    ended = machine.batches[-1].entries
    assert [(entry.topic, bool(entry.payload)) for entry in ended] == [
        ("move_base/goal", False),
        ("move_base/result", True),
    ]


def test_machine_that_is_too_slow_or_has_a_problem_is_told_of() -> None:
    machine = Machine(RING)
    machine.takes = False
    machine.graph.inject("scan", scan())
    machine.wait(0.5)
    assert machine.call("state", Empty()).lost == 3
    machine.takes = True
    machine.call("start", StartRecordingRequest(60.0))
    machine.node.told("the disk is full")
    state = machine.call("state", Empty())
    assert (state.recording, state.problem) == ("", "the disk is full")
    machine.node.told("")
    assert machine.call("state", Empty()).problem == ""


def test_recorder_that_was_started_again_gets_latched_messages_again() -> None:
    machine = Machine(RING)
    machine.wait(0.5)
    machine.node.told("", forgotten=True)
    machine.wait(0.5)
    assert machine.heard == [("amcl/status", False)] * 2


def test_costmap_is_sampled_and_not_subscribed_to_for_long() -> None:
    machine = Machine(RING)
    machine.wait(0.5)
    assert machine.graph.has_taps("local_costmap/costmap")
    machine.driver.context.publish("local_costmap/costmap", _costmap())
    assert not machine.graph.has_taps("local_costmap/costmap")
    machine.wait(5.0)
    assert machine.graph.has_taps("local_costmap/costmap")
    assert [topic for topic, _ in machine.heard].count("local_costmap/costmap") == 1


def test_plans_that_repeat_are_recorded_seldom_and_at_each_goal() -> None:
    machine = Machine(RING)
    for number in range(6):
        if number == 5:
            machine.graph.inject("move_base/goal", goal("g1"))
        machine.driver.context.publish("plan", Path(Header(frame_id="map"), []))
        machine.wait(0.5)
    assert [topic for topic, _ in machine.heard].count("plan") == 3


def test_too_large_messages_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ppaas.nodes.recorder.node.MOST_PAYLOAD", 10)
    machine = Machine(RING)
    machine.wait(0.5)
    assert machine.heard == []
    assert machine.call("state", Empty()).lost == 1


def _static(child: str) -> TransformStamped:
    return transform_message("base_link", child, Pose2D(0.0, 0.0), Time())


def _costmap() -> OccupancyGrid:
    return OccupancyGrid(Header(frame_id="map"), MapMetaData(0.05, 1, 1, Pose.of(Pose2D(0.0, 0.0))), [0])
