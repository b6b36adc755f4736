"""Group commit of several threads."""

import threading
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from storage.sqlite import group_commit
from storage.sqlite.group_commit import GroupCommit
from tests.support.waiting import wait_until


class Disk:
    """Commits numbers, with their squares as results; while `open` is not set, commits block."""

    def __init__(self) -> None:
        self.open = threading.Event()
        self.open.set()
        self.groups: list[list[int]] = []

    def commit(self, given: Sequence[int]) -> list[int]:
        self.groups.append(list(given))
        assert self.open.wait(10.0)
        if 13 in given:
            raise OSError("the disk is full")
        return [number * number for number in given]


@pytest.fixture
def disk() -> Disk:
    return Disk()


@pytest.fixture
def threads():
    with ThreadPoolExecutor(8) as pool:
        yield pool


def _held_by_one(
    disk: Disk, group: GroupCommit[int, int], threads: ThreadPoolExecutor, *later: int
) -> list[Future[int]]:
    """Block one commit, and submit others meanwhile; return the futures of all."""
    disk.open.clear()
    first = threads.submit(group.submit, 1)
    wait_until(lambda: disk.groups == [[1]])
    others = []
    for count, number in enumerate(later, 1):
        others.append(threads.submit(group.submit, number))
        wait_until(lambda count=count: len(group._waiting) == count)
    return [first, *others]


def test_a_single_caller_is_committed_alone(disk: Disk) -> None:
    group = GroupCommit(disk.commit)
    assert [group.submit(number) for number in (2, 3)] == [4, 9]
    assert disk.groups == [[2], [3]]


def test_callers_that_arrive_during_a_commit_are_committed_together(disk: Disk, threads: ThreadPoolExecutor) -> None:
    futures = _held_by_one(disk, GroupCommit(disk.commit), threads, 2, 3, 4)
    disk.open.set()
    assert [each.result(10.0) for each in futures] == [1, 4, 9, 16]
    assert disk.groups == [[1], [2, 3, 4]]


def test_an_error_is_raised_to_all_of_its_group_and_to_no_other(disk: Disk, threads: ThreadPoolExecutor) -> None:
    group = GroupCommit(disk.commit)
    futures = _held_by_one(disk, group, threads, 2, 13)
    disk.open.set()
    assert futures[0].result(10.0) == 1
    assert [str(each.exception(10.0)) for each in futures[1:]] == ["the disk is full"] * 2
    assert group.submit(5) == 25


def test_an_error_of_one_caller_is_raised_to_that_caller_only(disk: Disk, threads: ThreadPoolExecutor) -> None:
    def commit(given: Sequence[int]) -> list[int | Exception]:
        return [ValueError(f"{square} is odd") if square % 2 else square for square in disk.commit(given)]

    futures = _held_by_one(disk, GroupCommit(commit), threads, 2, 3, 4)
    disk.open.set()
    assert [each.result(10.0) for each in (futures[1], futures[3])] == [4, 16]
    assert [str(each.exception(10.0)) for each in (futures[0], futures[2])] == ["1 is odd", "9 is odd"]


def test_the_leader_waits_for_the_other_callers_of_the_last_group(
    disk: Disk, threads: ThreadPoolExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(group_commit, "MAX_WAIT", 20.0)
    group = GroupCommit(disk.commit)
    futures = _held_by_one(disk, group, threads, 2, 3)
    disk.open.set()
    assert [each.result(10.0) for each in futures] == [1, 4, 9]
    group._last_duration = 20.0
    first = threads.submit(group.submit, 4)
    wait_until(lambda: len(group._waiting) == 1)
    assert group.submit(5) == 25
    assert first.result(10.0) == 16
    assert disk.groups == [[1], [2, 3], [4, 5]]
    monkeypatch.undo()
    group._last_duration = 20.0  # no other caller comes
    assert group.submit(6) == 36


@given(st.lists(st.integers(0, 12), max_size=40), st.integers(1, 6))
def test_each_caller_gets_its_own_result(numbers: list[int], threads: int) -> None:
    disk = Disk()
    group = GroupCommit(disk.commit)
    with ThreadPoolExecutor(threads) as pool:
        assert list(pool.map(group.submit, numbers)) == [number * number for number in numbers]
    assert sorted(number for some in disk.groups for number in some) == sorted(numbers)
