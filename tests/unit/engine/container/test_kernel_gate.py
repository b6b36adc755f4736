"""A container waits for kernels that its machine compiles."""

import asyncio
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import msgspec
import numba
import pytest

from engine.agent.container_gateway import ContainerGateway
from engine.agent.kernel_service import KernelService
from engine.container import kernel_gate
from engine.container.kernel_gate import KernelGate, KernelsMissing, await_kernels
from engine.runtimes.compilation.compile_pool import CompileReport
from engine.runtimes.compilation.kernel_compiler import KernelCompiler
from engine.specs.containers import Launch
from ppaas.errors import Starting, Unavailable
from storage.memory.store import MemoryStore
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.specs import planning_spec
from tests.support.waiting import until


def module(name: str, *, warm: bool = True) -> ModuleType:
    made = ModuleType(name)
    if warm:
        vars(made)["warm"] = lambda: None
    return made


class Machine:
    """Machine that compiles modules when the test allows it; it imports modules for the container, too."""

    def __init__(self) -> None:
        self.loaded = [module("forked")]
        self.asked: list[tuple[list[str], float | None]] = []
        self.compiled = asyncio.Event()
        self.refusal: Starting | None = None

    async def ask(self, modules: list[str], within: float | None) -> None:
        self.asked.append((modules, within))
        await self.compiled.wait()
        if self.refusal is not None:
            raise self.refusal


@pytest.fixture
def machine() -> Machine:
    return Machine()


def gate_of(machine: Machine, *, compiled: bool = False) -> KernelGate:
    return KernelGate(None if compiled else machine.ask, patience=8.0, loaded=lambda: machine.loaded)


@pytest.fixture(autouse=True)
def imports(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make each look at the modules count, as after an import."""
    monkeypatch.setattr(kernel_gate, "sys", SimpleNamespace(modules=_Growing()))


class _Growing:
    def __init__(self) -> None:
        self._count = 0

    def __len__(self) -> int:
        self._count += 1
        return self._count


def test_modules_of_the_fork_server_are_compiled(machine: Machine) -> None:
    assert gate_of(machine).missing() == []


def test_modules_imported_since_are_missing_if_they_have_kernels(machine: Machine) -> None:
    gate = gate_of(machine)
    machine.loaded += [module("lattice"), module("helper", warm=False)]
    assert gate.missing() == ["lattice"]


def test_nothing_is_missing_once_all_kernels_are_compiled(machine: Machine) -> None:
    gate = gate_of(machine, compiled=True)
    machine.loaded.append(module("lattice"))
    assert gate.missing() == []


async def test_a_job_waits_for_its_modules_once(machine: Machine) -> None:
    gate = gate_of(machine)
    machine.loaded.append(module("lattice"))
    machine.compiled.set()
    await gate.for_job()
    assert (machine.asked, gate.missing()) == ([(["lattice"], 8.0)], [])
    machine.loaded.append(module("mppi"))
    assert gate.missing() == ["mppi"]


async def test_a_job_that_waits_too_long_is_refused_and_its_modules_stay_missing(machine: Machine) -> None:
    gate = gate_of(machine)
    machine.loaded.append(module("lattice"))
    machine.refusal = Starting("0 of 1")
    machine.compiled.set()
    with pytest.raises(Starting, match="0 of 1"):
        await gate.for_job()
    assert gate.missing() == ["lattice"]


async def test_jobs_behind_one_that_waited_in_vain_are_refused_soon(machine: Machine) -> None:
    """Each of them has already waited behind it."""
    gate = gate_of(machine)
    machine.loaded.append(module("lattice"))
    machine.compiled.set()
    machine.refusal = Starting("3 of 9 kernels")
    for _ in range(2):
        with pytest.raises(Starting, match="3 of 9"):
            await gate.for_job()
    machine.refusal = None
    await gate.for_job()
    machine.loaded.append(module("hub_labels"))
    await gate.for_job()
    assert [within for _, within in machine.asked] == [8.0, kernel_gate.AGAIN, kernel_gate.AGAIN, 8.0]


async def test_a_start_waits_without_a_limit_and_is_reported_meanwhile(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernel_gate, "PERIOD", 0.01)
    gate, reports = gate_of(machine), list[None]()
    machine.loaded.append(module("mppi"))
    starting = asyncio.create_task(gate.for_start(lambda: reports.append(None)))
    await until(lambda: len(reports) > 3)
    assert machine.asked == [(["mppi"], None)]
    machine.compiled.set()
    await asyncio.wait_for(starting, 10)
    assert gate.missing() == []


async def test_a_start_that_misses_nothing_reports_nothing(machine: Machine) -> None:
    reports = list[None]()
    await gate_of(machine).for_start(lambda: reports.append(None))
    assert (reports, machine.asked) == ([], [])


def kernel_of(name: str) -> Any:
    """Return a kernel of a module of that name."""

    def one() -> int:
        return 1

    one.__module__ = name
    return numba.njit(one)


def test_work_that_calls_a_missing_kernel_is_broken_off_and_another_kernel_is_compiled(machine: Machine) -> None:
    gate = gate_of(machine)
    machine.loaded.append(module("lattice"))
    with gate.only_compiled():
        assert kernel_of("plug_in")() == 1
        with pytest.raises(KernelsMissing):
            kernel_of("lattice")()
    assert kernel_of("lattice")() == 1  # outside of that work


async def test_a_machine_is_asked_over_a_connection_of_its_own(tmp_path: Path) -> None:
    launch = Launch(planning_spec(), "", "", str(tmp_path / "gate.sock"), "secret", (), 1)
    compiler = KernelCompiler()
    compiler.report = CompileReport(("a.kernels.b", "a.kernels.c"), ("a.kernels.b",))
    gateway = ContainerGateway(Path(launch.machine), MemoryStore(), FakeFabric(), kernels=KernelService(compiler))
    await gateway.start()
    gateway.expect(launch.spec, "secret")
    await await_kernels(launch, ["a.kernels.b"], None)
    with pytest.raises(Starting, match="0 of 1"):
        await await_kernels(launch, ["a.kernels.c"], 0.0)
    with pytest.raises(Unavailable):
        await await_kernels(msgspec.structs.replace(launch, secret="wrong"), ["a.kernels.b"], None)
    assert gateway.awaited == 1  # it may attach still
    await gateway.close()
