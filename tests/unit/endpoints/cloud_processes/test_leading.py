"""A leader hands over: its own machine and endpoints end, it gives the lease back, and exits without a clean end."""

import asyncio
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest

from endpoints.cloud_processes import leading
from endpoints.cloud_processes.leading import asked_to_hand_over, hand_over
from engine.leadership.candidate import LeaseTiming
from engine.leadership.leadership import MASTER, Leadership
from storage.memory.store import MemoryStore
from tests.support.waiting import patience, until

PATIENT = LeaseTiming(renew=0.05, look=0.02, validity=5.0, patience=60.0)


class Exited(BaseException):
    """Stands in for the end of this process."""


class Host:
    """A cloud process with its machine and endpoints; records the order in which they end."""

    def __init__(self, store: MemoryStore, leadership: Leadership) -> None:
        self._store = store
        self.leadership = leadership
        self.ended: list[tuple[str, str]] = []

    async def end_machine(self) -> None:
        self.ended.append(("machine", self._store.lease(MASTER).holder))

    async def end_endpoints(self) -> None:
        self.ended.append(("endpoints", self._store.lease(MASTER).holder))

    async def hands_over(self) -> None:
        await hand_over(self.leadership, self._store, self.end_machine, self.end_endpoints)


@asynccontextmanager
async def leader(store: MemoryStore) -> AsyncIterator[Host]:
    leadership = Leadership(store, "a", PATIENT)
    await leadership.acquire(standby=False)
    yield Host(store, leadership)
    await leadership.release()


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the exit statuses; nothing waits for long."""
    statuses: list[int] = []

    def end(status: int) -> None:
        statuses.append(status)
        raise Exited

    monkeypatch.setattr(os, "_exit", end)
    monkeypatch.setattr(leading, "ARRIVAL", 0.0)
    monkeypatch.setattr(leading, "SUCCESSION", 0.3)
    monkeypatch.setattr(leading, "LOOK", 0.01)
    monkeypatch.setattr(leading.logging, "shutdown", lambda: None)
    return statuses


async def test_a_standby_leads_at_once_and_only_then_do_endpoints_end(quick: list[int]) -> None:
    store = MemoryStore()
    async with leader(store) as host:
        heir = Leadership(store, "b", PATIENT)
        waiting = asyncio.create_task(heir.acquire(standby=True))
        with pytest.raises(Exited):
            async with patience(20.0):
                await host.hands_over()
        await waiting
        assert host.ended == [("machine", "a"), ("endpoints", "b")]
        assert (quick, heir.leads(), heir.epoch) == ([0], True, 2)
        await heir.release()


async def test_without_a_standby_the_status_is_one(quick: list[int], caplog: pytest.LogCaptureFixture) -> None:
    store = MemoryStore()
    async with leader(store) as host:
        with pytest.raises(Exited):
            await host.hands_over()
        assert host.ended == [("machine", "a"), ("endpoints", "")]
        assert quick == [1] and "no standby leads" in caplog.text


async def test_a_signal_asks_for_it() -> None:
    asked = asked_to_hand_over()
    try:
        os.kill(os.getpid(), leading.signal.SIGUSR1)
        await until(asked.is_set)
    finally:
        asyncio.get_running_loop().remove_signal_handler(leading.signal.SIGUSR1)
