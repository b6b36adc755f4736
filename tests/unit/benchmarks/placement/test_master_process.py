"""Master and simulated machines of the engine bench, here in one process."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from benchmarks.placement.arrivals import generated
from benchmarks.placement.machines_process import Machines
from benchmarks.placement.master_process import MasterPlacement, Placement, RoundRobinPlacement
from ppaas.errors import NotFound
from tests.support.waiting import patience

COUNT, ROBOTS = 4, 12


@asynccontextmanager
async def running(places: Placement, machines: Machines) -> AsyncIterator[None]:
    """Start the machines, and order a container for each robot."""
    await places.start()
    carrying = [asyncio.create_task(machines.be(f"m{number}")) for number in range(COUNT)]
    try:
        async with patience(10.0):
            while places.machines < COUNT:
                await asyncio.sleep(0.01)
            for arrival in generated(ROBOTS, 3, seed=1):
                places.open(arrival)
            while places.launched < ROBOTS:
                await asyncio.sleep(0.01)
        yield
    finally:
        for task in carrying:
            task.cancel()
        await asyncio.gather(*carrying, return_exceptions=True)


async def test_robots_have_containers_and_machine_settings_survive(short_path: Path) -> None:
    places, machines = MasterPlacement(short_path, "ppaas"), Machines(short_path, keep_every=3)
    async with running(places, machines):
        assert len(machines.ordered) == machines.orders == ROBOTS
        assert sum(ordered.kept for ordered in machines.ordered.values()) == ROBOTS // 3
        await places.configure(2)
        state = places.state()
    assert (list(state["settings"]), state["removed"]) == (["m0"], ["m1"])
    assert MasterPlacement(short_path, "ppaas").state() == state


async def test_containers_are_ordered_in_turn_without_a_master(short_path: Path) -> None:
    machines = Machines(short_path, keep_every=0)
    async with running(RoundRobinPlacement(short_path), machines):
        on = [ordered.machine for ordered in machines.ordered.values()]
    assert sorted(on) == sorted([f"m{number}" for number in range(COUNT)] * (ROBOTS // COUNT))


def test_an_unknown_balancer_is_refused(short_path: Path) -> None:
    with pytest.raises(NotFound, match="first_fit"):
        MasterPlacement(short_path, "fairest")
