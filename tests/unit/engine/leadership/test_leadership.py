"""Leaderships of several processes over one store."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from engine.leadership.candidate import LeaseTiming
from engine.leadership.leadership import FILE, MASTER, Leadership, holder_of
from ppaas.errors import Unavailable
from storage.memory.store import MemoryStore
from storage.records import Lease
from tests.support.waiting import until

QUICK = LeaseTiming(renew=0.05, look=0.02, validity=0.2, patience=0.3)
PATIENT = LeaseTiming(renew=0.05, look=0.02, validity=0.2, patience=60.0)


class Reached(MemoryStore):
    """A process's connection to the store, which can be cut."""

    def __init__(self, store: MemoryStore) -> None:
        super().__init__()
        self._behind = store
        self.cut = False

    def lease(self, name: str) -> Lease:
        self._check()
        return self._behind.lease(name)

    def change_lease(self, lease: Lease, *, instead_of: Lease) -> bool:
        self._check()
        return self._behind.change_lease(lease, instead_of=instead_of)

    def _check(self) -> None:
        if self.cut:
            raise Unavailable("the network is down")


@pytest.fixture
def store() -> Iterator[MemoryStore]:
    yield MemoryStore()


@asynccontextmanager
async def process(store: MemoryStore, name: str, timing: LeaseTiming = QUICK) -> AsyncIterator[Leadership]:
    leadership = Leadership(store, name, timing)
    yield leadership
    await leadership.release()


async def test_a_process_leads_renews_and_releases(store: MemoryStore) -> None:
    async with process(store, "a", PATIENT) as first:
        assert not first.leads()
        await first.acquire(standby=False)
        assert (first.epoch, first.former) == (1, "")
        await until(lambda: store.lease(MASTER).beat >= 2 and first.leads())
    assert (store.lease(MASTER).holder, first.leads()) == ("", False)
    async with process(store, "b", PATIENT) as second:
        await second.acquire(standby=True)
        assert (second.epoch, second.former) == (2, ""), "without patience"


async def test_a_process_that_is_no_standby_is_told_who_leads(store: MemoryStore) -> None:
    async with process(store, "a", PATIENT) as first, process(store, "b", PATIENT) as second:
        await first.acquire(standby=False)
        with pytest.raises(Unavailable, match=r"another cloud leads with this store, a: .* --standby"):
            await second.acquire(standby=False)
        assert not second.leads()
        await until(first.leads)


async def test_a_restarted_process_leads_at_once(store: MemoryStore) -> None:
    assert store.change_lease(Lease(MASTER, "a", 3), instead_of=Lease(MASTER))
    async with process(store, "a", PATIENT) as again:
        await again.acquire(standby=False)
        assert (again.epoch, again.former) == (4, "")


async def test_a_standby_replaces_a_leader_without_a_store_which_finds_out(store: MemoryStore) -> None:
    reached = Reached(store)
    async with process(reached, "a") as first, process(store, "b") as second:
        await first.acquire(standby=False)
        losing = asyncio.create_task(first.lost())
        reached.cut = True
        await second.acquire(standby=True)
        assert (second.epoch, second.former, first.leads()) == (2, "a", False)
        assert not losing.done(), "it cannot know"
        reached.cut = False
        await asyncio.wait_for(losing, 10)
        await until(second.leads)
        assert not first.leads()


async def test_a_leader_whose_store_is_back_leads_on_and_says_so(
    store: MemoryStore, caplog: pytest.LogCaptureFixture
) -> None:
    reached, renewals = Reached(store), 0

    def renewed() -> None:
        nonlocal renewals
        renewals += 1

    async with process(reached, "a") as leadership:
        leadership.renewed = renewed
        await leadership.acquire(standby=False)
        reached.cut = True
        await until(lambda: not leadership.leads())
        before, told = renewals, [record.levelname for record in caplog.records]
        assert told == ["ERROR"], "not that it was renewed, which would be wrong"
        reached.cut = False
        await until(lambda: leadership.leads() and renewals > before)
        assert leadership.epoch == 1
    assert "the lease of the master is renewed" in caplog.text


async def test_a_leader_that_hears_of_a_later_epoch_is_replaced(store: MemoryStore) -> None:
    async with process(store, "a", PATIENT) as leadership:
        await leadership.acquire(standby=False)
        losing = asyncio.create_task(leadership.lost())
        leadership.heard_of(1)
        await until(leadership.leads)
        leadership.heard_of(2)
        await asyncio.wait_for(losing, 10)
        assert not leadership.leads()


async def test_a_store_that_cannot_be_used_ends_a_start_but_no_standby(store: MemoryStore) -> None:
    reached = Reached(store)
    reached.cut = True
    async with process(reached, "a") as first, process(reached, "b") as second:
        with pytest.raises(Unavailable, match="network"):
            await first.acquire(standby=False)
        waiting = asyncio.create_task(second.acquire(standby=True))
        await asyncio.sleep(0.1)
        assert not waiting.done()
        reached.cut = False
        await asyncio.wait_for(waiting, 10)
        assert second.leads()


async def test_a_lease_that_cannot_be_released_is_left(store: MemoryStore) -> None:
    reached = Reached(store)
    async with process(reached, "a", PATIENT) as leadership:
        await leadership.acquire(standby=False)
        reached.cut = True
    assert store.lease(MASTER).holder == "a"
    assert not leadership.leads()


@pytest.mark.parametrize("change", [lambda file: file.unlink(), lambda file: file.write_text("{")])
def test_the_identity_of_a_data_folder_stays_until_it_is_lost(tmp_path: Path, change: Callable[[Path], object]) -> None:
    first = holder_of(tmp_path)
    assert holder_of(tmp_path) == first
    change(tmp_path / FILE)
    assert holder_of(tmp_path) != first


def test_a_copy_of_a_data_folder_is_another_holder(tmp_path: Path) -> None:
    original, copy = tmp_path / "a", tmp_path / "b"
    for folder in (original, copy):
        folder.mkdir()
    name = holder_of(original)
    (copy / FILE).write_bytes((original / FILE).read_bytes())
    assert holder_of(copy).partition("#")[2] != name.partition("#")[2]
