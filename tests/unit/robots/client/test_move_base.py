import asyncio
import math
from collections.abc import AsyncIterator
from typing import Any

import pytest

from ppaas.clock import monotonic
from ppaas.errors import NotFound, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Bool, Header
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.navigation.goal_watch import MIN_LISTS, SETTLED
from robots.client.move_base import GoalOutcome, MoveBaseClient, TrackedGoal
from robots.client.robot_client import RobotClient
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server

POSE = {"position": {"x": 1.0, "y": 2.0}, "orientation": {"z": 0.0, "w": 1.0}}


@pytest.fixture
async def server() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        yield running


async def say_plan(server: RosbridgeServer, poses: int) -> None:
    await server.say(op="publish", topic="plan", msg={"header": {}, "poses": [{"header": {}, "pose": POSE}] * poses})


async def say_result(server: RosbridgeServer, goal_id: str, status: Status, text: str = "") -> None:
    message: dict[str, Any] = {"header": {}, "status": {"goal_id": {"id": goal_id}, "status": status, "text": text}}
    await server.say(op="publish", topic="move_base/result", msg=message)


async def say_statuses(server: RosbridgeServer, *listed: tuple[str, Status, str]) -> None:
    statuses = [{"goal_id": {"id": goal_id}, "status": status, "text": text} for goal_id, status, text in listed]
    await server.say(op="publish", topic="move_base/status", msg={"header": {}, "status_list": statuses})


class LeapingClock:
    """A clock that advances each time it is read."""

    def __init__(self, leap: float) -> None:
        self.now, self.leap = 0.0, leap

    def __call__(self) -> float:
        self.now += self.leap
        return self.now


async def follow(server: RosbridgeServer, act: Any, timeout: float = 10.0, leap: float = 0.0) -> GoalOutcome:
    """Send a goal, let the server act on its frame, and return the outcome."""
    async with RobotClient(server.url, robot="tb1", token="t", role="operator") as client:
        move_base = await MoveBaseClient(client, LeapingClock(leap) if leap else monotonic).start()
        going = asyncio.create_task(move_base.go(Pose2D(3.0, -1.0, math.pi / 2), timeout))
        [frame] = await server.heard("publish")
        await act(frame)
        return await asyncio.wait_for(going, 20)


async def test_a_goal_has_its_own_id_and_the_map_frame(server: RosbridgeServer) -> None:
    async def act(frame: dict[str, Any]) -> None:
        assert frame["topic"] == "move_base/goal"
        target = frame["msg"]["goal"]["target_pose"]
        assert target["header"]["frame_id"] == "map"
        assert target["pose"]["position"] == {"x": 3.0, "y": -1.0, "z": 0.0}
        assert target["pose"]["orientation"]["z"] == pytest.approx(math.sin(math.pi / 4))
        await say_plan(server, 2)
        await say_result(server, frame["msg"]["goal_id"]["id"], Status.SUCCEEDED, "Goal reached.")

    outcome = await follow(server, act)
    assert outcome.reached
    assert outcome.text == "Goal reached."
    assert 0.0 < outcome.plan_seconds <= outcome.seconds


async def test_the_result_of_another_goal_is_ignored(server: RosbridgeServer) -> None:
    async def act(frame: dict[str, Any]) -> None:
        await say_result(server, "somebody else's", Status.SUCCEEDED)
        await say_plan(server, 0)
        await say_result(server, frame["msg"]["goal_id"]["id"], Status.ABORTED, "no way")

    outcome = await follow(server, act)
    assert (outcome.status, outcome.text) == (Status.ABORTED, "no way")
    assert math.isnan(outcome.plan_seconds)


async def test_a_goal_without_a_result_is_cancelled_and_lost(server: RosbridgeServer) -> None:
    async def act(frame: dict[str, Any]) -> None:
        _, cancel = await server.heard("publish", 2)
        assert cancel["topic"] == "move_base/cancel"
        assert cancel["msg"]["id"] == frame["msg"]["goal_id"]["id"]

    outcome = await follow(server, act, timeout=0.1)
    assert outcome.status is Status.LOST
    assert not outcome.reached


async def test_only_the_own_goal_is_cancelled_and_only_while_it_has_no_outcome(server: RosbridgeServer) -> None:
    async with RobotClient(server.url, robot="tb1", token="t", role="operator") as client:
        move_base = await MoveBaseClient(client).start()
        await move_base.cancel()
        going = asyncio.create_task(move_base.go(Pose2D(3.0, -1.0)))
        [goal] = await server.heard("publish")
        await move_base.cancel()
        _, cancel = await server.heard("publish", 2)
        mine = goal["msg"]["goal_id"]["id"]
        assert (cancel["topic"], cancel["msg"]["id"]) == ("move_base/cancel", mine)
        await say_result(server, mine, Status.PREEMPTED)
        assert (await asyncio.wait_for(going, 20)).status is Status.PREEMPTED
        await move_base.cancel()
        await client.publish("end", Bool(data=True))
        *_, last = await server.heard("publish", 3)
        assert last["topic"] == "end"


async def test_the_status_list_ends_a_goal_whose_result_was_lost(server: RosbridgeServer) -> None:
    async def act(frame: dict[str, Any]) -> None:
        mine = frame["msg"]["goal_id"]["id"]
        for _ in range(MIN_LISTS):
            await say_statuses(server, ("another", Status.ACTIVE, ""), (mine, Status.ABORTED, "no way"))

    outcome = await follow(server, act, leap=6.0)
    assert (outcome.status, outcome.text) == (Status.ABORTED, "no way")


async def test_a_goal_missing_from_the_status_lists_is_cancelled_and_lost(server: RosbridgeServer) -> None:
    async def act(frame: dict[str, Any]) -> None:
        mine = frame["msg"]["goal_id"]["id"]
        await say_statuses(server, (mine, Status.ACTIVE, ""))
        for _ in range(5):
            await say_statuses(server, ("another", Status.ACTIVE, ""))
        _, cancel = await server.heard("publish", 2)
        assert (cancel["topic"], cancel["msg"]["id"]) == ("move_base/cancel", mine)

    outcome = await follow(server, act, leap=3.0)
    assert outcome.status is Status.LOST
    assert "send it again" in outcome.text


async def test_a_goal_in_the_status_lists_is_awaited(server: RosbridgeServer) -> None:
    async def act(frame: dict[str, Any]) -> None:
        mine = frame["msg"]["goal_id"]["id"]
        for status in (Status.PENDING, Status.ACTIVE, Status.ACTIVE, Status.SUCCEEDED):
            await say_statuses(server, (mine, status, ""))
        await say_result(server, mine, Status.SUCCEEDED, "Goal reached.")

    outcome = await follow(server, act, leap=4.0)
    assert (outcome.reached, outcome.text) == (True, "Goal reached.")


async def test_a_close_by_the_cloud_ends_the_wait_for_a_goal(server: RosbridgeServer) -> None:
    async def act(_: dict[str, Any]) -> None:
        await server.connections[-1].close(1011, "not-found: robot 'tb1' was removed")

    with pytest.raises(NotFound, match="was removed"):
        await follow(server, act)


async def test_localized_waits_for_a_pose(server: RosbridgeServer) -> None:
    async with RobotClient(server.url, robot="tb1", token="t", role="operator") as client:
        move_base = await MoveBaseClient(client).start()
        with pytest.raises(Unavailable, match="check that the robot publishes scan and odom"):
            await move_base.localized(0.02)
        await server.heard("subscribe", 4)
        await server.say(op="publish", topic="amcl_pose", msg={"header": {}, "pose": {"pose": POSE}})
        assert await move_base.localized() == Pose2D(1.0, 2.0, 0.0)


def status(goal: str, number: Status) -> GoalStatus:
    return GoalStatus(GoalID(id=goal), int(number))


def listed(tracked: TrackedGoal, times: int, *statuses: GoalStatus, since: float = 0.0) -> float:
    """Deliver status lists, one per second; return the time of the last."""
    for number in range(times):
        tracked.on_status(GoalStatusArray(status_list=list(statuses)), since + number)
    return since + times - 1


async def test_a_result_ends_only_its_own_goal() -> None:
    tracked = TrackedGoal("mine")
    tracked.on_result(MoveBaseActionResult(Header(), status("other", Status.SUCCEEDED)))
    assert not tracked.result.done()
    tracked.on_result(MoveBaseActionResult(Header(), status("mine", Status.ABORTED)))
    tracked.on_result(MoveBaseActionResult(Header(), status("mine", Status.SUCCEEDED)))
    assert (await asyncio.wait_for(tracked.result, 1.0)).status == Status.ABORTED


async def test_repeated_terminal_statuses_end_a_goal_without_a_result() -> None:
    tracked = TrackedGoal("mine")
    now = listed(tracked, 3, status("other", Status.SUCCEEDED), status("mine", Status.ACTIVE))
    listed(tracked, MIN_LISTS - 1, status("mine", Status.SUCCEEDED), since=now)
    assert not tracked.result.done()
    listed(tracked, 2, status("mine", Status.SUCCEEDED), since=now + SETTLED)
    assert (tracked.result.result().status, tracked.has_result) == (Status.SUCCEEDED, False)


async def test_a_goal_missing_from_several_status_lists_is_lost() -> None:
    tracked = TrackedGoal("mine")
    now = listed(tracked, MIN_LISTS - 1)
    now = listed(tracked, 1, status("mine", Status.ACTIVE), since=now + 100.0)
    assert tracked.status.status == Status.ACTIVE
    listed(tracked, MIN_LISTS + 2, status("other", Status.ACTIVE), since=now)
    assert tracked.result.result().status == Status.LOST


async def test_a_result_after_the_end_by_lists_changes_nothing() -> None:
    tracked = TrackedGoal("mine")
    listed(tracked, MIN_LISTS + 2)
    tracked.on_result(MoveBaseActionResult(Header(), status("mine", Status.SUCCEEDED)))
    assert (tracked.result.result().status, tracked.has_result) == (Status.LOST, False)
