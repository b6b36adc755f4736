"""A fleet between a graph in memory, in which the test is Open-RMF, and a real WebSocket server, which is the cloud."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from ppaas.errors import Conflict, NotFound
from ppaas.wire.own_topics import PRESENCE
from ppaas.wire.rmf.level_frame import LevelFrame
from robots.bridges.rmf import robot_in_cloud
from robots.bridges.rmf.fleet import RmfFleet
from robots.bridges.rmf.options import FleetForRmf
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.ros2.fake_transport import FakeTransport
from tests.support.waiting import until

RECORD = {"map": "office", "model": "turtlebot2"}
OPTIONS = FleetForRmf("carts", {"tb1": "cart 1"}, {"office": "L1"}, {"L1": LevelFrame(x=10.0)}, period=0.1)


class Exchange:
    """Open-RMF on one side of a fleet, and the clone of its robot on the other."""

    def __init__(self, rmf: FakeTransport, cloud: RosbridgeServer) -> None:
        self.rmf, self.cloud = rmf, cloud

    async def pose(self, x: float, y: float) -> None:
        """Let the clone say where the robot is."""
        pose = {"pose": {"position": {"x": x, "y": y}, "orientation": {"w": 1.0}}}
        await self.cloud.say(op="publish", topic="amcl_pose", msg={"header": {"frame_id": "map"}, "pose": pose})

    def request_path(self, *places: tuple[float, float], task: str = "1", **more: str) -> None:
        path = [{"x": x, "y": y, "level_name": "L1"} for x, y in places]
        request = {"fleet_name": "carts", "robot_name": "cart 1", "path": path, "task_id": task}
        self.rmf.say("/robot_path_requests", request | more)

    def state(self) -> dict[str, Any]:
        """Return the last state of the robot; empty if it is in none."""
        robots = self.rmf.published["/fleet_states"][-1]["robots"]
        return dict(robots[0]) if robots else {}

    async def goals(self, count: int) -> list[dict[str, Any]]:
        """Wait for goals, and return them."""
        return list(await self.cloud.heard("send_action_goal", count))


@asynccontextmanager
async def exchanging(options: FleetForRmf = OPTIONS) -> AsyncIterator[Exchange]:
    rmf = FakeTransport()
    async with rosbridge_server() as cloud:
        fleet = RmfFleet(rmf, cloud.url, "t", options)
        fleet.add("tb1", RECORD)
        running = asyncio.create_task(fleet.run())
        await until(lambda: len(cloud.of("subscribe")) == 3)
        exchange = Exchange(rmf, cloud)
        await exchange.pose(1.0, 2.0)
        await until(lambda: rmf.published.get("/fleet_states") and exchange.state())
        try:
            yield exchange
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
    assert not rmf.opened


async def test_a_robot_follows_a_path_and_rmf_sees_how_far_it_is() -> None:
    async with exchanging() as both:
        place = both.state()["location"]
        assert (place["x"], place["y"], place["level_name"]) == (11.0, 2.0, "L1")
        both.request_path((13.0, 2.0), (13.0, 5.0))
        [goal] = await both.goals(1)
        assert (goal["action"], len(goal["args"]["poses"])) == ("navigate_through_poses", 2)
        assert [pose["pose"]["position"]["x"] for pose in goal["args"]["poses"]] == [3.0, 3.0]
        await until(lambda: both.state()["mode"]["mode"] == 2)
        assert (both.state()["task_id"], len(both.state()["path"])) == ("1", 2)
        feedback = {"number_of_poses_remaining": 1, "distance_remaining": 2.0}
        await both.cloud.say(op="action_feedback", action=goal["action"], id=goal["id"], values=feedback)
        await until(lambda: len(both.state()["path"]) == 1)
        result = {"op": "action_result", "action": goal["action"], "id": goal["id"], "status": 4, "result": True}
        await both.cloud.say(**result, values={})
        await until(lambda: both.state()["path"] == [])
        assert both.state()["mode"]["mode"] == 0
        numbers = [message["robots"][0]["seq"] for message in both.rmf.published["/fleet_states"] if message["robots"]]
        assert numbers == list(range(1, len(numbers) + 1))


async def test_a_path_that_fails_is_an_error_of_the_adapter() -> None:
    async with exchanging() as both:
        both.request_path((13.0, 2.0))
        [goal] = await both.goals(1)
        result = {"op": "action_result", "action": goal["action"], "id": goal["id"], "status": 6, "result": True}
        await both.cloud.say(**result, values={"error_msg": "a keep-out zone"})
        await until(lambda: both.state()["mode"]["mode"] == 8)
        both.request_path((11.0, 5.0), task="2")
        await both.goals(2)
        await until(lambda: (both.state()["mode"]["mode"], both.state()["task_id"]) == (2, "2"))


async def test_a_new_path_cancels_the_drive_before() -> None:
    async with exchanging() as both:
        both.request_path((13.0, 2.0))
        [first] = await both.goals(1)
        both.request_path((11.0, 5.0), task="2")
        [cancelled] = await both.cloud.heard("cancel_action_goal", 1)
        assert cancelled["id"] == first["id"]
        await both.goals(2)


async def test_a_drive_of_a_session_that_was_lost_is_cancelled_and_begins_again() -> None:
    async with exchanging() as both:
        both.request_path((13.0, 2.0))
        await both.goals(1)
        await both.cloud.connections[-1].close(1011)
        await both.cloud.connected(2)
        await until(lambda: [frame["topic"] for frame in both.cloud.of("publish")] == ["move_base/cancel"])
        await both.pose(1.5, 2.0)
        [_, again] = await both.goals(2)
        assert again["args"]["poses"][0]["pose"]["position"]["x"] == 3.0
        await until(lambda: (both.state().get("task_id"), len(both.state().get("path", []))) == ("1", 1))


async def test_a_paused_robot_does_not_drive_on_after_its_session_was_lost() -> None:
    async with exchanging() as both:
        both.request_path((13.0, 2.0))
        await both.goals(1)
        await both.cloud.connections[-1].close(1011)
        mode = {"fleet_name": "carts", "robot_name": "cart 1", "mode": {"mode": 3}, "task_id": "2"}
        both.rmf.say("/robot_mode_requests", mode)
        await both.cloud.connected(2)
        await until(lambda: [frame["topic"] for frame in both.cloud.of("publish")] == ["move_base/cancel"])
        await both.pose(1.5, 2.0)
        await until(lambda: both.state().get("mode", {}).get("mode") == 3)
        assert len(both.cloud.of("send_action_goal")) == 1


@pytest.mark.parametrize("more", [{"fleet_name": "others"}, {"robot_name": "cart 2"}])
async def test_requests_to_others_are_not_taken(more: dict[str, str]) -> None:
    async with exchanging() as both:
        both.request_path((13.0, 2.0), **more)
        both.request_path((11.0, 5.0), task="2")
        [goal] = await both.goals(1)
        assert goal["args"]["poses"][0]["pose"]["position"]["x"] == 1.0


async def test_damaged_requests_end_nothing(caplog: pytest.LogCaptureFixture) -> None:
    async with exchanging() as both:
        for topic, (kind, _, received) in both.rmf.subscriptions.items():
            received(b"")
            received(b"\x00\x01\x00\x00" + bytes(range(200)))
            assert topic.endswith("requests") and kind.endswith("Request")
        both.request_path((13.0, float("nan")))
        assert "is refused" in caplog.text
        both.rmf.say("/robot_mode_requests", {"fleet_name": "carts", "robot_name": "cart 1", "mode": {"mode": 7}})
        assert "mode 7 is not supported" in caplog.text
        both.request_path((13.0, 2.0))
        await both.goals(1)


async def test_a_robot_that_is_lost_is_not_in_the_fleet(monkeypatch: pytest.MonkeyPatch) -> None:
    async with exchanging() as both:
        await both.cloud.say(op="publish", topic="battery_state", msg={"percentage": 0.5, "power_supply_status": 1})
        await until(lambda: (both.state()["battery_percent"], both.state()["mode"]["mode"]) == (50.0, 1))
        await both.cloud.say(op="publish", topic=PRESENCE, msg={"data": False})
        await until(lambda: both.state() == {})
        await both.cloud.say(op="publish", topic=PRESENCE, msg={"data": True})
        await both.pose(1.0, 2.0)
        await until(both.state)
        monkeypatch.setattr(robot_in_cloud, "POSE_AGE", 0.05)
        await until(lambda: both.state() == {})


async def test_a_level_without_reference_points_is_refused() -> None:
    fleet = RmfFleet(FakeTransport(), "http://127.0.0.1:9", "t", OPTIONS)
    with pytest.raises(NotFound, match="'cellar'; known: L1; robot tb1"):
        fleet.add("tb1", RECORD | {"map": "cellar"})


def test_two_robots_of_one_name_are_refused() -> None:
    fleet = RmfFleet(FakeTransport(), "http://127.0.0.1:9", "t", OPTIONS)
    fleet.add("tb1", RECORD)
    with pytest.raises(Conflict, match="'cart 1'"):
        fleet.add("cart 1", RECORD)
