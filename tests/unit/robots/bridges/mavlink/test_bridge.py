"""A bridge over sockets: a stand-in for the cloud, and a simulated rover at a port."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import pytest

from benchmarks.bridge.measurement import CloudStandIn, cloud_stand_in
from benchmarks.harness.free_ports import free_ports
from ppaas.errors import Conflict
from robots.bridges.mavlink.bridge import BridgeOptions, MavlinkBridge
from robots.bridges.mavlink.link import VehicleAddress
from robots.bridges.mavlink.station import StationOptions
from robots.sim.mavlink.body import RoverBody
from robots.sim.mavlink.rover import SimulatedRover
from robots.sim.mavlink.serving import STEP, ServedRover
from tests.support.mavlink.closed_loop import ANCHOR
from tests.support.waiting import until

TWIST = {"linear": {"x": 0.5}, "angular": {"z": 0.0}}


@asynccontextmanager
async def rover_at(port: int, *, system: int = 1, key: bytes | None = None) -> AsyncIterator[SimulatedRover]:
    """Serve a rover."""
    rover = SimulatedRover("ardupilot", RoverBody(ANCHOR.latitude, ANCHOR.longitude), system)
    served = ServedRover(rover, f"udpout:127.0.0.1:{port}", key)

    async def pump() -> None:
        while True:
            served.pump()
            await asyncio.sleep(STEP)

    task = asyncio.create_task(pump())
    try:
        yield rover
    finally:
        task.cancel()
        served.close()


def bridge(cloud: CloudStandIn, port: int, system: int | None = 1, key: bytes | None = None) -> MavlinkBridge:
    station = StationOptions(VehicleAddress.parse(f"udpin:127.0.0.1:{port}"), system, key=key)
    return MavlinkBridge(cloud.url, "t", "robot", BridgeOptions(station, ANCHOR, arm=True))


async def test_a_bridge_that_is_ended_leaves_a_rover_that_stands() -> None:
    (port,), key = free_ports(1), b"k" * 32
    async with cloud_stand_in() as cloud, rover_at(port, key=key) as rover:
        running = asyncio.create_task(bridge(cloud, port, key=key).run())
        await cloud.publish("cmd_vel", TWIST)
        async with asyncio.timeout(30.0):
            while rover.body.speed < 0.2:
                await cloud.publish("cmd_vel", TWIST)
                await asyncio.sleep(0.1)
        assert cloud.arrived["odom"] and cloud.arrived["battery_state"]
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running
        await until(lambda: rover.mode.name == "HOLD", 1.0)
        await until(lambda: rover.body.speed < 0.01, 2.0)


async def test_two_vehicles_at_a_port_are_refused_with_their_numbers() -> None:
    (port,) = free_ports(1)
    async with cloud_stand_in() as cloud, rover_at(port, system=3), rover_at(port, system=4):
        with pytest.raises(Conflict, match="vehicles 3, 4"):
            async with asyncio.timeout(30.0):
                await bridge(cloud, port, None).run()
