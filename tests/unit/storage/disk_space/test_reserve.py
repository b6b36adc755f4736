from pathlib import Path

import pytest

from storage.disk_space.reserve import MAX_RESERVE, MIN_RESERVE, RESERVE, DiskReserve, DiskSpace

MB = 1 << 20


class Disk:
    """A disk of 100 MiB whose free space a test sets; the reserve takes space of it."""

    def __init__(self, total: int = 100 * MB) -> None:
        self.total, self.others, self.files = total, 0, 1000

    def of(self, folder: Path) -> DiskSpace:
        reserve = folder / RESERVE
        used = self.others + (reserve.stat().st_size if reserve.exists() else 0)
        return DiskSpace(self.total, max(self.total - used, 0), self.files)


@pytest.fixture
def disk() -> Disk:
    return Disk()


@pytest.fixture
def reserve(tmp_path: Path, disk: Disk) -> DiskReserve:
    return DiskReserve(tmp_path, disk.of)


def test_space_is_set_aside_at_the_start(reserve: DiskReserve, tmp_path: Path) -> None:
    assert reserve.keep() == "ok"
    assert (tmp_path / RESERVE).stat().st_size == MIN_RESERVE
    assert (tmp_path / RESERVE).stat().st_blocks * 512 >= MIN_RESERVE


def test_a_disk_with_little_space_is_low_before_it_is_full(reserve: DiskReserve, disk: Disk) -> None:
    reserve.keep()
    disk.others = 95 * MB
    assert reserve.keep() == "low"
    assert not reserve.is_full()


def test_a_full_disk_gives_the_reserve_up_and_stays_full_until_there_is_space_for_another(
    reserve: DiskReserve, disk: Disk, tmp_path: Path
) -> None:
    reserve.keep()
    disk.others = 99 * MB
    assert reserve.is_full()
    assert reserve.keep() == "full"
    assert not (tmp_path / RESERVE).exists()
    assert reserve.space().free == MB
    assert reserve.keep() == "full"
    disk.others = 97 * MB
    assert reserve.keep() == "low"
    disk.others = 50 * MB
    assert reserve.keep() == "ok"
    assert (tmp_path / RESERVE).exists()


def test_a_disk_on_which_no_file_can_be_created_is_full(reserve: DiskReserve, disk: Disk) -> None:
    reserve.keep()
    disk.files = 0
    assert reserve.keep() == "full"


def test_every_process_sees_that_the_reserve_was_given_up(reserve: DiskReserve, disk: Disk, tmp_path: Path) -> None:
    other = DiskReserve(tmp_path, disk.of)
    reserve.keep()
    assert not other.is_full()
    disk.others = 99 * MB + MB // 2
    reserve.keep()
    assert other.is_full()


def test_the_size_of_the_reserve_has_bounds(reserve: DiskReserve) -> None:
    assert reserve.size(DiskSpace(1 << 50, 0, 1)) == MAX_RESERVE
    assert reserve.size(DiskSpace(0, 0, 1)) == MIN_RESERVE


def test_a_real_disk_is_measured(tmp_path: Path) -> None:
    space = DiskSpace.of(tmp_path)
    assert 0 < space.free <= space.total
    assert space.files > 0


def test_a_disk_that_cannot_be_measured_does_not_count_as_full(tmp_path: Path) -> None:
    assert not DiskReserve(tmp_path / "nowhere").is_full()


def test_the_reserve_is_removed_with_its_owner(reserve: DiskReserve, tmp_path: Path) -> None:
    reserve.keep()
    reserve.release()
    reserve.release()
    assert list(tmp_path.iterdir()) == []
