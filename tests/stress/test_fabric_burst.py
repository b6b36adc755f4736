"""Joint: a burst of publications to one healthy reader, as the fabric sends them and with Zenoh's ``express``."""

import asyncio
import contextlib
from collections.abc import Callable

import pytest
import zenoh

from engine.fabric.router import RouterProcess
from engine.fabric.session import Fabric
from engine.fabric.zenoh_config import client_config
from tests.stress.conftest import Figure
from tests.support.waiting import patience

pytestmark = pytest.mark.joint

BURST = 2000
PAYLOAD = bytes(600)
"""Payload of the size of a position with its covariance."""

Publish = Callable[[str, bytes], None]


async def arrived(router: RouterProcess, reader: Fabric, key: str, publish: Publish) -> int:
    """Publish a burst; return the number of messages that arrive."""
    received = 0
    changed = asyncio.Event()

    def take(_key: str, payload: bytes) -> None:
        nonlocal received
        received += len(payload) == len(PAYLOAD)
        changed.set()

    subscription = reader.subscribe(key, take, limit=2 * BURST)
    async with patience(10):
        while not changed.is_set():  # until the router knows of the reader
            publish(key, b"x")
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(changed.wait(), 0.05)
    for _ in range(BURST):
        publish(key, PAYLOAD)
    with contextlib.suppress(TimeoutError):
        while received < BURST:  # or until nothing has come for a second
            changed.clear()
            await asyncio.wait_for(changed.wait(), 1.0)
    subscription.close()
    return received


async def test_a_burst_to_a_healthy_reader_arrives(tmp_path, figure: Figure) -> None:
    router = RouterProcess(tmp_path / "run")
    await router.start()
    reader, writer = [await Fabric.open(router.endpoint, router.credentials) for _ in range(2)]
    session = await asyncio.to_thread(zenoh.open, client_config(router.endpoint, router.credentials))

    def express(key: str, payload: bytes) -> None:
        session.put(key, payload, congestion_control=zenoh.CongestionControl.DROP, express=True)

    # Other processes of this host may delay the reader, but hardly in each attempt.
    wholes = [await arrived(router, reader, f"burst/batched-{attempt}", writer.publish) for attempt in range(3)]
    whole, singly = max(wholes), await arrived(router, reader, "burst/express", express)
    figure(f"of a burst of {BURST} arrived", str(whole))
    figure(f"of a burst of {BURST} arrived with express", str(singly))
    await asyncio.to_thread(session.close)
    for fabric in (reader, writer):
        await fabric.close()
    await router.close()
    assert whole > 0.9 * BURST
    assert whole > singly
