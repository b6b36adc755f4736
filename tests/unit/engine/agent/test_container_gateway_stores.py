"""Requests of containers to the stores, through the container gateway: checkpoints, plans and planning history.

A machine that its master may have given up stores no checkpoint: another may have made a later one.
"""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from engine.agent.container_gateway import ContainerGateway
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.work_counts import FAILED, REUSED
from ppaas.errors import NotFound
from ppaas.plans.history import LinkHistory, failed_row
from storage.memory.store import MemoryStore
from tests.support.engine.attached_container import attach_container
from tests.support.engine.engine_links import dial_gateway, receive
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.kept_plans import PARAMETERS, record
from tests.support.engine.specs import planning_spec, robot_spec
from tests.support.waiting import until


@asynccontextmanager
async def attached(gateway: ContainerGateway) -> AsyncIterator[FrameStream[machine_link.ToContainer]]:
    """Start the gateway; return the machine link of container c1, with the clone of robot tb1 of ann."""
    await gateway.start()
    gateway.expect(robot_spec("c1", "ann", "tb1"), "secret")
    stream = await dial_gateway(gateway.path)
    stream.write(machine_link.AttachContainer("c1", "secret"))
    yield stream
    await stream.close()
    await gateway.close()


async def test_checkpoints_are_stored_only_while_the_lease_holds(tmp_path: Path) -> None:
    store, acting = MemoryStore(), False
    gateway = ContainerGateway(tmp_path / "gate.sock", store, FakeFabric(), acts=lambda: acting)
    async with attached(gateway) as stream:
        stream.write(machine_link.SaveClone(1, {"n": b"old"}))
        refused = await receive(stream)
        assert refused.refusal.slug == "conflict" and "lost contact with its cloud" in refused.refusal.text
        with pytest.raises(NotFound):
            store.clone("ann", "tb1")
        acting = True
        stream.write(machine_link.SaveClone(2, {"n": b"new"}))
        assert await receive(stream) == machine_link.Done(2)
        assert store.clone("ann", "tb1").nodes["n"] == b"new"


async def test_outage_of_the_store_is_told_from_a_lost_cloud(tmp_path: Path) -> None:
    gateway = ContainerGateway(
        tmp_path / "gate.sock", MemoryStore(), FakeFabric(), acts=lambda: False, may_be_replaced=lambda: False
    )
    async with attached(gateway) as stream:
        stream.write(machine_link.SaveClone(1, {"n": b"state"}))
        refused = await receive(stream)
        assert refused.refusal.slug == "unavailable", "the container publishes what waits for the checkpoint"
        assert "start the store" in refused.refusal.text
        gateway.shut_out("c1")
        stream.write(machine_link.SaveClone(2, {"n": b"late"}))
        assert (await receive(stream)).refusal.slug == "conflict", "it was replaced on this machine"


async def test_shut_out_container_cannot_save_or_share(tmp_path: Path) -> None:
    store, fabric = MemoryStore(), FakeFabric()
    gateway = ContainerGateway(tmp_path / "gate.sock", store, fabric)
    async with attached(gateway) as stream:
        stream.write(machine_link.SaveClone(1, {"n": b"old"}))
        assert await receive(stream) == machine_link.Done(1)
        gateway.shut_out("c1")
        stream.write(machine_link.FabricPublish("amcl_pose", b"{}"))
        stream.write(machine_link.SaveClone(2, {"n": b"late"}))
        refused = await receive(stream)
        assert refused.refusal.slug == "conflict"
        assert store.clone("ann", "tb1").nodes["n"] == b"old"
        assert fabric.published == []


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


async def test_counts_of_containers_are_added_up_and_impossible_ones_are_dropped(tmp_path: Path) -> None:
    gateway = ContainerGateway(tmp_path / "gate.sock", MemoryStore(), FakeFabric())
    async with attached(gateway) as stream:
        for counts in ({FAILED: 2}, {FAILED: -1}, {"coffee": 1}, {FAILED: 3, REUSED: 1}):
            stream.write(machine_link.NoteHistory([], None, counts))
        await until(lambda: gateway.work[REUSED])
        assert gateway.work == {FAILED: 5, REUSED: 1}
