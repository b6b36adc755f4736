"""Watch over the disk of the data folder: it keeps the reserve, and logs when space runs out and when it is back."""

import asyncio
import logging
from pathlib import Path

import pytest

from endpoints.resources import store_health
from endpoints.resources.store_health import DiskWatch, disk_state
from storage.disk_space import DiskReserve, DiskSpace
from storage.memory.store import MemoryStore
from tests.support.waiting import until

MB = 1 << 20


class Disk:
    """A disk of 1000 MiB whose free space a test sets."""

    free = 500

    def of(self, folder: Path) -> DiskSpace:
        if not folder.exists():
            raise FileNotFoundError(folder)
        return DiskSpace(1000 * MB, self.free * MB, 1000)


@pytest.fixture
def disk() -> Disk:
    return Disk()


@pytest.fixture
def reserve(tmp_path: Path, disk: Disk) -> DiskReserve:
    return DiskReserve(tmp_path, disk.of)


def test_little_space_and_a_full_disk_are_one_line_each_and_so_is_their_end(
    reserve: DiskReserve, disk: Disk, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    watch = DiskWatch(reserve)
    for disk.free in (500, 40, 39, 1, 1, 12, 500, 500):
        watch.check()
    assert [line.split(":")[0] for line in caplog.messages] == [
        "the disk of the data folder has little space left (40 MiB)",
        "the disk of the data folder is FULL (1 MiB left)",
        "the disk of the data folder is not full any more",
        "the disk of the data folder is not low any more",
    ]


def test_space_that_a_store_does_not_need_is_freed_once_when_the_disk_becomes_full(
    reserve: DiskReserve, disk: Disk
) -> None:
    freed: list[None] = []
    watch = DiskWatch(reserve, lambda: freed.append(None))
    for disk.free in (500, 1, 1, 500, 1):
        watch.check()
    assert len(freed) == 2


def test_health_tells_the_state_and_what_to_do(reserve: DiskReserve, disk: Disk, tmp_path: Path) -> None:
    watch = DiskWatch(reserve)
    found = []
    for disk.free in (500, 40, 1):
        watch.check()
        found.append(disk_state(reserve))
    fine, low, full = found
    assert fine is not None and fine.reason is None
    assert low is not None and low.state == "low" and "40 MiB of 1000 MiB are left: free space" in str(low.reason)
    assert full is not None and full.state == "full" and "remove maps, plans or users" in str(full.reason)
    assert disk_state(DiskReserve(tmp_path / "nowhere")) is None


def test_a_disk_that_cannot_be_measured_is_reported_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    watch = DiskWatch(DiskReserve(tmp_path / "nowhere"))
    assert watch.check() == watch.check() == "ok"
    (line,) = caplog.messages
    assert "cannot be measured" in line


async def test_a_cloud_without_a_reserve_is_not_watched() -> None:
    watch = DiskWatch.of(None, MemoryStore())
    await watch.run()
    assert watch.check() == "ok"


async def test_a_change_of_the_space_is_reported_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_health, "PERIOD", 0.001)
    free, seen = [1 << 40], list[tuple[str, bool]]()
    reserve = DiskReserve(tmp_path, lambda _: DiskSpace(1 << 40, free[0], 1000))
    watch = DiskWatch(reserve, changed=lambda state, reason: seen.append((state, bool(reason))))
    watching = asyncio.create_task(watch.run())
    for left, state in ((1 << 29, "low"), (0, "full"), (1 << 40, "ok")):
        free[0] = left
        await until(lambda state=state: seen and seen[-1][0] == state)  # type: ignore[misc]
    watching.cancel()
    await asyncio.gather(watching, return_exceptions=True)
    assert seen == [("low", True), ("full", True), ("ok", False)]
