"""The bridge with the names of ROS 1, between a graph in memory and a real WebSocket server."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from ppaas.messages.actionlib_msgs import Status
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import Kind
from robots.bridges.core.bridge import Bridge
from robots.bridges.ros1 import move_base
from robots.bridges.ros1.move_base import ROS_1, MoveBaseAction
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.ros2.fake_transport import FakeTransport
from tests.support.waiting import until

GOAL, CANCEL, STATUS = "/tb/move_base/goal", "/tb/move_base/cancel", "/tb/move_base/status"
FEEDBACK, RESULT, SIMPLE = "/tb/move_base/feedback", "/tb/move_base/result", "/tb/move_base_simple/goal"


class Both:
    """A robot with ROS 1 and its cloud, with a bridge between them."""

    def __init__(self, robot: FakeTransport, cloud: RosbridgeServer) -> None:
        self.robot, self.cloud = robot, cloud

    async def heard(self, topic: str, count: int = 1) -> list[dict[str, Any]]:
        await until(lambda: len(self.robot.published.get(topic, [])) >= count)
        return self.robot.published[topic]

    def goal(self, name: str, x: float = 0.0, **stamp: int) -> None:
        target = {"header": {"frame_id": "map"}, "pose": {"position": {"x": x}}}
        self.robot.say(GOAL, {"goal_id": {"id": name, "stamp": stamp}, "goal": {"target_pose": target}})

    async def sent(self, count: int = 1) -> dict[str, Any]:
        """Return the goal number ``count`` that the cloud has received."""
        return (await self.cloud.heard("send_action_goal", count))[count - 1]

    async def feed_back(self, goal: dict[str, Any]) -> None:
        values = {"current_pose": {"pose": {"position": {"x": 4.0}}}}
        await self.cloud.say(op="action_feedback", action="navigate_to_pose", id=goal["id"], values=values)

    async def end(self, goal: dict[str, Any], status: int, values: Any = None) -> None:
        values = {"error_msg": ""} if values is None else values
        frame = {"op": "action_result", "action": "navigate_to_pose", "id": goal["id"], "status": status}
        await self.cloud.say(**frame, result=status != 0, values=values)

    async def result(self, count: int = 1) -> tuple[str, int, str]:
        """Return id, status and text of the result number ``count``."""
        status = (await self.heard(RESULT, count))[count - 1]["status"]
        return status["goal_id"]["id"], status["status"], status["text"]

    async def status_of(self, name: str, status: int) -> None:
        """Wait until a goal is reported with a status."""

        def seen() -> bool:
            reports = self.robot.published.get(STATUS, [{"status_list": []}])[-1]["status_list"]
            return (name, status) in [(one["goal_id"]["id"], one["status"]) for one in reports]

        await until(seen)


@asynccontextmanager
async def bridged() -> AsyncIterator[Both]:
    robot = FakeTransport("noetic")
    robot.types, robot.tables = ros_types("noetic", ros2_times=True), ROS_1
    robot.has(Kind.PUBLISHER, "/tb/odom", "nav_msgs/msg/Odometry")
    robot.has(Kind.SUBSCRIBER, "/tb/move_base/NavfnROS/plan", "nav_msgs/msg/Path")
    robot.has(Kind.SUBSCRIBER, "/tb/map_metadata", "nav_msgs/msg/MapMetaData")
    async with rosbridge_server() as cloud:
        bridge = Bridge(robot, url=cloud.url, robot="tb1", token="t", actions=MoveBaseAction)
        running = asyncio.create_task(bridge.run())
        await until(lambda: GOAL in robot.subscriptions)
        try:
            yield Both(robot, cloud)
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
    assert not robot.publishers
    assert not robot.subscriptions


async def test_a_goal_is_driven_to_with_feedback_and_result() -> None:
    async with bridged() as both:
        both.goal("a", 3.0, sec=5)
        sent = await both.sent()
        assert (sent["action"], sent["args"]["pose"]["pose"]["position"]["x"]) == ("navigate_to_pose", 3.0)
        await both.status_of("a", Status.PENDING)
        await both.feed_back(sent)
        await both.status_of("a", Status.ACTIVE)
        [feedback] = await both.heard(FEEDBACK)
        assert feedback["feedback"]["base_position"]["pose"]["position"]["x"] == 4.0
        assert feedback["status"]["goal_id"]["id"] == "a"
        await both.end(sent, 4)
        assert await both.result() == ("a", Status.SUCCEEDED, "")
        both.goal("a", 3.0, sec=5)
        both.goal("b")
        assert (await both.sent(2))["id"] != sent["id"]
        await both.end(await both.sent(2), 6, {"error_msg": "no way"})
        assert await both.result(2) == ("b", Status.ABORTED, "no way")


async def test_status_is_repeated_and_forgets_ended_goals(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(move_base, "STATUS_PERIOD", 0.02)
    monkeypatch.setattr(move_base, "KEPT", 0.1)
    async with bridged() as both:
        await both.heard(STATUS, 3)
        both.goal("a")
        await both.end(await both.sent(), 4)
        await both.status_of("a", Status.SUCCEEDED)
        await until(lambda: len(both.robot.published[STATUS][-1]["status_list"]) == 0)


async def test_goals_are_cancelled_by_id_by_stamp_and_all_together() -> None:
    async with bridged() as both:
        both.goal("a", sec=5)
        both.goal("b", sec=9)
        both.goal("c", sec=20)
        for number, name in enumerate(("a", "b", "c"), start=1):
            await both.feed_back(await both.sent(number))
            await both.status_of(name, Status.ACTIVE)
        both.robot.say(CANCEL, {"id": "b"})
        assert (await both.cloud.heard("cancel_action_goal"))[0]["id"] == (await both.sent(2))["id"]
        await both.status_of("b", Status.PREEMPTING)
        await both.end(await both.sent(2), 5)
        assert await both.result() == ("b", Status.PREEMPTED, "")
        both.robot.say(CANCEL, {"stamp": {"sec": 10}})
        assert (await both.cloud.heard("cancel_action_goal", 2))[1]["id"] == (await both.sent(1))["id"]
        both.robot.say(CANCEL, {})
        assert (await both.cloud.heard("cancel_action_goal", 3))[2]["id"] == (await both.sent(3))["id"]


async def test_goals_that_were_cancelled_before_they_arrived_are_recalled() -> None:
    async with bridged() as both:
        both.robot.say(CANCEL, {"id": "early"})
        both.robot.say(CANCEL, {"stamp": {"sec": 10}})
        both.goal("early", sec=50)
        both.goal("old", sec=9)
        assert [await both.result(number) for number in (1, 2)] == [
            ("early", Status.RECALLED, "cancelled before it arrived"),
            ("old", Status.RECALLED, "cancelled before it arrived"),
        ]
        assert not both.cloud.of("send_action_goal")


async def test_goals_that_the_cloud_refuses_or_loses_end_with_the_reason() -> None:
    async with bridged() as both:
        both.goal("a")
        await both.end(await both.sent(), 0, "invalid-input: not finite")
        assert await both.result() == ("a", Status.REJECTED, "invalid-input: not finite")
        both.goal("b")
        await both.feed_back(await both.sent(2))
        await both.status_of("b", Status.ACTIVE)
        await both.end(await both.sent(2), 0, "unavailable: the clone was lost")
        assert await both.result(2) == ("b", Status.ABORTED, "unavailable: the clone was lost")


async def test_too_many_goals_are_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(move_base, "MAX_GOALS", 2)
    async with bridged() as both:
        for name in "abc":
            both.goal(name)
        assert await both.result() == ("c", Status.REJECTED, "there are 2 goals already")
        [*_, last] = await both.heard(STATUS)
        assert [one["goal_id"]["id"] for one in last["status_list"]] == ["a", "b"], "the list does not grow"


async def test_goals_of_rviz_have_a_status_too(caplog: pytest.LogCaptureFixture) -> None:
    async with bridged() as both:
        both.robot.say(SIMPLE, {"header": {"frame_id": "map"}, "pose": {"position": {"x": 2.0}}})
        sent = await both.sent()
        assert sent["args"]["pose"]["pose"]["position"]["x"] == 2.0
        await both.end(sent, 4)
        assert (await both.result())[1] == Status.SUCCEEDED
        both.robot.subscriptions[GOAL][2](b"?")
        assert "a message of Move Base cannot be read" in caplog.text


async def test_topics_and_services_have_the_names_of_ros_1() -> None:
    async with bridged() as both:
        await both.cloud.heard("subscribe", 3)
        assert set(both.robot.servers) == {f"/tb/{one.name}" for one in ROS_1.services}
        wanted = {"cmd_vel", "map", "tf", "plan", "map_metadata"}
        await until(lambda: {one["topic"] for one in both.cloud.of("subscribe")} == wanted)
        await both.cloud.say(
            op="publish", topic="plan", msg={"header": {"stamp": {"secs": 3, "nsecs": 0}}, "poses": [{}]}
        )
        assert (await both.heard("/tb/move_base/NavfnROS/plan"))[0]["header"]["stamp"]["sec"] == 3
        grid = {"header": {"seq": 4}, "info": {"width": 2, "height": 1, "resolution": 0.5}, "data": [0, 100]}
        await both.cloud.say(op="publish", topic="map", msg=grid)
        assert (await both.heard("/tb/map_metadata"))[0]["width"] == 2
        assert (await both.heard("/tb/map"))[0]["data"].tolist() == [0, 100]
