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

COUNT, ROBOTS = 4, 12


@asynccontextmanager
async def carried(places: Placement, machines: Machines) -> AsyncIterator[None]:
    """Have machines, and a container ordered for each robot."""
    await places.start()
    carrying = [asyncio.create_task(machines.be(f"m{number}")) for number in range(COUNT)]
    try:
        async with asyncio.timeout(10.0):
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


async def test_each_robot_has_a_container_and_what_is_said_of_machines_is_kept_for_the_next(short_path: Path) -> None:
    places, machines = MasterPlacement(short_path, "ppaas"), Machines(short_path, keep_every=3)
    async with carried(places, machines):
        assert len(machines.ordered) == machines.orders == ROBOTS
        assert sum(ordered.kept for ordered in machines.ordered.values()) == ROBOTS // 3
        places.configure(2)
        said = places.state()
    assert (list(said["settings"]), said["removed"]) == (["m0"], ["m1"])
    assert MasterPlacement(short_path, "ppaas").state() == said


async def test_without_a_master_each_machine_is_ordered_in_its_turn(short_path: Path) -> None:
    machines = Machines(short_path, keep_every=0)
    async with carried(RoundRobinPlacement(short_path), machines):
        on = [ordered.machine for ordered in machines.ordered.values()]
    assert sorted(on) == sorted([f"m{number}" for number in range(COUNT)] * (ROBOTS // COUNT))


def test_a_balancer_that_there_is_not_is_refused(short_path: Path) -> None:
    with pytest.raises(NotFound, match="first_fit"):
        MasterPlacement(short_path, "fairest")
