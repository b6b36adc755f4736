"""Machines ping each other over a real router."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from engine.agent.host_load import RoundTripProbe
from engine.fabric.router import RouterProcess
from engine.fabric.session import Fabric
from tests.support.waiting import until


@pytest.fixture
async def router(tmp_path: Path) -> AsyncIterator[RouterProcess]:
    process = RouterProcess(tmp_path)
    await process.start()
    yield process
    await process.close()


async def test_machines_discover_each_other_and_forget_closed_ones(router: RouterProcess) -> None:
    fabrics = [await Fabric.open(router.endpoint, router.credentials) for _ in range(3)]
    machines = [RoundTripProbe(fabric, f"m{number}") for number, fabric in enumerate(fabrics)]
    for machine in machines:
        await machine.start()
    await until(lambda: all(len(machine._there) == 2 for machine in machines))
    for machine in machines:
        await machine.ping_some()
    assert [sorted(machine.round_trips) for machine in machines] == [["m1", "m2"], ["m0", "m2"], ["m0", "m1"]]
    assert all(seconds > 0.0 for machine in machines for seconds in machine.round_trips.values())
    await machines[2].close()
    await fabrics[2].close()
    await until(lambda: sorted(machines[0].round_trips) == ["m1"])
    for machine, fabric in zip(machines[:2], fabrics[:2], strict=True):
        await machine.close()
        await fabric.close()


async def test_silent_machine_has_no_round_trip(router: RouterProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.agent.host_load.TIMEOUT", 0.3)
    one, other = [await Fabric.open(router.endpoint, router.credentials) for _ in range(2)]
    asking, silent = RoundTripProbe(one, "m1"), RoundTripProbe(other, "m2")
    await asking.start()
    await silent.start()
    await until(lambda: bool(asking._there))
    await asking.ping_some()
    assert list(asking.round_trips) == ["m2"]
    silent._declared[0].close()
    await until(lambda: not other._replying)

    async def is_forgotten() -> bool:
        await asking.ping_some()
        return asking.round_trips == {}

    while not await is_forgotten():
        pass
    for machine, fabric in ((asking, one), (silent, other)):
        await machine.close()
        await fabric.close()
