"""Client of the action ``explore`` against a small rosbridge server."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest

from ppaas.errors import Unavailable
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.explore_msgs import ExploreFeedback
from robots.client.explore import ExploreClient, ExploreOutcome
from robots.client.robot_client import RobotClient
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server


@pytest.fixture
async def server() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        yield running


def status(goal_id: str, value: Status, text: str = "") -> dict[str, Any]:
    return {"goal_id": {"id": goal_id}, "status": value, "text": text}


async def say(server: RosbridgeServer, part: str, **message: Any) -> None:
    await server.say(op="publish", topic=f"explore/{part}", msg={"header": {}, **message})


async def explore(
    server: RosbridgeServer, act: Any, told: list[ExploreFeedback] | None = None, **options: Any
) -> ExploreOutcome:
    async with RobotClient(server.url, robot="tb1", token="t", role="operator") as client:
        exploring = asyncio.create_task(ExploreClient(client, None if told is None else told.append).explore(**options))
        [frame] = await server.heard("publish")
        await act(frame, exploring)
        return await asyncio.wait_for(exploring, 20)


async def test_goal_is_sent_and_feedback_and_result_are_returned(server: RosbridgeServer) -> None:
    told: list[ExploreFeedback] = []

    async def act(frame: dict[str, Any], _: Any) -> None:
        assert frame["topic"] == "explore/goal"
        assert frame["msg"]["goal"] == {"return_to_start": True}
        goal = frame["msg"]["goal_id"]["id"]
        await say(server, "feedback", status=status("other", Status.ACTIVE), feedback={"text": "not ours"})
        await say(server, "feedback", status=status(goal, Status.ACTIVE), feedback={"frontiers": 3, "text": "driving"})
        await say(server, "result", status=status("other", Status.ABORTED), result={})
        await say(server, "result", status=status(goal, Status.SUCCEEDED, "done"), result={"area": 12.5})

    outcome = await explore(server, act, told, return_to_start=True)
    assert (outcome.status, outcome.text, outcome.result.area) == (Status.SUCCEEDED, "done", 12.5)
    assert [(each.frontiers, each.text) for each in told] == [(3, "driving")]


async def test_cancelled_coroutine_cancels_the_goal_and_waits_for_its_result(server: RosbridgeServer) -> None:
    async def act(frame: dict[str, Any], exploring: asyncio.Task[Any]) -> None:
        goal = frame["msg"]["goal_id"]["id"]
        await say(server, "status", status_list=[status(goal, Status.ACTIVE)])
        await asyncio.sleep(0.05)
        exploring.cancel()
        _, cancel = await server.heard("publish", 2)
        assert (cancel["topic"], cancel["msg"]["id"]) == ("explore/cancel", goal)
        assert not exploring.done()
        await say(server, "result", status=status(goal, Status.PREEMPTED), result={})

    with pytest.raises(asyncio.CancelledError):
        await explore(server, act)


async def test_robot_without_the_node_is_reported_and_the_goal_is_cancelled(server: RosbridgeServer) -> None:
    async def act(frame: dict[str, Any], _: Any) -> None:
        _, cancel = await server.heard("publish", 2)
        assert (cancel["topic"], cancel["msg"]["id"]) == ("explore/cancel", frame["msg"]["goal_id"]["id"])

    with pytest.raises(Unavailable, match="no node 'explore'; its robot file must name a new map"):
        await explore(server, act, answer_timeout=0.1)
