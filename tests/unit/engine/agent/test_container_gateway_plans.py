"""Requests of a container for plans and planning history, through the container gateway."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from engine.agent.container_gateway import ContainerGateway
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from ppaas.plans.history import LinkHistory, failed_row
from storage.memory.store import MemoryStore
from tests.support.engine.attached_container import attach_container
from tests.support.engine.engine_links import receive
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.kept_plans import PARAMETERS, record
from tests.support.engine.specs import planning_spec
from tests.support.waiting import until

Stream = FrameStream[machine_link.ToContainer]
SPEC = planning_spec()
KEY = (SPEC.map.id, SPEC.map.version, "dijkstra", 3)


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
async def container(tmp_path: Path, store: MemoryStore) -> AsyncIterator[Stream]:
    gateway = ContainerGateway(tmp_path / "gate.sock", store, FakeFabric(), link="m1")
    await gateway.start()
    stream = await attach_container(gateway, SPEC)
    yield stream
    await stream.close()
    await gateway.close()


def find(request: int, tolerance: float = 0.25) -> machine_link.FindPlans:
    return machine_link.FindPlans(request, (0.0, 0.0), (20.0, 0.0), "dijkstra", PARAMETERS, 0.18, tolerance, False)


async def test_found_plans_carry_the_request_number(container: Stream, store: MemoryStore) -> None:
    store.add_plan(record("p1", 0.0, 20.0))
    container.write(find(7))
    found = await receive(container)
    assert isinstance(found, machine_link.PlansFound)
    assert (found.request, [each.plan.id for each in found.plans]) == (7, ["p1"])


async def test_invalid_search_is_refused_and_the_connection_stays_open(container: Stream) -> None:
    container.write(find(8, tolerance=-1.0))
    refused = await receive(container)
    assert isinstance(refused, machine_link.Done)
    assert refused.refusal is not None and (refused.request, refused.refusal.slug) == (8, "invalid-input")
    container.write(find(9))
    assert isinstance(await receive(container), machine_link.PlansFound)


async def test_noted_history_is_returned_on_request(container: Stream, store: MemoryStore) -> None:
    link = LinkHistory("m1", 0.001, 1e8, 4, 5.0)
    container.write(machine_link.NoteHistory([failed_row(KEY)], link))
    await until(lambda: bool(store.links()))
    container.write(machine_link.AskHistory(3))
    history = await receive(container)
    assert history == machine_link.PlanningHistory(3, [failed_row(KEY)], "m1", link)


async def test_history_of_another_map_is_dropped_and_the_connection_stays(
    container: Stream, store: MemoryStore
) -> None:
    container.write(machine_link.NoteHistory([failed_row(("depot", *KEY[1:]))]))
    container.write(find(1))
    assert isinstance(await receive(container), machine_link.PlansFound)
    assert store.history("depot") == []
