"""A planner of a container uses indexes that its machine prepared, and works without."""

import asyncio
from pathlib import Path

import pytest

from engine.container.shared_indexes import SharedIndexes
from engine.specs.layer_files import write_index
from ppaas.errors import InvalidPlanner, PlanCancelled, Unavailable
from ppaas.planners.watch import proceed


class Machine:
    """Machine that makes the index when the test allows it."""

    def __init__(self, folder: Path, failure: Exception | None = None) -> None:
        self.folder = folder
        self.failure = failure
        self.go = asyncio.Event()
        self.go.set()
        self.requested: list[str] = []

    async def prepare_index(self, planner: str) -> None:
        self.requested.append(planner)
        await self.go.wait()
        if self.failure is not None:
            raise self.failure
        write_index(self.folder, planner, memoryview(b"made"))


async def call(machine, check=proceed):
    indexes = SharedIndexes(machine.folder)
    indexes.ask(machine, asyncio.get_running_loop())
    return await asyncio.to_thread(indexes, "p", check)


async def test_existing_index_is_opened_without_a_request(tmp_path):
    machine = Machine(tmp_path)
    write_index(tmp_path, "p", memoryview(b"there"))
    assert bytes(await call(machine)) == b"there"
    assert machine.requested == []


async def test_missing_index_is_requested_and_awaited(tmp_path):
    machine = Machine(tmp_path)
    machine.go.clear()
    asyncio.get_running_loop().call_later(0.02, machine.go.set)
    assert bytes(await call(machine)) == b"made"
    assert machine.requested == ["p"]


async def test_unavailable_index_is_none(tmp_path):
    assert await call(Machine(tmp_path, Unavailable("full"))) is None


async def test_map_that_the_planner_cannot_prepare_is_reported(tmp_path):
    with pytest.raises(InvalidPlanner, match="cluttered"):
        await call(Machine(tmp_path, InvalidPlanner("too cluttered")))


async def test_cancelled_planner_stops_waiting_for_the_index(tmp_path):
    machine = Machine(tmp_path)
    machine.go.clear()
    calls = iter(range(3))

    def check() -> None:
        if next(calls, None) is None:
            raise PlanCancelled("no time")

    with pytest.raises(PlanCancelled):
        await call(machine, check)


def test_index_is_none_without_a_machine(tmp_path):
    assert SharedIndexes(tmp_path)("p", proceed) is None
