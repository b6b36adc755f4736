"""Invalid input is reported to its sender, logged, and disturbs no other client; over real sockets."""

import json
from collections.abc import AsyncIterator
from typing import Any

import pytest
import websockets
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from ppaas.errors import Conflict, InvalidMap, InvalidRobot, NotAuthenticated, NotFound, PPaaSError
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.grid import GridMap
from robots.client.rest import RestClient
from tests.support.budget import examples
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.endpoints.any_frame import FRAME
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

GOAL = "move_base_simple/goal"


class Bystander:
    """A well-behaved operator that must be served whatever others do."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket

    async def is_served(self) -> bool:
        args = {"start": stamped(1.0, 1.0), "goal": stamped(1.0, 1.0)}
        answer = await ask(self._socket, "move_base/make_plan", args)
        return answer["op"] == "service_response"


def stamped(x: Any, y: Any, **orientation: float) -> dict[str, Any]:
    return {
        "header": {"frame_id": "map"},
        "pose": {"position": {"x": x, "y": y}, "orientation": orientation or {"z": 0.0, "w": 1.0}},
    }


async def send(socket: ClientConnection, **frame: Any) -> None:
    await socket.send(json.dumps(frame))


async def next_frame(socket: ClientConnection, op: str) -> dict[str, Any]:
    while True:
        received = await socket.recv()
        if isinstance(received, str):  # binary ones are messages in CBOR
            frame: dict[str, Any] = json.loads(received)
            if frame["op"] == op:
                return frame


async def ask(socket: ClientConnection, service: str, args: Any) -> dict[str, Any]:
    await send(socket, op="call_service", service=service, args=args, id="q")
    return await next_frame(socket, "service_response")


async def refusal(url: str) -> tuple[int, dict[str, Any]]:
    """Return the HTTP status and the problem of a connection that must be refused."""
    with pytest.raises(InvalidStatus) as refused:
        await connect(url)
    response = refused.value.response
    return response.status_code, json.loads(response.body or b"{}")


@pytest.fixture
async def token(cloud: RunningCloud, office_map: GridMap) -> str:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    return await register_robot(rest, "victim", "office", tuple(free_pose(office_map, seed=1)))


@pytest.fixture
async def operator(cloud: RunningCloud, token: str) -> AsyncIterator[ClientConnection]:
    url = f"{cloud.ws_url}/?robot=victim&token={token}&role=operator&status=1"
    async with connect(url, max_size=None) as socket:
        yield socket


@pytest.fixture
async def bystander(cloud: RunningCloud, token: str) -> AsyncIterator[Bystander]:
    url = f"{cloud.ws_url}/?robot=victim&token={token}&role=operator"
    async with connect(url, max_size=None) as socket:
        yield Bystander(socket)


async def test_a_wrong_password_is_not_authenticated(cloud: RunningCloud) -> None:
    with pytest.raises(NotAuthenticated):
        await RestClient(cloud.url).login("admin", "not the password")
    with pytest.raises(NotAuthenticated):
        await RestClient(cloud.url).login("nobody", "not the password")


async def test_a_wrong_or_missing_token_is_refused_at_the_handshake(cloud: RunningCloud, token: str) -> None:
    for query in ("robot=victim&token=wrong", "robot=victim"):
        status, problem = await refusal(f"{cloud.ws_url}/?{query}")
        assert status == 401
        assert problem["type"].endswith("not-authenticated")


async def test_an_unknown_robot_is_refused_at_the_handshake(cloud: RunningCloud, token: str) -> None:
    status, problem = await refusal(f"{cloud.ws_url}/?robot=ghost&token={token}")
    assert status == 404
    assert "ghost" in problem["detail"]


async def test_an_unknown_role_and_a_missing_robot_are_refused(
    cloud: RunningCloud, token: str, office_map: GridMap
) -> None:
    await put_robot_with(RestClient(cloud.url, token), "second", tuple(free_pose(office_map, seed=1)))
    assert (await refusal(f"{cloud.ws_url}/?robot=victim&token={token}&role=god"))[0] == 422
    assert (await refusal(f"{cloud.ws_url}/?token={token}"))[0] == 422


async def test_a_robot_on_an_unknown_map_is_refused(cloud: RunningCloud, token: str) -> None:
    rest = RestClient(cloud.url, token)
    with pytest.raises(NotFound, match="atlantis"):
        await register_robot(rest, "lost", "atlantis", (0.0, 0.0, 0.0))


async def test_an_unknown_model_is_refused_with_the_robot_file(
    cloud: RunningCloud, token: str, office_map: GridMap
) -> None:
    rest = RestClient(cloud.url, token)
    pose = tuple(free_pose(office_map, seed=1))
    with pytest.raises(InvalidRobot, match="'submarine'; known: turtlebot2,"):
        await put_robot_with(rest, "odd", pose, model="submarine")
    status, problem = await refusal(f"{cloud.ws_url}/?robot=odd&token={token}")
    assert (status, problem["detail"]) == (404, "unknown robot 'odd'")


async def put_robot_with(rest: RestClient, robot: str, pose: tuple[float, ...], **fields: Any) -> None:
    from robots.client.robot_file import RobotFile

    await rest.put_robot(robot, RobotFile(map="office", initial_pose=pose, **fields))  # type: ignore[arg-type]


async def test_a_second_robot_socket_is_refused_and_the_first_stays_open(cloud: RunningCloud, token: str) -> None:
    url = f"{cloud.ws_url}/?robot=victim&token={token}"
    async with connect(url, max_size=None) as first:
        status, problem = await refusal(url)
        assert status == 409
        assert "connected already" in problem["detail"]
        answer = await ask(first, "move_base/make_plan", {"start": stamped(1.0, 1.0), "goal": stamped(1.0, 1.0)})
        assert answer["op"] == "service_response"


BAD_GOALS = {
    "NaN": (stamped(float("nan"), 1.0), "malformed-message"),
    "null": (stamped(None, 1.0), "malformed-message"),
    "missing orientation": (
        {"header": {"frame_id": "map"}, "pose": {"position": {"x": 1, "y": 1}}},
        "invalid-input: the orientation of a goal is all zero",
    ),
    "missing pose": ({"header": {"frame_id": "map"}}, "invalid-input: the orientation of a goal is all zero"),
    "empty": ({}, "invalid-input: the orientation of a goal is all zero"),
    "missing header": (
        {"pose": {"position": {"x": 1, "y": 1}, "orientation": {"w": 1}}},
        "invalid-input: a goal needs header.frame_id",
    ),
    "an unknown field": (
        stamped(1.0, 1.0) | {"frame_id": "map"},
        "malformed-message: not a PoseStamped: PoseStamped has",
    ),
    "a list": ([], "malformed-message"),
    "text for a number": (stamped("here", 1.0), "malformed-message"),
    "a quaternion of zeros": (stamped(1.0, 1.0, z=0.0, w=0.0), "invalid-input"),
    "beyond float": (stamped(1e400, 1.0), "malformed-message"),
}


@pytest.mark.parametrize("name", BAD_GOALS)
async def test_a_bad_goal_is_reported_to_its_sender_only(
    name: str, operator: ClientConnection, bystander: Bystander
) -> None:
    message, slug = BAD_GOALS[name]
    await send(operator, op="publish", topic=GOAL, msg=message)
    status = await next_frame(operator, "status")
    assert status["msg"].startswith(slug), status
    assert await bystander.is_served()


async def test_a_goal_in_an_unknown_frame_is_reported(operator: ClientConnection, bystander: Bystander) -> None:
    goal = stamped(1.0, 1.0) | {"header": {"frame_id": "moon"}}
    await send(operator, op="publish", topic=GOAL, msg=goal)
    assert "moon" in (await next_frame(operator, "status"))["msg"]
    assert await bystander.is_served()


@pytest.mark.parametrize(
    "frame",
    ["", "{", "[]", '{"op":"fly"}', '{"op":"publish","msg":{}}', "\x00\x01", "[" * 10_000],
)
async def test_malformed_frames_are_reported_and_the_socket_stays_open(frame: str, operator: ClientConnection) -> None:
    await operator.send(frame)
    assert (await next_frame(operator, "status"))["msg"].startswith("malformed-message")
    await operator.send(b"\x80binary\xff")
    assert "binary" in (await next_frame(operator, "status"))["msg"]


async def test_an_operator_may_not_publish_sensor_data(operator: ClientConnection) -> None:
    for topic in ("scan", "/odom"):
        await send(operator, op="publish", topic=topic, msg={})
        assert (await next_frame(operator, "status"))["msg"].startswith("not-permitted")


async def test_unknown_topics_services_and_types_are_not_found(operator: ClientConnection) -> None:
    await send(operator, op="publish", topic="nothing", msg={})
    assert (await next_frame(operator, "status"))["msg"].startswith("not-found")
    await send(operator, op="advertise", topic="x", type="Thing")
    assert (await next_frame(operator, "status"))["msg"].startswith("unknown-type")
    await send(operator, op="advertise", topic="map", type="no_msgs/Thing")
    assert (await next_frame(operator, "status"))["msg"].startswith("conflict")
    answer = await ask(operator, "/fly", {})
    assert answer["result"] is False and "fly" in answer["values"]


@settings(max_examples=examples(4), suppress_health_check=list(HealthCheck), database=None)
@given(st.lists(FRAME, min_size=100, max_size=100))
async def test_frames_of_one_client_do_not_disturb_another(
    cloud: RunningCloud, token: str, frames: list[str | bytes]
) -> None:
    url = f"{cloud.ws_url}/?robot=victim&token={token}&role=operator"
    async with connect(url, max_size=None) as careless, connect(url, max_size=None) as socket:
        await send(socket, op="subscribe", topic="map", type="nav_msgs/OccupancyGrid")
        for frame in frames:
            content = frame.encode(errors="replace") if isinstance(frame, str) else frame
            await careless.send(content or b"\x00", text=isinstance(frame, str))
        assert await Bystander(socket).is_served()
        await send(careless, op="call_service", service="/rosapi/get_time", id="last")
        while (await next_frame(careless, "service_response"))["id"] != "last":
            pass


async def test_a_frame_of_100_mb_closes_only_its_own_socket(
    cloud: RunningCloud, token: str, bystander: Bystander
) -> None:
    url = f"{cloud.ws_url}/?robot=victim&token={token}&role=operator"
    socket = await connect(url, max_size=None)
    with pytest.raises(ConnectionClosed) as closed:
        await socket.send("x" * 100_000_000)
        await socket.recv()
    assert isinstance(closed.value, websockets.ConnectionClosed)
    await socket.close()
    assert await bystander.is_served()


@pytest.mark.parametrize(
    ("yaml", "image"),
    [
        (b"image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", b"P5\n10 10\n255\nshort"),
        (b"image: m.pgm\nresolution: -1\norigin: [0, 0, 0]\n", b"P5\n1 1\n255\n\xff"),
        (b"image: m.pgm\norigin: [0, 0, 0]\n", b"P5\n1 1\n255\n\xff"),
        (b": : :\n\t-", b"P5\n1 1\n255\n\xff"),
        (b"\xff\xfe", b"\x00"),
        (b"", b""),
    ],
)
async def test_a_broken_map_is_refused(cloud: RunningCloud, yaml: bytes, image: bytes) -> None:
    rest = await cloud.admin()
    with pytest.raises(PPaaSError) as refused:
        await rest.upload_map("broken", yaml, image)
    assert isinstance(refused.value, InvalidMap), refused.value


async def test_a_map_of_another_user_is_neither_visible_nor_writable(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "private", office_map)
    await rest.post("/v1/users", {"id": "mallory", "password": "mallory's password"})
    mallory = RestClient(cloud.url)
    await mallory.login("mallory", "mallory's password")
    with pytest.raises(NotFound):
        await register_robot(mallory, "spy", "private", (1.0, 1.0, 0.0))
    yaml, image = save_map(office_map, "private.pgm")
    with pytest.raises((NotFound, Conflict, PPaaSError)):
        await mallory.upload_map("private", yaml, image)
