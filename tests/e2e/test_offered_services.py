"""A robot advertises a service with the code of robots.md, over real sockets that break meanwhile."""

import asyncio
import textwrap
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from ppaas.errors import PPaaSError, Unavailable
from ppaas.maps.grid import GridMap
from ppaas.messages.base.message import Empty
from ppaas.messages.base.rosapi import Services, ServicesResponse
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
    """The ``hardware`` of the page: a lamp that may be slow or broken."""

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
    """Return the code of the page as a function of ``cloud`` and ``hardware``."""
    code = next(block for block in blocks(PAGE, "python") if "advertise_service" in block)
    scope: dict[str, Any] = {}
    exec("async def offer(cloud, hardware):\n" + textwrap.indent(code, "    "), scope)
    return scope["offer"]  # type: ignore[no-any-return]


async def test_an_operator_calls_a_service_of_a_robot_across_a_broken_connection(
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
            """Return whether the cloud knows the lamp after it has processed all frames of the robot."""
            services = await robot.call("rosapi/services", Services, Empty())
            assert isinstance(services, ServicesResponse)
            return "/lamp" in services.services

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
        assert await switching == SetBoolResponse(True), "called and answered once, over either connection"
        assert not lamp.lit
        await robot.advertise_service("move_base/clear_costmaps", EmptyService, lambda _: Empty())
        assert "is provided by the clone" in str(await asyncio.wait_for(refused.get(), 10))
        await robot.unadvertise_service("lamp")
        assert not await known()
        with pytest.raises(PPaaSError, match="unknown service 'lamp'"):
            await switch(True)
