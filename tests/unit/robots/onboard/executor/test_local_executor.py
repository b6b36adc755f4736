"""Local executor, run in this process: its commands and the messages of its nodes."""

import asyncio
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from engine.specs.containers import RobotConfig
from ppaas.change_log import LogChange, LogEntry
from ppaas.geometry import Pose2D
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import to_message
from ppaas.messages import decode, encode
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, PoseStamped, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import GetPlanRequest, GetPlanResponse, Odometry
from ppaas.messages.people_coordination import PeopleReport
from ppaas.messages.people_msgs import People, Person
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.base import Reply
from ppaas.transforms.planar import transform_message
from robots.onboard.executor import protocol
from robots.onboard.executor.local_executor import LocalExecutor

MAP = msgspec.Raw(encode(to_message(office(seed=1, width=12.0, height=10.0))))
CONFIG = protocol.CloneConfig("turtlebot2", (2.0, 2.0, 0.0), "dijkstra", "dwa")


@pytest.fixture
def frames() -> list[protocol.FromExecutor]:
    return []


@pytest.fixture
async def home(frames: list[protocol.FromExecutor]) -> LocalExecutor:
    return LocalExecutor(frames.append)


def begin(home: LocalExecutor, config: protocol.CloneConfig = CONFIG, grid: msgspec.Raw = MAP) -> None:
    home.take(protocol.Begin(config, grid))


async def test_a_node_is_added_and_removed_with_its_state(
    home: LocalExecutor, frames: list[protocol.FromExecutor]
) -> None:
    begin(home)
    assert frames == [protocol.ExecutorReady()]
    covariance = "[[0.1,0.0,0.0],[0.0,0.1,0.0],[0.0,0.0,0.1]]"
    state = f'{{"pose":[3.0,2.0,0.5],"covariance":{covariance},"odom":null,"searching":false,"stamp":null}}'
    home.take(protocol.Add("amcl", state))
    added = frames.pop()
    assert isinstance(added, protocol.Added)
    assert protocol.TopicName("scan", "sensor_msgs/LaserScan") in added.subscribes
    assert "amcl_pose" in added.publishes
    home.take(protocol.AskStates())
    states = frames.pop()
    assert isinstance(states, protocol.States)
    assert states.nodes["amcl"].state == state
    home.take(protocol.Remove("amcl"))
    assert frames.pop() == protocol.Removed("amcl", state)
    assert list(home.graph.nodes) == []


async def test_a_new_map_is_made_on_the_robot(home: LocalExecutor, frames: list[protocol.FromExecutor]) -> None:
    home.take(protocol.Begin(msgspec.structs.replace(CONFIG, new_map="office-2")))
    assert frames == [protocol.ExecutorReady()]
    home.take(protocol.Add("grid_slam", ""))
    added = frames.pop()
    assert isinstance(added, protocol.Added)
    assert {"map", "map_updates", "amcl_pose"} <= set(added.publishes)
    assert "dynamic_map" in {service.name for service in added.services}
    home.take(protocol.Add("move_base", ""))
    added = frames.pop()
    assert isinstance(added, protocol.Added)
    assert {"map", "map_updates"} <= {topic.name for topic in added.subscribes}


async def test_the_log_of_a_node_is_restored_and_its_changes_are_reported(
    home: LocalExecutor, frames: list[protocol.FromExecutor], monkeypatch: pytest.MonkeyPatch
) -> None:
    begin(home)
    logs: list[LogEntry] = []
    changes = [LogChange([LogEntry(7, b"c")], [3]), LogChange([LogEntry(8, b"d")], [])]
    monkeypatch.setattr(AmclNode, "restore_log", lambda _, entries: logs.extend(entries))
    monkeypatch.setattr(AmclNode, "log_change", lambda _: changes.pop(0) if changes else None)
    home.take(protocol.Add("amcl", "", [(3, b"a"), (4, b"b")]))
    assert logs == [LogEntry(3, b"a"), LogEntry(4, b"b")]
    home.take(protocol.AskStates())
    states = frames.pop()
    assert isinstance(states, protocol.States)
    assert (states.nodes["amcl"].log, states.nodes["amcl"].obsolete) == ([(7, b"c")], [3])
    home.take(protocol.Remove("amcl"))
    removed = frames.pop()
    assert isinstance(removed, protocol.Removed)
    assert (removed.log, removed.obsolete) == ([(8, b"d")], [])


def test_frames_of_the_executor_are_read_as_written() -> None:
    frames = (protocol.Begin(CONFIG, MAP), protocol.Begin(CONFIG), protocol.Add("amcl", "", [(3, b"a")]))
    for frame in frames:
        assert protocol.to_executor.decode(protocol.line(frame)) == frame


async def test_only_messages_of_its_nodes_are_forwarded(
    home: LocalExecutor, frames: list[protocol.FromExecutor]
) -> None:
    begin(home)
    home.take(protocol.Add("move_base", ""))
    frames.clear()
    pose = PoseWithCovariance(Pose.of(Pose2D(0.0, 0.0)))
    odometry = Odometry(Header(frame_id="odom"), "base_link", pose, TwistWithCovariance(Twist()))
    home.take(protocol.Tell("odom", msgspec.Raw(encode(odometry))))
    assert frames == []
    home.graph.publish("cmd_vel", Twist())
    assert frames == [protocol.Said("cmd_vel", "geometry_msgs/Twist", msgspec.Raw(encode(Twist())))]


async def test_an_invalid_message_is_logged_and_ignored(
    home: LocalExecutor, frames: list[protocol.FromExecutor], caplog: pytest.LogCaptureFixture
) -> None:
    begin(home)
    home.take(protocol.Add("move_base", ""))
    frames.clear()
    home.take(protocol.Tell("move_base/cancel", msgspec.Raw(b'{"id": 3}')))
    home.take(protocol.Tell("nothing", msgspec.Raw(b"{}")))
    assert frames == []
    assert "a message of move_base/cancel was rejected" in caplog.text
    home.take(protocol.Tell("move_base/cancel", msgspec.Raw(encode(GoalID(id="g")))))


async def test_masks_restrict_planning_on_the_robot(home: LocalExecutor, frames: list[protocol.FromExecutor]) -> None:
    grid = office(seed=1, width=12.0, height=10.0)
    everywhere = msgspec.Raw(encode(to_message(GridMap(np.full(grid.info.shape, 100, np.int8), grid.info))))
    names = {"keepout_filter": {"filter_mask": "kept"}, "speed_filter": {"filter_mask": "slow"}}
    config = msgspec.structs.replace(CONFIG, parameters=names)
    free = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(2.0, 2.0)))
    home.take(protocol.Begin(config, MAP))
    assert isinstance(frames[-1], protocol.NodeFailed)
    assert frames[-1].text.startswith("keepout_filter: mask 'kept' was not loaded with the map")
    home.take(protocol.Begin(config, MAP, {"keepout_filter_mask": everywhere, "speed_filter_mask": everywhere}))
    assert frames[-1] == protocol.ExecutorReady()
    home.take(protocol.Add("move_base", ""))
    home.take(protocol.NodeCall(1, "move_base/make_plan", msgspec.Raw(encode(GetPlanRequest(free, free)))))
    while not isinstance(frames[-1], protocol.Replied):
        await asyncio.sleep(0.005)
    assert frames[-1].slug == "start-occupied"


async def test_service_calls_are_answered_by_number(home: LocalExecutor, frames: list[protocol.FromExecutor]) -> None:
    begin(home)
    home.take(protocol.Add("move_base", ""))
    added = frames[-1]
    assert isinstance(added, protocol.Added)
    assert protocol.ServiceName("move_base/make_plan", "nav_msgs/GetPlan") in added.services
    frames.clear()
    free = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(2.0, 2.0)))
    home.take(protocol.NodeCall(7, "move_base/make_plan", msgspec.Raw(encode(GetPlanRequest(free, free)))))
    home.take(protocol.NodeCall(8, "move_base/clear_costmaps", msgspec.Raw(b"{}")))
    home.take(protocol.NodeCall(9, "move_base/make_plan", msgspec.Raw(b'{"start": 3}')))
    home.take(protocol.NodeCall(10, "amcl/nothing", msgspec.Raw(b"{}")))
    while len(answers := [frame for frame in frames if isinstance(frame, protocol.Replied)]) < 4:
        await asyncio.sleep(0.005)
    assert answers[0] == protocol.Replied(8, msgspec.Raw(b"{}")), "a long call does not delay others"
    replies = {reply.call: reply for reply in answers}
    assert decode(GetPlanResponse, replies[7].response).plan.poses
    assert [(replies[n].slug, replies[n].response) for n in (9, 10)] == [
        ("malformed-message", msgspec.Raw(b"null")),
        ("not-found", msgspec.Raw(b"null")),
    ]


async def test_failed_and_abandoned_calls_are_refused(
    home: LocalExecutor, frames: list[protocol.FromExecutor], monkeypatch: pytest.MonkeyPatch
) -> None:
    begin(home)
    home.take(protocol.Add("move_base", ""))
    frames.clear()

    open_replies: list[Reply] = []

    def wait_or_break(service: str, request: Message, reply: Reply) -> None:
        if open_replies:
            raise ZeroDivisionError("secret")
        open_replies.append(reply)

    monkeypatch.setattr(home.graph.nodes["move_base"], "on_call", wait_or_break)
    for number in (1, 2):
        home.take(protocol.NodeCall(number, "move_base/clear_costmaps", msgspec.Raw(b"{}")))
    assert frames == [protocol.Replied(2, slug="error", text="internal error: ZeroDivisionError")]
    home.take(protocol.Remove("move_base"))
    left = frames[1]
    assert isinstance(left, protocol.Replied)
    assert (left.call, left.slug) == (1, "unavailable")


@pytest.mark.parametrize(
    ("do", "slug", "text"),
    [
        (lambda home: begin(home, msgspec.structs.replace(CONFIG, model="snail")), "not-found", "snail"),
        (lambda home: begin(home, grid=msgspec.Raw(b"[]")), "malformed-message", "OccupancyGrid"),
        (lambda home: home.take(protocol.Add("amcl", "")), "error", "the executor has no configuration yet"),
        (lambda home: home.take(protocol.Remove("amcl")), "not-found", "amcl"),
        (
            lambda home: (begin(home), home.take(protocol.Add("amcl", "rubbish"))),
            "invalid-input",
            "the checkpoint of node 'amcl' cannot be read",
        ),
    ],
)
async def test_invalid_commands_are_reported_as_errors(
    do: Callable[[LocalExecutor], object],
    slug: str,
    text: str,
    home: LocalExecutor,
    frames: list[protocol.FromExecutor],
) -> None:
    do(home)
    failed = frames[-1]
    assert isinstance(failed, protocol.NodeFailed)
    assert failed.slug == slug
    assert text in failed.text


async def test_frames_of_people_are_named_by_the_id_of_the_robot(
    home: LocalExecutor, frames: list[protocol.FromExecutor]
) -> None:
    """The configuration is that of the cloud, which has more fields than a robot needs."""
    robot = RobotConfig("tb1", "turtlebot2", (2.0, 2.0, 0.0), "dijkstra", "dwa", {"people_tracker": {}})
    begin(home, msgspec.json.decode(msgspec.json.encode(robot), type=protocol.CloneConfig))
    home.take(protocol.Add("people_tracker", ""))
    stamp = Time.of(home.graph.now())
    for parent, child in (("odom", "base_link"), ("map", "odom")):
        transform = TFMessage([transform_message(parent, child, Pose2D(1.0, 1.0), stamp)])
        home.take(protocol.Tell("tf", msgspec.Raw(encode(transform))))
    people = People(Header(stamp=stamp, frame_id="base_link"), [Person("1", Point(2.0, 0.0))])
    home.take(protocol.Tell("people", msgspec.Raw(encode(people))))
    frames.clear()
    await asyncio.sleep(0.11)
    home.take(protocol.AskStates())
    said = {frame.topic: bytes(frame.payload) for frame in frames if isinstance(frame, protocol.Said)}
    assert b'"tb1/torso_1"' in said["tf"]
    assert decode(PeopleReport, said["people_tracker/report"]).robot == "tb1"
