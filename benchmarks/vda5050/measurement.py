"""Measurement of a bridge that presents robots as AGVs: its CPU time, its memory, and the states that arrive."""

import asyncio
import tempfile
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from aiomqtt import Client

from benchmarks.harness.figures import Figure
from benchmarks.vda5050.bridge_process import bridge_process
from benchmarks.vda5050.broker_process import broker
from benchmarks.vda5050.fleet_stand_in import MAP, fleet_stand_in
from ppaas.clock import epoch
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.orders import Deviation, Edge, Node, NodePosition, Order
from ppaas.wire.vda5050.topics import Address, Version

if TYPE_CHECKING:
    from rich.progress import Progress

SETTLE = 5.0
"""Time after which start and orders are over [s]."""

OPTIONS = ("--visualization", "0", "--state-interval", "1")

NOTE = "that arrived at a master control"

ORDER = Order(
    order_id="far",
    order_update_id=0,
    nodes=[
        Node(
            node_id=f"n{index}",
            sequence_id=2 * index,
            released=True,
            actions=[],
            node_position=NodePosition(
                x=50.0 * index, y=0.0, map_id=MAP, allowed_deviation_xy=Deviation(a=2.0, b=2.0, theta=0.0)
            ),
        )
        for index in range(2)
    ],
    edges=[Edge(edge_id="e", sequence_id=1, released=True, actions=[], start_node_id="n0", end_node_id="n1")],
)
"""Order from where the robots are to a node that they do not reach."""


async def measure(progress: "Progress", robots: int, seconds: float) -> list[Figure]:
    """Return the figures of a bridge with some robots, measured for a time [s].

    Raises
    ------
    InvalidInput
        mosquitto is not installed.
    Unavailable
        The AGVs did not report in time.
    """
    task = progress.add_task("vda5050", total=2)
    with tempfile.TemporaryDirectory() as folder:
        async with broker(Path(folder)) as port, fleet_stand_in() as url, _states(port) as arrived:
            names = [f"r{index}" for index in range(robots)]
            arguments = ["vda5050", *names, *OPTIONS]
            async with bridge_process(arguments, port, url, Path(folder) / "bridge.log", robots) as bridge:
                await bridge.until_all(lambda: len(arrived), "report", SETTLE)
                progress.advance(task)
                figures = await bridge.figures(f"{robots} AGVs that stand", arrived.total, NOTE, seconds)
                await _order_all(names, port)
                await asyncio.sleep(SETTLE)
                figures += await bridge.figures(f"{robots} AGVs that drive", arrived.total, NOTE, seconds)
                progress.advance(task)
    return figures


async def _order_all(names: list[str], port: int) -> None:
    """Order each AGV to a node that it does not reach."""
    async with Client("127.0.0.1", port) as client:
        for name in names:
            address = Address.of(Version.V2_1, "ppaas", name)
            header = HeaderCounter(Version.V2_1, address).next(topics.ORDER, epoch())
            await client.publish(address.topic(topics.ORDER), encode(topics.ORDER, header, ORDER, Version.V2_1))


@asynccontextmanager
async def _states(port: int) -> AsyncIterator["Counter[str]"]:
    """Count the states that arrive, by topic."""
    arrived: Counter[str] = Counter()

    async def listen(client: Client) -> None:
        async for message in client.messages:
            arrived[message.topic.value] += 1

    async with Client("127.0.0.1", port) as client:
        await client.subscribe("uagv/v2/+/+/state")
        listening = asyncio.create_task(listen(client))
        try:
            yield arrived
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
