"""A robot that offers a service, as robots.md prints it, to its operator: over real sockets, which break meanwhile."""

import asyncio
import textwrap
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from ppaas.errors import PPaaSError, Unavailable
from ppaas.maps.grid import GridMap
from ppaas.messages.message import Empty
from ppaas.messages.rosapi import Services, ServicesResponse
from ppaas.messages.std_srvs import EmptyService, SetBool, SetBoolRequest, SetBoolResponse
from robots.client.robot_client import RobotClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.documents import blocks
from tests.support.network.wire import wire_to
from tests.support.waiting import until
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

PAGE = "docs/robots.md"


class Hardware:
    """What the page calls ``hardware``: a lamp that takes its time, or is broken."""

    def __init__(self) -> None:
        self.lit = False
        self.failure: Exception | None = None
        self.works = asyncio.Event()
        self.works.set()

    async def switch_lamp(self, lit: bool) -> None:
        await self.works.wait()
        if self.failure is not None:
            raise self.failure
        self.lit = lit


def offer() -> Callable[[RobotClient, Hardware], Awaitable[None]]:
    """Return the code of the page as a function of what it is given."""
    code = next(block for block in blocks(PAGE, "python") if "advertise_service" in block)
    scope: dict[str, Any] = {}
    exec("async def offer(cloud, hardware):\n" + textwrap.indent(code, "    "), scope)
    return scope["offer"]  # type: ignore[no-any-return]


async def test_an_operator_switches_a_lamp_of_a_robot_whose_connection_breaks(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    token = await register_robot(rest, "lamp", "office", free_pose(office_map, seed=51))
    lamp, refused = Hardware(), asyncio.Queue[PPaaSError]()
    async with (
        wire_to(cloud.url) as wire,
        RobotClient(wire.url, robot="lamp", token=token, on_status=refused.put_nowait) as robot,
        RobotClient(cloud.url, robot="lamp", token=token, role="operator") as operator,
    ):

        async def switch(lit: bool) -> object:
            return await operator.call("lamp", SetBool, SetBoolRequest(lit), 30.0)

        async def known() -> bool:
            """Tell whether the cloud knows the lamp, once it has heard all that the robot has said."""
            told = await robot.call("rosapi/services", Services, Empty())
            assert isinstance(told, ServicesResponse)
            return "/lamp" in told.services

        await offer()(robot, lamp)
        assert await known()
        assert await switch(True) == SetBoolResponse(True)
        assert lamp.lit
        lamp.failure = Unavailable("the bulb is broken")
        with pytest.raises(PPaaSError, match="the bulb is broken"):
            await switch(False)
        lamp.failure = None
        lamp.works.clear()
        switching = asyncio.create_task(switch(False))
        await asyncio.sleep(0)
        wire.cut()
        await until(lambda: not robot.connected)
        wire.mend()
        await until(lambda: robot.connected)
        lamp.works.set()
        assert await switching == SetBoolResponse(True), "asked and answered once, by one connection or the next"
        assert not lamp.lit
        await robot.advertise_service("move_base/clear_costmaps", EmptyService, lambda _: Empty())
        assert "is provided by the clone" in str(await asyncio.wait_for(refused.get(), 10))
        await robot.unadvertise_service("lamp")
        assert not await known()
        with pytest.raises(PPaaSError, match="unknown service 'lamp'"):
            await switch(True)
