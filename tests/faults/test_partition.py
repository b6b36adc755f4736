"""The network between two machines loses all packets for some seconds and heals: no robot is served twice."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from benchmarks.chaos.message_checks import MessageChecks
from ppaas.maps.grid import GridMap
from ppaas.messages.move_base_msgs import MoveBaseActionFeedback
from robots.client.rest import RestClient
from tests.e2e.test_two_machines import HERE, THERE, all_arrive, driving_on_both
from tests.support.cloud.cloud import RunningCloud, running_cloud
from tests.support.cloud.drive import Drive
from tests.support.cloud.joined_machine import JoinedMachine, container_of, machines, ticket
from tests.support.engine.processes import has_ended
from tests.support.network.partition import Namespace, NetworkPath, through_a_proxy
from tests.support.waiting import patience

pytestmark = pytest.mark.journey

CUT = 6.0
"""Time without a packet [s]; the master gives a machine up after 4 s."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cut")


@pytest.fixture(scope="module")
def wide(folder: Path) -> Iterator[RunningCloud]:
    """Return a cloud that accepts machines on all of its addresses."""
    with running_cloud(folder, "--listen-machines", "0.0.0.0:0", "--linger", "1", "--adopt-within", "2") as running:
        yield running


@pytest.fixture
def namespace() -> Iterator[Namespace]:
    """Return a network namespace; skips where namespaces are not allowed."""
    made = Namespace()
    made.add()
    yield made
    made.remove()


async def test_a_partition_of_the_network_heals(
    namespace: Namespace,
    wide: RunningCloud,
    folder: Path,
    office_map: GridMap,
    record_property: Callable[[str, object], None],
) -> None:
    rest = await wide.admin()
    shown = ticket(folder / "data", "--host", namespace.address, "--name", THERE)
    async with (
        second_machine(folder / "n", rest, namespace.way, shown),
        driving_on_both(wide, rest, office_map, ("n1", "n2")) as drives,
    ):
        await cut_for_a_while(namespace.way, rest, drives)
        record_property("longest_gap_s", await all_arrive(drives))


async def test_links_that_lose_all_packets_heal(
    wide: RunningCloud, folder: Path, office_map: GridMap, record_property: Callable[[str, object], None]
) -> None:
    rest = await wide.admin()
    async with (
        through_a_proxy(folder / "data", THERE) as (way, shown),
        second_machine(folder / "p", rest, way, shown),
        driving_on_both(wide, rest, office_map, ("p1", "p2")) as drives,
    ):
        await cut_for_a_while(way, rest, drives)
        record_property("longest_gap_s", await all_arrive(drives))


@asynccontextmanager
async def second_machine(folder: Path, rest: RestClient, way: NetworkPath, shown: str) -> AsyncIterator[None]:
    """Join a machine over a network path; at the end it must be a member again, and it leaves nothing behind."""
    machine = JoinedMachine(folder, THERE, way.within)
    machine.start(shown)
    try:
        await machine.is_in(rest)
        yield
        await machine.is_in(rest)
    finally:
        machine.end()
        await until_gone(rest)


async def until_gone(rest: RestClient) -> None:
    async with patience(10.0):
        while await machines(rest) != [HERE]:
            await asyncio.sleep(0.02)


async def cut_for_a_while(way: NetworkPath, rest: RestClient, drives: dict[str, Drive]) -> None:
    """Cut the network path, check which machine serves which robot, and restore it; no robot receives two clones."""
    loop = asyncio.get_running_loop()
    wrong: list[str] = []
    for name, drive in drives.items():
        await listen(drive, MessageChecks(name, wrong.append))
    cut_off = tuple(drives)[1]
    left = await container_of(rest, cut_off)
    assert left["machine"] == THERE
    way.cut()
    healed = loop.time() + CUT
    async with patience(20.0):
        await until_gone(rest)
        while not has_ended(left["pid"]):
            await asyncio.sleep(0.02)  # it ends by itself: it cannot be reached
        while [c["machine"] for c in await rest.items("/v1/containers") if c["robot"] == cut_off] != [HERE]:
            await asyncio.sleep(0.02)
    await asyncio.sleep(max(0.0, healed - loop.time()))
    assert await machines(rest) == [HERE], "no packet was delivered"
    way.mend()
    async with patience(60.0):
        while await machines(rest) != [HERE, THERE]:
            await asyncio.sleep(0.02)
    assert wrong == []


async def listen(drive: Drive, witness: MessageChecks) -> None:
    """Record the control cycles that a robot receives from now on."""

    def cycled(message: MoveBaseActionFeedback) -> None:
        witness.cycled(message.header.stamp.seconds())

    await drive.robot.subscribe("move_base/feedback", MoveBaseActionFeedback, cycled)
