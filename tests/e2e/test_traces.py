"""Traces of a real cloud at a real receiver: a path request, and goals of REST and of a client of the robot."""

import json
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from websockets.asyncio.client import connect

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages import encode
from ppaas.messages.geometry_msgs import Pose
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.network.trace_receiver import ReceivedSpan, TraceReceiver, trace_receiver
from tests.support.waiting import PATIENCE, until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

CLIENT = "b7ad6b7169203331"
PLAN, REST_GOAL, SOCKET_GOAL = (f"{number}af7651916cd43dd8448eb211c80319c" for number in (1, 2, 3))


def parent_of(trace: str) -> str:
    return f"00-{trace}-{CLIENT}-01"


@pytest.fixture(scope="module")
def receiver() -> Iterator[TraceReceiver]:
    with trace_receiver() as running:
        yield running


@pytest.fixture(scope="module")
def cloud(tmp_path_factory: pytest.TempPathFactory, receiver: TraceReceiver) -> Iterator[RunningCloud]:
    with running_cloud(tmp_path_factory.mktemp("traces"), "--traces", receiver.url, "--log-format", "json") as running:
        yield running


async def post(cloud: RunningCloud, path: str, body: dict[str, Any], trace: str) -> dict[str, Any]:
    headers = {"Authorization": f"Bearer {cloud.token}", "traceparent": parent_of(trace)}
    async with httpx.AsyncClient(base_url=cloud.url, timeout=PATIENCE, headers=headers) as client:
        answer = await client.post(path, json=body)
    answer.raise_for_status()
    return dict(answer.json())


def by_name(spans: list[ReceivedSpan]) -> dict[str, ReceivedSpan]:
    """Return one span of each name; check that all hang together below the client."""
    known = {span.id for span in spans} | {CLIENT}
    assert all(span.parent in known for span in spans)
    return {span.name: span for span in spans}


async def test_a_path_request_is_one_trace_from_the_client_to_kernel_and_store(
    cloud: RunningCloud, receiver: TraceReceiver, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=1)
    goal = reachable_pose(office_map, start, seed=11, at_least=2.0)
    body = {"start": list(start), "goal": list(goal), "planner": "navfn"}
    answer = await post(cloud, "/v1/maps/office/plans", body, PLAN)
    request = "POST /v1/maps/{map_id}/plans"
    names = (request, "service compute_packed_path", "plan", "computation", "storage of a plan", "store add_plans")
    found = by_name(await receiver.whole(PLAN, *names))
    assert found[request].parent == CLIENT
    assert [found[name].service for name in names] == [
        "ppaas-endpoint", "ppaas-container", "ppaas-container", "ppaas-container", "ppaas-endpoint", "ppaas-endpoint",
    ]  # fmt: skip
    assert found["computation"].process == answer["container"]
    assert found["computation"].parent == found["plan"].id
    assert found["plan"].parent == found["service compute_packed_path"].id
    assert found["plan"].attributes["ppaas.planner"] == "navfn"


def goal_frame(goal: Pose2D, trace: str) -> str:
    pose = {"header": {"frame_id": "map"}, "pose": json.loads(encode(Pose.of(goal)))}
    return json.dumps({
        "op": "send_action_goal", "id": "g1", "action": "/navigate_to_pose", "traceparent": parent_of(trace),
        "action_type": "nav2_msgs/action/NavigateToPose", "args": {"pose": pose},
    })  # fmt: skip


async def test_a_goal_is_one_trace_from_the_client_to_kernel_and_store(
    cloud: RunningCloud, receiver: TraceReceiver, office_map: GridMap
) -> None:
    rest, start = await cloud.admin(), free_pose(office_map, seed=1)
    await publish_map(rest, "hall", office_map)
    token = await register_robot(rest, "tb1", "hall", start)
    goal, other = (reachable_pose(office_map, start, seed=seed, at_least=2.0) for seed in (11, 12))
    async with driving(cloud.url, token, "tb1", office_map, start):
        sent = await post(cloud, "/v1/robots/tb1/goals", {"pose": list(goal)}, REST_GOAL)
        planned = "plan", "computation", "store add_plan"
        await receiver.whole(REST_GOAL, *planned)
        async with connect(f"{cloud.ws_url}/?robot=tb1&role=operator&token={token}") as socket:
            await socket.send(goal_frame(other, SOCKET_GOAL))
            await receiver.whole(SOCKET_GOAL, *planned)
    request = "POST /v1/robots/{robot_id}/goals"
    found = by_name(await receiver.whole(REST_GOAL, request, "RobotCalls.send_goal", "goal", *planned))
    assert [found[name].service for name in (request, "RobotCalls.send_goal", "goal", "store add_plan")] == [
        "ppaas-endpoint", "ppaas-master", "ppaas-container", "ppaas-machine",
    ]  # fmt: skip
    assert found["goal"].parent == found["RobotCalls.send_goal"].id
    assert found["goal"].attributes["ppaas.goal"] == sent["id"]
    assert found["goal"].attributes["ppaas.goal.status"] in ("preempted", "succeeded")
    assert found["plan"].parent == found["goal"].id


async def test_the_log_names_the_trace_of_a_request(cloud: RunningCloud) -> None:
    await cloud.admin()
    with pytest.raises(httpx.HTTPStatusError):
        await post(cloud, "/v1/maps/nowhere/plans", {"start": [0, 0], "goal": [1, 1]}, "4" * 32)

    def named() -> list[dict[str, Any]]:
        records = map(json.loads, cloud.log.read_text().splitlines())
        return [record for record in records if record.get("trace_id") == "4" * 32]

    await until(named)
    assert {record["level"] for record in named()} == {"INFO"}
