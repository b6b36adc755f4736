"""Measurements of bridges that present robots as AGVs, and that take AGVs as robots: CPU time, memory, states."""

import asyncio
import math
import tempfile
from collections import Counter
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
from aiomqtt import Client
from websockets.asyncio.server import ServerConnection, serve
from websockets.http11 import Request, Response

from benchmarks.harness.figures import Figure
from benchmarks.vda5050.fleet_stand_in import MAP, fleet_stand_in
from benchmarks.vda5050.processes import bridge_process, broker
from ppaas.clock import epoch, monotonic
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.fields import Position, Velocity
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.orders import Deviation, Edge, Node, NodePosition, Order
from ppaas.wire.vda5050.states import Connection, EdgeState, NodeState, PowerSupply, SafetyState, State
from ppaas.wire.vda5050.topics import AgvAddress, Version

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
            address = AgvAddress.of(Version.V2_1, "ppaas", name)
            header = HeaderCounter(Version.V2_1, address).next(topics.ORDER, epoch())
            await client.publish(address.topic(topics.ORDER), encode(topics.ORDER, header, ORDER, Version.V2_1))


@asynccontextmanager
async def _states(port: int) -> AsyncIterator["Counter[str]"]:
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


# -- measurement of a bridge that takes AGVs as robots -----------------------------------------------------------------

VERSION = Version.V2_1

NODES = 5
"""Number of nodes that each AGV still has."""

PERIOD = 1.0
"""Time between two states of an AGV [s]."""

BATCH = 10
"""Number of states that are sent at once."""

CONNECTED_WITHIN = 2.0
"""Time after which the start is over [s]."""


class ReportingAgv:
    """AGV that drives in a circle, on an order of another master control."""

    def __init__(self, index: int) -> None:
        self.address = AgvAddress.of(VERSION, "acme", f"agv{index}")
        self._headers = HeaderCounter(VERSION, self.address)
        self._step, self.sent = index, 0

    def connection(self) -> tuple[str, bytes]:
        """Return topic and payload of the message that it is online."""
        header = self._headers.next(topics.CONNECTION, epoch())
        payload = encode(topics.CONNECTION, header, Connection(connection_state="ONLINE"), VERSION)
        return self.address.topic(topics.CONNECTION), payload

    def state(self) -> tuple[str, bytes]:
        """Return topic and payload of the next state."""
        self._step += 1
        self.sent += 1
        header = self._headers.next(topics.STATE, epoch())
        return self.address.topic(topics.STATE), encode(topics.STATE, header, _state(self._step), VERSION)


def _state(step: int) -> State:
    angle = 0.05 * step
    x, y = 5.0 * math.cos(angle), 5.0 * math.sin(angle)
    nodes = [NodeState(node_id=f"n{index}", sequence_id=2 * index, released=True) for index in range(1, NODES + 1)]
    edges = [EdgeState(edge_id=f"e{index}", sequence_id=2 * index - 1, released=True) for index in range(1, NODES + 1)]
    return State(
        order_id="transport", order_update_id=0, last_node_id="n0", last_node_sequence_id=0,
        driving=True, operating_mode="AUTOMATIC", node_states=nodes, edge_states=edges,
        action_states=[], instant_action_states=[], errors=[],
        power_supply=PowerSupply(state_of_charge=80.0, charging=False),
        safety_state=SafetyState(active_emergency_stop="NONE", field_violation=False),
        mobile_robot_position=Position(x=x, y=y, theta=0.0, map_id="hall", localized=True),
        velocity=Velocity(vx=0.5, vy=0.0, omega=0.1),
    )  # fmt: skip


async def measure_agvs(progress: "Progress", agvs: int, seconds: float) -> list[Figure]:
    """Return the figures of a bridge with some AGVs, measured for a time [s].

    Raises
    ------
    InvalidInput
        mosquitto is not installed.
    Unavailable
        The AGVs were not connected in time.
    """
    task = progress.add_task("AGVs as robots", total=2)
    with tempfile.TemporaryDirectory() as folder:
        async with (
            broker(Path(folder)) as port, _cloud() as (url, robots), Client("127.0.0.1", port) as client,
            bridge_process(["agv"], port, url, Path(folder) / "bridge.log", agvs) as bridge,
        ):  # fmt: skip
            fleet = [ReportingAgv(index) for index in range(agvs)]
            for agv in fleet:
                await client.publish(*agv.connection(), qos=1, retain=True)
            over = asyncio.Event()
            reporting = asyncio.create_task(_report(client, fleet, over))
            try:
                await bridge.until_all(lambda: len(robots), "are connected", CONNECTED_WITHIN)
                progress.advance(task)
                part = f"{agvs} AGVs as robots"
                figures = await bridge.figures(part, lambda: sum(agv.sent for agv in fleet), "that were sent", seconds)
                progress.advance(task)
            finally:
                over.set()  # a client of MQTT may lose a cancellation
                await reporting
    return figures


async def _report(client: Client, fleet: Sequence[ReportingAgv], over: asyncio.Event) -> None:
    """Publish a state a second of each AGV, spread over the second, until it is over."""
    while not over.is_set():
        began = monotonic()
        for index in range(0, len(fleet), BATCH):
            await asyncio.gather(*(client.publish(*agv.state()) for agv in fleet[index : index + BATCH]))
            await asyncio.sleep(max(began + PERIOD * index / len(fleet) - monotonic(), 0.0))
        await asyncio.sleep(max(began + PERIOD - monotonic(), 0.0))


@asynccontextmanager
async def _cloud() -> AsyncIterator[tuple[str, set[ServerConnection]]]:
    """Run a stand-in for a cloud, which reads what robots send; yield its URL and the robots."""
    robots: set[ServerConnection] = set()

    async def read(connection: ServerConnection) -> None:
        robots.add(connection)
        try:
            async for _ in connection:
                pass
        finally:
            robots.discard(connection)

    async with serve(read, "127.0.0.1", 0, compression=None, process_request=_answer) as server:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}", robots


def _answer(connection: ServerConnection, request: Request) -> Response | None:
    """Answer requests of REST; others open a WebSocket."""
    if not request.path.startswith("/v1/"):
        return None
    robot = {"map": "hall", "model": "turtlebot2", "parameters": {"follow_path": {}}}
    response = connection.respond(HTTPStatus.OK, msgspec.json.encode(robot).decode())
    response.headers["Connection"] = "close"
    return response
