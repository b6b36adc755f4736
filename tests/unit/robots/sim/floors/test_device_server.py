"""The devices of a simulated building are driven by the plug-in of the cloud, over real sockets."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import httpcore
import pytest

from engine.devices.hosts import DeviceHosts
from engine.devices.opening import open_door, open_lift
from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from robots.sim.floors.building import SimulatedBuilding
from robots.sim.floors.device_server import LARGEST, DeviceServer
from tests.support.device_states import running
from tests.support.waiting import until
from tests.support.world.simulated_building import building

LOCAL = DeviceHosts(["127.0.0.1"])


@asynccontextmanager
async def served() -> AsyncIterator[tuple[SimulatedBuilding, DeviceServer]]:
    """Simulate a building ten times as quickly as the clock, and serve its devices."""

    async def simulate() -> None:
        while True:
            for _ in range(10):
                simulated.step()
            await asyncio.sleep(simulated.dt)

    simulated = building()
    async with DeviceServer(simulated) as server:
        simulating = asyncio.create_task(simulate())
        try:
            yield simulated, server
        finally:
            simulating.cancel()


async def test_a_lift_is_sent_and_let_go_by_the_driver_of_the_cloud() -> None:
    async with served() as (simulated, server):
        record = server.served(simulated.layout.building)
        device = open_lift(record.lift("A"), {"low": 0.0, "up": 3.0}, LOCAL)
        async with running(device) as states:
            await device.send(LiftRequest("A", "s", "up"))
            await until(lambda: states and (states[-1].floor, states[-1].door) == ("up", "open"))
            assert (states[-1].session, states[-1].floors, states[-1].lift) == ("s", ("low", "up"), "A")
            await device.send(EndSession("A", "s"))
            await until(lambda: states[-1].session == "" and states[-1].door == "closed")


async def test_a_door_is_opened_and_closed_by_the_driver_of_the_cloud() -> None:
    async with served() as (simulated, server):
        device = open_door(server.served(simulated.layout.building).door("low", "glass"), LOCAL)
        async with running(device) as states:
            for mode in ("open", "closed"):
                await device.send(DoorRequest("low", "glass", "s", mode))
                await until(lambda mode=mode: states and states[-1].mode == mode)


async def test_connections_end_with_the_server() -> None:
    async with httpcore.AsyncConnectionPool() as pool:
        async with served() as (_, server):
            for _ in range(2):
                assert (await pool.request("GET", f"{server.url}/lifts/A")).status == 200
        with pytest.raises(httpcore.ConnectError):
            await pool.request("GET", f"{server.url}/lifts/A")


async def test_only_the_devices_of_a_record_change() -> None:
    async with served() as (simulated, server):
        before = simulated.layout.building
        after = server.served(before)
        assert after.floors == before.floors
        assert after.lifts[0].speed == before.lifts[0].speed
        assert after.lifts[0].device == f"{server.url}/lifts/A"
        assert after.doors[0].device == f"{server.url}/doors/low/glass"


@pytest.mark.parametrize(
    ("method", "path", "body", "status"),
    [
        ("GET", "/lifts/B", b"", 404),
        ("GET", "/doors/up/glass", b"", 404),
        ("POST", "/lifts/A", b"{}", 400),
        ("POST", "/lifts/A", b"\xff", 400),
        ("POST", "/lifts/A", b'{"session": "s", "level": "up"}', 400),
        ("POST", "/doors/low/glass", b'{"session": "s", "mode": "ajar"}', 400),
        ("POST", "/lifts/A", b" " * (LARGEST + 1), 400),
        ("PUT", "/lifts/A", b"", 501),
        ("POST", "/lifts/A", b'{"session": "s", "floor": "cellar"}', 204),
    ],
)
async def test_wrong_requests_are_refused_and_change_nothing(method: str, path: str, body: bytes, status: int) -> None:
    async with served() as (simulated, server), httpcore.AsyncConnectionPool() as pool:
        answer = await pool.request(method, server.url + path, content=body)
        assert answer.status == status
        assert simulated.lifts["A"].state(simulated.time()).session == ""
