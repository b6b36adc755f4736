"""Cost of a fleet for Open-RMF, beside a node that publishes the same states of nobody."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from benchmarks.bridge import bare_fleet
from benchmarks.bridge.echo_process import DOMAIN
from benchmarks.bridge.measurement import MOST_CPU, CloudStandIn, cloud_stand_in
from benchmarks.bridge.processes import running, share_of_core
from benchmarks.harness.figures import Figure
from benchmarks.harness.free_ports import free_ports
from ppaas.clock import monotonic
from ppaas.wire.ros.rmf_definitions import FLEET_STATE
from robots import cli
from robots.bridges.rmf.fleet import QOS, STATES
from robots.bridges.zenoh.node import ZenohOptions, ZenohTransport

PART = "bridge rmf"
ROBOTS, RATE = 10, 10.0
"""Number of robots, and rate of the poses of each and of the states of the fleet [Hz]."""

MOST_MEMORY = 80.0
"""Limit of the memory [MB]: the connections of ten robots come to that of a bridge of one."""

SECONDS, QUICK_SECONDS = 20.0, 2.0
"""Time for which CPU time is counted [s]."""

POSE = {
    "header": {"frame_id": "map"},
    "pose": {"pose": {"position": {"x": 1.0, "y": 2.0}, "orientation": {"z": 0.2, "w": 0.98}}},
}


async def measure_fleet(*, quick: bool) -> list[Figure]:
    """Return the figures."""
    seconds = QUICK_SECONDS if quick else SECONDS
    bare, _, _, _ = await _of_states(None, seconds)
    async with cloud_stand_in() as cloud:
        share, memory, rate, robots = await _of_states(cloud, seconds)
    note = f"{ROBOTS} robots at {RATE:g} Hz"
    return [
        Figure(PART, "share of a core, states alone", round(bare, 2), "%", yardstick=True, note="without a cloud"),
        Figure(PART, "share of a core", round(share, 2), "%", limit=MOST_CPU, note=note),
        Figure(PART, "memory", round(memory, 1), "MB", limit=MOST_MEMORY),
        Figure(PART, "states at Open-RMF", round(rate, 1), "Hz", note=f"of {robots} robots each"),
    ]


async def _of_states(cloud: CloudStandIn | None, seconds: float) -> tuple[float, float, float, int]:
    """Return the share of a core [%], the memory [MB] and the rate of states [Hz] of a fleet, and its robots in one.

    The fleet is that of the bridge, or, without a cloud, the bare one.
    """
    endpoint = f"tcp/127.0.0.1:{free_ports(1)[0]}"
    names = [f"robot{number}" for number in range(ROBOTS)]
    words = ["-m", bare_fleet.__name__, endpoint, str(ROBOTS), f"{RATE:g}"]
    if cloud is not None:
        options = ["--fleet", "carts", "--period", f"{1.0 / RATE:g}", "--domain", str(DOMAIN), "--distro", "jazzy"]
        words = ["-m", cli.__name__, "bridge", "rmf", *names, *options, "--url", cloud.url, "--token", "t"]
        words += ["--transport", "zenoh", "--connect", endpoint]
    heard: list[int] = []
    async with _router(endpoint, heard), running(*words) as fleet, _posing(cloud):
        async with asyncio.timeout(30.0):
            while ROBOTS not in heard:  # noqa: ASYNC110 - one wait before a measurement
                await asyncio.sleep(0.05)
        before, began = len(heard), monotonic()
        share = await share_of_core(fleet, seconds)
        return share, fleet.memory_info().rss / 1e6, (len(heard) - before) / (monotonic() - began), heard[-1]


@asynccontextmanager
async def _router(endpoint: str, heard: list[int]) -> AsyncIterator[None]:
    """Be Open-RMF on a router, and note of how many robots each state is."""
    rmf = ZenohTransport(ZenohOptions(listen=(endpoint,), domain=DOMAIN, release="jazzy"), "rmf")
    await rmf.open(lambda: None)
    subscription = rmf.subscribe(
        STATES, FLEET_STATE, QOS, lambda data: heard.append(len(rmf.types.decode(FLEET_STATE, data)["robots"]))
    )
    try:
        yield
    finally:
        subscription.close()
        await rmf.close()


@asynccontextmanager
async def _posing(cloud: CloudStandIn | None) -> AsyncIterator[None]:
    """Publish the poses of all robots, if there is a cloud."""
    task = None if cloud is None else asyncio.create_task(_pose(cloud))
    try:
        yield
    finally:
        if task is not None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)


async def _pose(cloud: CloudStandIn) -> None:
    due = monotonic()
    while True:
        await cloud.publish("amcl_pose", POSE)
        due += 1.0 / RATE
        await asyncio.sleep(max(due - monotonic(), 0.0))
