"""A machine that its master may have given up stores no checkpoint: another may have made a later one."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from engine.agent.container_gateway import ContainerGateway
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from ppaas.errors import NotFound
from storage.memory.store import MemoryStore
from tests.support.engine.engine_links import dial_gateway, receive
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.specs import robot_spec


@asynccontextmanager
async def attached(gateway: ContainerGateway) -> AsyncIterator[FrameStream[machine_link.ToContainer]]:
    """Start the gateway; return the machine link of container c1, with the clone of robot tb1 of ann."""
    await gateway.start()
    gateway.expect(robot_spec("c1", "ann", "tb1"), "secret")
    stream = await dial_gateway(gateway.path)
    stream.write(machine_link.Attach("c1", "secret"))
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
        stream.write(machine_link.Share("amcl_pose", b"{}"))
        stream.write(machine_link.SaveClone(2, {"n": b"late"}))
        refused = await receive(stream)
        assert refused.refusal.slug == "conflict"
        assert store.clone("ann", "tb1").nodes["n"] == b"old"
        assert fabric.published == []
