"""Topics, services, errors and limits in protocol.md are those of the code, and its frames are valid."""

import json
import re
from typing import get_args

import numpy as np
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from endpoints.cli import up
from endpoints.http.frame_pacing import BURST, BUSY, BYTES, FRAMES, OVERLOAD, STALL
from endpoints.http.problems import STATUS, TYPE, problem_response
from endpoints.http.websocket_protocol import CLOSED_BY_CLOUD, MESSAGE_TIMEOUT
from endpoints.resources.services import RequestLimits
from endpoints.rosbridge import PROBE_TIMEOUT, READY_TIMEOUT, TAKEN_OVER
from endpoints.web import MAX_FRAME
from engine.agent import fleet_topics
from engine.container.fleet_bridge import SHARE_PERIOD
from engine.control.robot_sessions import IDLE
from engine.links.shared_place import MAX_UNACKNOWLEDGED, MAX_UNACKNOWLEDGED_BYTES
from engine.master.places import LINGER
from engine.sessions.calls import CALL_TIMEOUT, MAX_CALLS
from engine.sessions.host import MAX_AWAY
from engine.sessions.outbox import MAX_BYTES, MAX_KEEP, MAX_SENT, MAX_SENT_BYTES
from engine.sessions.place.client_actions import MAX_ACTIONS
from engine.sessions.place.client_services import MAX_SERVICES
from engine.sessions.place.client_topics import MAX_LATCHED_BYTES, MAX_TOPICS
from engine.sessions.session import HEARTBEAT_PERIOD
from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.localization.beams import MAX_RANGES
from ppaas.localization.parameters import AmclParameters
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages import type_name
from ppaas.messages.actionlib_msgs import Status
from ppaas.navigation.goal_watch import MIN_LISTS, SETTLED
from ppaas.navigation.parameters import MoveBaseParameters, recovery_behaviors
from ppaas.navigation.waypoints import MAX_WAYPOINTS
from ppaas.nodes.base import DEFAULT_DEPTH
from ppaas.nodes.follow_path.node import FollowPathParameters
from ppaas.nodes.footprint.node import FootprintNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.move_base.node import STATUS_PERIOD
from ppaas.nodes.parameter_server.tree import MAX_FREE, MAX_FREE_BYTES
from ppaas.nodes.stop.node import StopNode
from ppaas.nodes.tf.republisher import MAX_PATIENCE, MAX_RATE, MAX_SOURCES, MAX_STREAMS, MIN_PATIENCE, MIN_RATE
from ppaas.nodes.topics import CMD_VEL, TOPICS
from ppaas.nodes.waypoint_follower.node import WaypointFollowerParameters
from ppaas.plans.path_service import DEFAULT_TIMEOUT
from ppaas.recoveries.base import AffectedMaps
from ppaas.recoveries.registry import RECOVERIES, recovery_names
from ppaas.wire.actions import ALIASES, NAV2_UNKNOWN, actions, find_action, ros2_status
from ppaas.wire.fragments import MAX_OPEN, MAX_SIZE
from ppaas.wire.goals import MAX_GOALS
from ppaas.wire.names import MAX_NAME
from ppaas.wire.operations import RefusedOperation
from ppaas.wire.own_topics import HEARTBEAT, OWN_TOPICS, PRESENCE
from ppaas.wire.resumption import ID_HEADER, STATE_HEADER, TAKEN_HEADER
from ppaas.wire.rosapi import DISTRIBUTION, ROS_VERSION, SERVICES
from ppaas.wire.rosbridge import MAX_SUBSCRIPTIONS, RosbridgeSession
from ppaas.wire.rosbridge_client import RosbridgeClientSession
from robots.cli.command_parser import CommandParser
from robots.client.robot_file import load_robot_file
from robots.onboard.base_controller import BaseLimits
from robots.sim.driver import SensorRates
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, table, text_of
from tests.support.sources import ROOT
from tests.support.waiting import patience

PROTOCOL = "docs/protocol.md"
EXAMPLES = ROOT / "docs" / "examples"


def states(words: str) -> bool:
    """Return whether the page contains some words, ignoring line breaks."""
    return words in re.sub(r"\s+", " ", text_of(PROTOCOL))


@pytest.fixture(scope="module")
def graph() -> Graph:
    """Return the graph of a clone."""
    cells = np.zeros((40, 40), np.int8)
    clone = Graph()
    layers = build_layers(GridMap(cells, GridInfo(0.05, 40, 40)), robot_radius=0.18)
    build_clone(clone, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0))
    clone.add(lambda context: StopNode(context, clone, "tb1"))
    clone.add(lambda context: FootprintNode(context, clone, lambda _: None))
    return clone


AMONG_NODES = {"move_base/result", "stop/state", "teleop_state"}
"""Topics between nodes of the clone, which clients need not publish."""


TOPIC_TABLE = PROTOCOL, "topic", "type", "direction", "rate and purpose"
ACTIONS_WITHOUT_TOPICS = {"navigate_to_pose/goal"}
"""Actions of the page that are executed by the topics of another one."""


def topics_of_actions(known: set[str]) -> dict[str, tuple[str, str]]:
    """Return type and direction of the topics of the page's actions, except those of known actions."""
    found = {}
    for listed, kind, *_ in table(PROTOCOL, "action", "type", "types of goal, feedback and result", "what it does"):
        name = ALIASES.get(listed, listed)
        if f"{name}/goal" not in known:
            base = kind.replace("/action/", "/")
            found[f"{name}/goal"] = f"{base}ActionGoal", "in"
            found[f"{name}/cancel"] = "actionlib_msgs/GoalID", "in"
            found[f"{name}/status"] = "actionlib_msgs/GoalStatusArray", "out"
            found[f"{name}/feedback"] = f"{base}ActionFeedback", "out"
            found[f"{name}/result"] = f"{base}ActionResult", "out"
    return found


def test_the_topics_are_those_of_a_clone(graph: Graph) -> None:
    nodes = graph.nodes.values()
    taken = {topic.name for node in nodes for topic in node.subscribes} - AMONG_NODES
    given = {topic.name for node in nodes for topic in node.publishes}
    expected = {}
    for topic in graph.topics.values():
        way = "both" if topic.name in taken & given else "in" if topic.name in taken else "out"
        expected[topic.name] = type_name(topic.type), way + (", latched" if topic.latched else "")
    listed = {name: (kind, way) for name, kind, way, _ in table(*TOPIC_TABLE)}
    of_actions = topics_of_actions({*listed, *ACTIONS_WITHOUT_TOPICS})
    assert listed | of_actions == expected
    assert not listed.keys() & of_actions.keys()


def test_topics_and_services_of_mapping_are_those_of_the_clone_of_a_new_map(graph: Graph) -> None:
    mapping = Graph()
    build_clone(mapping, None, model="turtlebot2", initial_pose=(0.0, 0.0, 0.0))
    mapping.add(lambda context: StopNode(context, mapping, "tb1"))
    mapping.add(lambda context: FootprintNode(context, mapping, lambda _: None))
    node = mapping.nodes["grid_slam"]
    published = {
        topic.name: (type_name(topic.type), ("both" if topic.robot_only else "out") + ", latched" * topic.latched)
        for topic in node.publishes
    }
    rows = table(PROTOCOL, "topic of mapping", "type", "direction", "rate and purpose")
    listed = {name: (kind, way) for name, kind, way, _ in rows}
    assert listed.items() <= published.items()
    assert published.keys() - graph.topics.keys() <= listed.keys()
    services = table(PROTOCOL, "service of mapping", "type", "what it does")
    assert {name: kind for name, kind, _ in services} == {service.name: service.type.name for service in node.services}
    lacking = {*graph.topics, *graph.services} - {*mapping.topics, *mapping.services}
    assert lacking == {
        "particlecloud", "amcl/status", "static_map", "global_localization", "request_nomotion_update",
        "keepout_filter_mask", "speed_filter_mask", "map_zones", "barometer", "find_floor",
    }  # fmt: skip


def test_topics_and_services_of_3d_maps_are_those_of_octomap_server(graph: Graph) -> None:
    making = Graph()
    build_clone(
        making, None, model="turtlebot2", initial_pose=(0.0, 0.0, 0.0), parameters={"depthimage_to_laserscan": {}}
    )
    node = making.nodes["octomap_server"]
    rows = table(PROTOCOL, "topic of 3D mapping", "type", "direction", "rate and purpose")
    listed = {name: (kind, way) for name, kind, way, _ in rows}
    expected = {
        topic.name: (type_name(topic.type), ("both" if topic.robot_only else "out") + ", latched")
        for topic in node.publishes
    } | {name: (type_name(making.topics[name].type), "in") for name in ("cloud_in", "camera/depth/image_raw")}
    assert listed == expected
    services = table(PROTOCOL, "service of 3D mapping", "type", "what it does")
    assert {name: kind for name, kind, _ in services} == {service.name: service.type.name for service in node.services}


def test_topics_and_parameters_of_paths_are_those_of_a_robot_that_follows_paths_itself(graph: Graph) -> None:
    following, layers = Graph(), build_layers(GridMap(np.zeros((40, 40), np.int8), GridInfo(0.05, 40, 40)))
    build_clone(following, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters={"follow_path": {}})
    node = following.nodes["move_base"]
    expected = {topic.name: (type_name(topic.type), "in") for topic in node.subscribes} | {
        topic.name: (type_name(topic.type), "out" + ", latched" * topic.latched) for topic in node.publishes
    }
    rows = table(PROTOCOL, "topic of paths", "type", "direction", "rate and purpose")
    listed = {name: (kind, way) for name, kind, way, _ in rows}
    assert listed == {name: each for name, each in expected.items() if name not in graph.topics}
    parameters = table(PROTOCOL, "parameter of `follow_path`", "default", "meaning")
    assert [name for name, *_ in parameters] == list(FollowPathParameters.__struct_fields__)
    assert [default for _, default, _ in parameters] == ["20", "0.5", "π"]


def test_topics_of_people_are_those_of_the_nodes_that_see_and_follow_them(graph: Graph) -> None:
    seeing, layers = Graph(), build_layers(GridMap(np.zeros((40, 40), np.int8), GridInfo(0.05, 40, 40)))
    names = ("torso_detector", "leg_detector", "follow_person")
    parameters: dict[str, object] = {name: {} for name in names}
    build_clone(seeing, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=parameters)
    taken = {topic.name for node in seeing.nodes.values() for topic in node.subscribes}
    given = {topic.name for node in seeing.nodes.values() for topic in node.publishes}
    expected = {}
    for topic in (topic for name, topic in seeing.topics.items() if name not in graph.topics and not topic.local):
        way = "both" if topic.robot_only or topic.name in taken & given else "in" if topic.name in taken else "out"
        expected[topic.name] = type_name(topic.type), way + ", latched" * topic.latched
    rows = table(PROTOCOL, "topic of people", "type", "direction", "rate and purpose")
    assert {name: (kind, way) for name, kind, way, _ in rows} == expected


def test_the_services_are_those_of_a_clone(graph: Graph) -> None:
    listed = table(PROTOCOL, "service", "type", "what it does")
    assert {name: kind for name, kind, _ in listed} == {s.name: s.type.name for s in graph.services.values()}


def test_recovery_behaviors_aliases_and_parameters_are_those_installed() -> None:
    listed = table(PROTOCOL, "type and aliases", "parameters")
    quoted = [[re.findall(r"`([^`]+)`", cell) for cell in row] for row in listed]
    assert {names[0] for names, _ in quoted} == set(recovery_names())
    for names, own in quoted:
        aliases = list(dict.fromkeys(each for each in RECOVERIES.spellings(names[0]) if re.search("[/:]", each)))
        of = RECOVERIES.create(names[0], {}).parameters  # type: ignore[attr-defined]
        assert (names[1:], set(own) - set(get_args(AffectedMaps))) == (aliases, set(of.__struct_fields__))
    default = [each.name for each in recovery_behaviors(MoveBaseParameters())]
    assert states(f"they are `{default[0]}`, `{default[1]}`, `{default[2]}` and `{default[3]}` again")


def test_numbers_of_waypoints_are_those_of_the_code() -> None:
    assert states(f"a list of 1 to {MAX_WAYPOINTS} `poses`")
    assert states(f"`loop_rate` ({WaypointFollowerParameters().loop_rate:g}) times a second")
    assert set(WaypointFollowerParameters.__struct_fields__) <= set(re.findall(r"`(\w+)`", text_of(PROTOCOL)))


def test_the_rosapi_services_are_those_of_the_code() -> None:
    [paragraph] = re.findall(r"Introspection\*\* follows rosapi.*?get_time`", text_of(PROTOCOL), re.DOTALL)
    assert {f"rosapi/{name}" for name in re.findall(r"`(\w+)`", paragraph)} - {f"rosapi/{DISTRIBUTION}"} == set(
        SERVICES
    )
    assert f"`get_ros_version` ({ROS_VERSION}, distribution" in paragraph


def test_errors_have_the_documented_status_and_type() -> None:
    by_slug = {kind.slug: kind for kind in STATUS}
    listed = table(PROTOCOL, "HTTP status", "type ends in", "cause")
    assert len(listed) > 5
    for status, slug, _ in listed:
        kind = by_slug[slug]
        error = kind.__new__(kind)
        Exception.__init__(error, "why")
        response = problem_response(error)
        assert (str(response.status_code), json.loads(response.body)["type"]) == (status, TYPE + slug)


def test_the_limits_are_those_of_the_code() -> None:
    limits = dict(table(PROTOCOL, "limit", "value"))
    assert limits["frame sent to the cloud"].startswith(f"{MAX_FRAME >> 20} MiB")
    assert f"within {MESSAGE_TIMEOUT:g} s" in limits["frame sent to the cloud"]
    frames = f"{FRAMES:g} a second, or {BYTES >> 20} MiB a second, or half the time"
    assert limits["frames of one socket"].startswith(frames) and BUSY == 0.5
    assert states(f"take the cloud more than {1000.0 * STALL:g} ms")
    assert states(f"{BURST:g} s of which it may use in advance") and states(f"After {OVERLOAD:g} s of that")
    fragments = f"{MAX_OPEN} frames, {MAX_SIZE >> 20} MiB"
    assert limits["fragments of incomplete frames per client"] == fragments
    assert limits["subscriptions per client"] == str(MAX_SUBSCRIPTIONS)
    assert limits["calls in progress per client"] == f"{MAX_CALLS}, each for up to {CALL_TIMEOUT:g} s"
    assert limits["goals in progress per client"] == str(MAX_GOALS)
    things = f"{MAX_TOPICS} topics, {MAX_SERVICES} services, {MAX_ACTIONS} actions"
    offered = f"{things}, {MAX_LATCHED_BYTES >> 20} MiB of latched messages"
    assert limits["offered by the clients of a robot"] == offered
    waiting = f"{MAX_UNACKNOWLEDGED}, and {MAX_UNACKNOWLEDGED_BYTES >> 20} MiB"
    assert limits["unacknowledged messages per robot"] == waiting
    streams = f"{MAX_STREAMS} topics and goals per robot; {MAX_SOURCES} frames each, {MIN_RATE:g} to {MAX_RATE:g} times"
    assert limits["transform streams for web pages"].startswith(streams)
    assert limits["free parameters per robot"] == f"{MAX_FREE}, and {MAX_FREE_BYTES >> 10} KiB in all"
    assert limits["ranges per scan"] == str(MAX_RANGES)
    assert limits["name of a topic"] == f"{MAX_NAME} characters"
    rest = RequestLimits()
    own, planned = MoveBaseParameters().planner_timeout, f"{DEFAULT_TIMEOUT:g} s"
    assert limits["planning time"].startswith(f"{own:g} s")
    assert limits["planning time"].endswith(f"{planned}, or its `timeout` up to {rest.max_plan_seconds:g} s")


def test_the_actions_are_those_of_a_clone(graph: Graph) -> None:
    listed = table(PROTOCOL, "action", "type", "types of goal, feedback and result", "what it does")
    types = {topic.name: type_name(topic.type) for topic in graph.topics.values()}
    assert sorted(name for name, *_ in listed) == actions(types)
    for name, kinds, *_ in listed:
        for kind in kinds.replace("`", "").split(" or "):
            assert find_action(name, kind, types)
    assert [ros2_status(s) for s in (Status.SUCCEEDED, Status.PREEMPTED, Status.ABORTED)] == [4, 5, 6]
    assert states(f"once {MIN_LISTS} lists in a row, over {SETTLED:g} s, do not show it as active")
    assert states(f"`error_code`, {NAV2_UNKNOWN} for all failures")


def test_queue_depths_for_slow_clients_are_those_of_the_code() -> None:
    kept = dict(table(PROTOCOL, "limit", "value"))["queued messages per topic for a slow client"]
    first, *others = kept.split("; ")
    assert first == f"{DEFAULT_DEPTH}, or its `queue_length` up to {MAX_KEEP}"
    depths = {name: int(part.split()[0]) for part in others for name in re.findall(r"`([\w/]+)`", part)}
    assert depths == {topic.name: topic.depth for topic in TOPICS.values() if topic.depth != DEFAULT_DEPTH}


def test_times_and_rates_are_those_of_the_code() -> None:
    amcl, move_base, rates = AmclParameters(), MoveBaseParameters(), SensorRates()
    assert states(f"no container became ready within {READY_TIMEOUT:g} s")
    assert states(f"waited {CMD_VEL.expiry:g} s for a slow connection")
    assert states(f"no `cmd_vel` has come for {BaseLimits().timeout:g} s")
    assert states(f"kept for {LINGER:g} s after its last client left")
    assert states(f"moved {amcl.update_min_d:g} m or {amcl.update_min_a:g} rad")
    assert states(f"publishes it at {rates.odom:g} Hz") and states(f"publishes it at {rates.scan:g} Hz")
    assert states(f"{move_base.controller_frequency:g} Hz while it drives")
    assert states(f"After {move_base.transform_tolerance:g} s without `odom` or `scan`")
    assert STATUS_PERIOD == 1.0 and states("once a second, and when it changes")
    assert move_base.planner_frequency == 1.0 and states("and once a second while driving")
    assert (1.0 / SHARE_PERIOD, 1.0 / fleet_topics.PERIOD) == (5.0, 10.0) and states("five to ten times a second")
    assert states(f"code {CLOSED_BY_CLOUD} and a reason")
    assert states(f"after {MAX_PATIENCE:g} s without subscribers to this topic")
    assert states(f"after `timeout` ({MIN_PATIENCE:g} to {MAX_PATIENCE:g} s) without subscribers")


def test_times_and_limits_of_sessions_are_those_of_the_code() -> None:
    parser = CommandParser()
    up.configure(parser)
    options = parser.parse_args([])
    assert options.linger == LINGER
    assert options.idle == IDLE and states(f"say nothing for {IDLE:g} s (`ppaas up --idle`")
    assert states(f"dead within {options.dead:g} s (`ppaas up --dead`)")
    assert states(f"every {options.dead / 3.0:g} s (a third of `--dead`)")
    assert states(f"`/{HEARTBEAT}` (`{OWN_TOPICS[HEARTBEAT]}`)") and HEARTBEAT_PERIOD == 1.0
    assert states(f"`/{PRESENCE}` (`{OWN_TOPICS[PRESENCE]}`, latched)")
    assert states(f"silent for {PROBE_TIMEOUT:g} s")
    assert states(f"closed with code {TAKEN_OVER}")
    assert states(f"the last {MAX_SENT} such frames, and {MAX_SENT_BYTES >> 20} MiB")
    limits = dict(table(PROTOCOL, "limit", "value"))
    assert limits["queued bytes per client"].startswith(f"{MAX_BYTES >> 20} MiB; ")
    assert limits["detached sessions per user"].startswith(f"{MAX_AWAY}; ")
    headers = [header for header, _ in table(PROTOCOL, "header", "content")]
    assert headers[:3] == [STATE_HEADER, ID_HEADER, TAKEN_HEADER]


def test_roles_and_status_numbers_are_those_of_the_code() -> None:
    [sensors] = re.findall(r"\n(.*) may be published only by the robot", text_of(PROTOCOL))
    assert set(re.findall(r"`([\w/]+)`", sensors)) == {topic.name for topic in TOPICS.values() if topic.robot_only}
    assert states(
        f"is {Status.SUCCEEDED:d} when the robot has reached the goal, {Status.ABORTED:d} when Move Base gave up, "
    )
    assert states(f"and {Status.PREEMPTED:d} when another goal or a cancel")


def test_every_frame_of_the_page_is_valid() -> None:
    robot, operator, cloud = (block.splitlines() for block in blocks(PROTOCOL, "json"))
    for frame in (*robot, *operator):
        assert not isinstance(RosbridgeSession().receive(frame), RefusedOperation)
    for frame in cloud:
        RosbridgeClientSession().receive(frame)


@pytest.fixture
async def address(cloud: RunningCloud) -> str:
    """Return the URL for a robot on the example's map, with a token, as clients that cannot set headers send it."""
    rest = await cloud.admin()
    await rest.upload_map("office", *((EXAMPLES / f"office.{kind}").read_bytes() for kind in ("yaml", "pgm")))
    await rest.put_robot("tb2", load_robot_file(EXAMPLES / "tb1.json"))
    [url] = re.findall(r"^ws://\S+$", text_of(PROTOCOL), re.MULTILINE)
    return f"{url.replace('ws://HOST:8500', cloud.ws_url).replace('robot=ID', 'robot=tb2')}&token={rest.token}"


async def next_frame(socket: ClientConnection) -> dict[str, object]:
    """Return the next frame."""
    async with patience(30):
        frame: dict[str, object] = json.loads(await socket.recv())
        return frame


async def until(socket: ClientConnection, op: str) -> dict[str, object]:
    """Return the next frame of an operation; a ``status`` that comes before it fails the test."""
    while True:
        frame = await next_frame(socket)
        assert frame["op"] in (op, "publish"), frame
        if frame["op"] == op:
            return frame


@pytest.mark.journey
async def test_a_cloud_accepts_the_frames_of_the_page(address: str) -> None:
    robot_frames, operator_frames, _ = (block.splitlines() for block in blocks(PROTOCOL, "json"))
    as_operator = address.replace("role=robot", "role=operator")
    async with connect(address, max_size=None) as robot, connect(as_operator, max_size=None) as operator:
        for frame in robot_frames:
            await robot.send(frame)
        for frame in operator_frames:
            await operator.send(frame)
        frames = [await next_frame(operator), await next_frame(operator)]  # it plans meanwhile: either may come first
        result, answer = sorted(frames, key=lambda frame: str(frame["op"]))
        assert (result["op"], result.get("topic")) == ("publish", "/move_base/result")
        assert (answer.get("id"), answer.get("result")) == ("7", True), answer
        # Errors of earlier frames are sent before the answer of a call, so by now one would have arrived.
        await robot.send('{"op": "call_service", "service": "/move_base/clear_costmaps", "id": "8"}')
        assert (await until(robot, "service_response"))["result"] is True


@pytest.mark.journey
async def test_an_oversized_frame_closes_the_socket_as_described(address: str) -> None:
    async with connect(address, max_size=None) as socket:
        with pytest.raises(ConnectionClosed) as closed:
            await socket.send("x" * (MAX_FRAME + 1))
            await socket.recv()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1009
    assert states("closes the socket (1009)")
