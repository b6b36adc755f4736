"""A robot for free_fleet between a graph in memory and a real WebSocket server, which is the cloud."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from robots.bridges.free_fleet.robot import NAVIGATE, FreeFleetRobot, present
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.ros2.fake_transport import FakeTransport
from tests.support.waiting import until

ACTION = "/cart/navigate_to_pose/_action"
UUID = bytes(range(16))
POSE = {"pose": {"position": {"x": 1.0, "y": 2.0}, "orientation": {"z": 1.0, "w": 0.0}}}


@asynccontextmanager
async def presented() -> AsyncIterator[tuple[FakeTransport, RosbridgeServer]]:
    transport = FakeTransport()
    async with rosbridge_server() as cloud:
        work = present(transport, cloud.url, "t", {"tb1": "cart"}, "base_footprint")
        running = asyncio.create_task(work)
        await until(lambda: len(transport.servers) == 3)
        try:
            yield transport, cloud
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
    assert not transport.opened
    assert not transport.servers


async def test_pose_and_battery_are_published_below_the_name_of_the_robot() -> None:
    async with presented() as (transport, cloud):
        await cloud.say(op="publish", topic="amcl_pose", msg={"header": {"frame_id": "map"}, "pose": POSE})
        await cloud.say(op="publish", topic="battery_state", msg={"percentage": 0.25, "voltage": None})
        await until(lambda: {"/cart/tf", "/cart/battery_state"} <= transport.published.keys())
        [transform] = transport.published["/cart/tf"][0]["transforms"]
        assert (transform["header"]["frame_id"], transform["child_frame_id"]) == ("map", "base_footprint")
        assert transform["header"]["stamp"]["sec"] > 0
        assert transform["transform"]["translation"] == {"x": 1.0, "y": 2.0, "z": 0.0}
        assert transform["transform"]["rotation"]["z"] == 1.0
        assert transport.published["/cart/battery_state"][0]["percentage"] == 0.25


@pytest.mark.parametrize("message", [{"percentage": "full", "pose": 3}, [], None, 7])
async def test_messages_that_are_not_of_their_type_are_left_out(message: object) -> None:
    async with presented() as (transport, cloud):
        for topic in ("amcl_pose", "battery_state"):
            await cloud.say(op="publish", topic=topic, msg=message)
        await cloud.say(op="publish", topic="amcl_pose", msg={"header": {"frame_id": "map"}, "pose": POSE})
        await until(lambda: transport.published.get("/cart/tf"))
        assert len(transport.published["/cart/tf"]) == 1
        assert "/cart/battery_state" not in transport.published


async def test_a_goal_is_driven_by_the_clone_and_its_result_is_kept() -> None:
    async with presented() as (transport, cloud):
        goal = {"goal_id": {"uuid": UUID}, "goal": {"pose": {"header": {"frame_id": "map"}} | POSE}}
        assert (await transport.call(f"{ACTION}/send_goal", goal))["accepted"]
        [sent] = await cloud.heard("send_action_goal")
        assert (sent["action"], sent["action_type"]) == ("navigate_to_pose", NAVIGATE)
        assert sent["args"]["pose"]["pose"]["position"]["x"] == 1.0
        result = asyncio.create_task(transport.call(f"{ACTION}/get_result", {"goal_id": {"uuid": UUID}}))
        ended = {"op": "action_result", "action": sent["action"], "id": sent["id"], "status": 4, "result": True}
        await cloud.say(**ended, values={})
        assert (await result)["status"] == 4
        again = await transport.call(f"{ACTION}/get_result", {"goal_id": {"uuid": UUID}})
        assert again["status"] == 4


async def test_a_robot_that_is_refused_does_not_end_the_others() -> None:
    async with rosbridge_server() as refusing:
        refusing.refusal = (403, b'{"type": "urn:ppaas:problem:not-permitted", "detail": "not for this token"}')
        transport = FakeTransport()
        alone = FreeFleetRobot(transport, refusing.url, "t", robot="tb2", name="tb2", frame="base_footprint")
        with pytest.raises(Exception, match="not for this token"):
            await alone.run()
