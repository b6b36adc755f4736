"""The link to the cloud against a real WebSocket server."""

import asyncio
import json
from collections.abc import AsyncIterator

import pytest

from ppaas.errors import NotFound, Unavailable
from robots.bridges.core.cloud_link import CloudLink
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.waiting import until


@pytest.fixture
async def server() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        yield running


def link_of(server: RosbridgeServer, renewed: list[int] | None = None) -> CloudLink:
    return CloudLink(server.url, robot="tb1", token="t", renewed=lambda: (renewed or []).append(1))


async def test_messages_pass_as_json(server: RosbridgeServer) -> None:
    heard: list[bytes] = []
    async with link_of(server) as link:
        await link.advertise("battery_state", "sensor_msgs/msg/BatteryState")
        await link.subscribe("plan", "nav_msgs/msg/Path", heard.append)
        await link.publish("goal_pose", b'{"a":[1,null]}')
        link.publish_newest("scan", b"{}")
        published = await server.heard("publish", 2)
        assert [(one["topic"], one["msg"]) for one in published] == [("goal_pose", {"a": [1, None]}), ("scan", {})]
        [wanted] = server.of("subscribe")
        assert (wanted["topic"], wanted["type"]) == ("plan", "nav_msgs/msg/Path")
        await server.say(op="publish", topic="other", msg={})
        await server.say(op="publish", topic="plan", msg={"poses": []})
        await until(lambda: heard == [b'{"poses": []}'])
        await link.unsubscribe("plan")
        assert (await server.heard("unsubscribe"))[0]["topic"] == "plan"


async def test_a_part_of_the_bridge_that_fails_does_not_keep_messages_from_the_others(server: RosbridgeServer) -> None:
    def fail(_: bytes) -> None:
        raise ZeroDivisionError

    heard: list[bytes] = []
    async with link_of(server) as link:
        await link.subscribe("plan", "nav_msgs/msg/Path", fail)
        await link.subscribe("cmd_vel", "geometry_msgs/msg/Twist", heard.append)
        await server.heard("subscribe", 2)
        for topic in ("plan", "cmd_vel", "plan", "cmd_vel"):
            await server.say(op="publish", topic=topic, msg={})
        await until(lambda: len(heard) == 2)
        assert link.connected


async def test_calls_are_answered_or_fail_with_the_reason(server: RosbridgeServer) -> None:
    async with link_of(server) as link:
        call = asyncio.create_task(link.call("static_map", "nav_msgs/srv/GetMap", b"{}"))
        [sent] = await server.heard("call_service")
        await server.say(op="service_response", service="static_map", id=sent["id"], result=True, values={"map": 1})
        assert json.loads(await call) == {"map": 1}
        call = asyncio.create_task(link.call("none", "std_srvs/srv/Empty", b"{}"))
        sent = (await server.heard("call_service", 2))[1]
        await server.say(op="service_response", service="none", id=sent["id"], result=False, values="not-found: no")
        with pytest.raises(NotFound, match="no"):
            await call
        with pytest.raises(Unavailable, match="did not answer"):
            await link.call("slow", "std_srvs/srv/Empty", b"{}", timeout=0.01)


async def test_a_goal_has_feedback_and_one_end(server: RosbridgeServer) -> None:
    feedback: list[bytes] = []
    async with link_of(server) as link:
        goal = await link.send_goal("navigate_to_pose", "nav2_msgs/action/NavigateToPose", b"{}", feedback.append)
        [sent] = await server.heard("send_action_goal")
        assert sent["feedback"] is True
        await link.cancel_goal(goal)
        assert (await server.heard("cancel_action_goal"))[0]["id"] == sent["id"]
        await server.say(op="action_feedback", action="navigate_to_pose", id=sent["id"], values={"x": 1})
        await server.say(op="action_result", id=sent["id"], action="a", status=5, result=True, values={"error_code": 0})
        end = await goal.end
        assert (end.status, json.loads(end.result), end.reason) == (5, {"error_code": 0}, "")
        assert feedback == [b'{"x": 1}']
        refused = await link.send_goal("spin", "nav2_msgs/action/Spin", b"{}", feedback.append)
        sent = (await server.heard("send_action_goal", 2))[1]
        await server.say(
            op="action_result", id=sent["id"], action="spin", status=0, result=False, values="not-found: x"
        )
        assert (await refused.end).reason == "not-found: x"


async def test_a_lost_session_ends_goals_and_renews_subscriptions(server: RosbridgeServer) -> None:
    renewed: list[int] = [0]
    async with link_of(server, renewed) as link:
        await link.subscribe("map", "nav_msgs/msg/OccupancyGrid", lambda _: None)
        goal = await link.send_goal("navigate_to_pose", "nav2_msgs/action/NavigateToPose", b"{}", lambda _: None)
        await server.heard("send_action_goal")
        await server.connections[0].close()
        await server.connected(2)
        assert (await goal.end).status == 0
        assert [one["topic"] for one in await server.heard("subscribe", 2)] == ["map", "map"]
        await until(lambda: renewed == [0, 1, 1])
        assert link.connected


async def test_errors_and_nonsense_of_the_cloud_are_logged_once(
    server: RosbridgeServer, caplog: pytest.LogCaptureFixture
) -> None:
    async with link_of(server):
        for _ in range(3):
            await server.say(op="status", level="error", msg="not-permitted: no")
        await server.connections[-1].send("[")
        await until(lambda: "invalid frame" in caplog.text)
    assert caplog.text.count("not-permitted: no") == 1


async def test_a_refusal_is_raised(server: RosbridgeServer) -> None:
    server.refusal = 404, b"{}"
    with pytest.raises(NotFound):
        async with link_of(server):
            pass
