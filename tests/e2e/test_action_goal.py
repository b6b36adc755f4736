"""A goal sent as an action of ROS 2, by frames alone, while the container that drives dies and others send rubbish."""

import asyncio
import itertools
import json

import pytest
from websockets.asyncio.client import ClientConnection, connect

from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridMap
from ppaas.messages import encode
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav2_msgs import FollowWaypointsActionFeedback, FollowWaypointsActionResult
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.waiting import patience, until
from tests.support.world.places import free_pose, reachable_pose
from tests.support.world.touring import waypoints

pytestmark = pytest.mark.journey

SUCCEEDED = 4
RUBBISH = (
    '{"op": "publish"',
    "[]",
    '{"op": "no such"}',
    '{"op": "publish", "topic": "/cmd_vel", "msg": {"linear": []}}',
)


def goal_frame(goal: Pose2D) -> str:
    pose = {"header": {"frame_id": "map"}, "pose": json.loads(encode(Pose.of(goal)))}
    return json.dumps({
        "op": "send_action_goal", "id": "g1", "action": "/navigate_to_pose", "feedback": True,
        "action_type": "nav2_msgs/action/NavigateToPose", "args": {"pose": pose},
    })  # fmt: skip


async def frames_until(socket: ClientConnection, operation: str) -> list[dict]:
    heard: list[dict] = []
    async with patience(90):
        while not heard or heard[-1]["op"] != operation:
            heard.append(json.loads(await socket.recv()))
    return heard


async def send_rubbish(url: str) -> None:
    async with connect(url) as socket:
        for frame in itertools.cycle(RUBBISH):
            await socket.send(frame)
            await asyncio.sleep(0.005)


async def test_action_goal_ends_once_despite_a_killed_container_and_rubbish(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=21)
    goal = reachable_pose(office_map, start, seed=22, at_least=2.0, at_most=4.0)
    token = await register_robot(rest, "actor", "office", start)
    url = f"{cloud.ws_url}/?robot=actor&role=operator&token={token}"
    async with driving(cloud.url, token, "actor", office_map, start) as drive, connect(url) as operator:
        rubbish = asyncio.create_task(send_rubbish(url))
        await operator.send(goal_frame(goal))
        await frames_until(operator, "action_feedback")
        cloud.container().kill()
        *feedback, result = await frames_until(operator, "action_result")
        assert (result["id"], result["action"], result["status"], result["result"]) == (
            "g1", "/navigate_to_pose", SUCCEEDED, True,
        )  # fmt: skip
        assert {frame["op"] for frame in feedback} == {"action_feedback"}
        assert drive.scorer.error(0, goal) <= 0.3
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(1.5):  # longer than the status period of Move Base
                await operator.recv()
        assert not rubbish.done()
        assert drive.robot.connections == 1
        rubbish.cancel()


PASSWORD = "correct horse"


async def test_a_queued_path_is_planned_when_its_turn_comes(cloud: RunningCloud, office_map: GridMap) -> None:
    admin = await cloud.admin()
    await admin.post("/v1/users", {"id": "quinn", "password": PASSWORD})
    await admin.patch("/v1/users/quinn", {"limits": {"containers": 1}})
    login = await RestClient(cloud.url).login("quinn", PASSWORD)
    rest = RestClient(cloud.url, login.token)
    for name in ("q1", "q2"):
        await publish_map(rest, name, office_map)
    start = free_pose(office_map, seed=40)
    goal = reachable_pose(office_map, start, seed=41, at_least=4.0)
    await rest.plan("q1", start, goal)
    body = {"start": [start.x, start.y], "goal": [goal.x, goal.y]}
    with pytest.raises(QuotaExceeded, match="1 containers and has 1"):
        await rest.post("/v1/maps/q2/plans", body)
    waits = await rest.post("/v1/maps/q2/plans", body | {"queue": True})
    assert waits["position"] == 1
    await admin.patch("/v1/users/quinn", {"limits": {"containers": 2}})
    async with patience(20):
        while "poses" not in (answer := await rest.post("/v1/maps/q2/plans", body | {"queue": True})):
            assert answer["position"] == 1
            await asyncio.sleep(0.02)


async def test_waypoints_are_followed_to_the_end_despite_a_killed_container(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=11)
    # Turns in place exercise the list like drives do, and are done sooner.
    first, last = (Pose2D(*start) @ Pose2D(0.0, 0.0, turn) for turn in (0.6, -1.5))
    token = await register_robot(rest, "postman", "office", start)
    reported: list[int] = []
    results: asyncio.Queue[FollowWaypointsActionResult] = asyncio.Queue()
    async with driving(cloud.url, token, "postman", office_map, start) as drive:
        await drive.operator.subscribe(
            "follow_waypoints/feedback",
            FollowWaypointsActionFeedback,
            lambda message: reported.append(message.feedback.current_waypoint),
        )
        await drive.operator.subscribe("follow_waypoints/result", FollowWaypointsActionResult, results.put_nowait)
        await drive.operator.publish("follow_waypoints/goal", waypoints([first, last], "round"))
        await until(lambda: 1 in reported)
        cloud.container().kill()
        async with patience(60):
            result = await results.get()
        assert (result.status.goal_id.id, result.status.status) == ("round", Status.SUCCEEDED), result.status.text
        assert abs(wrap_angle(drive.world.robots[0].base.pose.theta - last.theta)) <= 0.3
        assert drive.robot.connections == 1
        reported_after = reported[reported.index(1) :]
        assert set(reported_after) == {1}, "no waypoint is driven to twice"
        assert results.empty()
