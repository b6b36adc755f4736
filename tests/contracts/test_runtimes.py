"""What holds for every runtime; each has a test file of its own for what it alone does."""

import asyncio
import itertools
import signal
import tempfile
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from engine.instances import instance_name
from engine.runtimes.base import Premises, Runtime
from engine.runtimes.process import ProcessRuntime
from ppaas.errors import Unavailable
from tests.support.docker_engine import image_for_tests
from tests.support.launches import Reports
from tests.support.processes import is_gone, until

ENTRIES = "tests.support.container_entries"

_numbers = itertools.count(1)


def process_runtime(entry: str, premises: Premises) -> Runtime:
    return ProcessRuntime(entry)


def docker_runtime(entry: str, premises: Premises) -> Runtime:
    from engine.runtimes.docker import DockerRuntime

    return DockerRuntime(premises._replace(image=image_for_tests()), entry, spares=1)


@dataclass
class Machine:
    """Where a runtime runs, whose containers report to the test."""

    make: Callable[[str, Premises], Runtime]
    premises: Premises
    reports: Reports
    runtime: Runtime | None = None

    async def start(self, entry: str) -> Runtime:
        """Start the runtime, whose containers run a function of the entries of tests."""
        self.runtime = self.make(f"{ENTRIES}:{entry}", self.premises)
        await self.runtime.start()
        return self.runtime

    def layers(self) -> Path:
        """Make layers of a map that only say which they are."""
        folder = self.premises.shared_memory / "map"
        folder.mkdir(parents=True)
        (folder / "info.json").write_text("the layers")
        return folder


@pytest.fixture(params=[process_runtime, pytest.param(docker_runtime, marks=pytest.mark.docker)])
async def machine(request: pytest.FixtureRequest) -> AsyncIterator[Machine]:
    instance = f"{instance_name()}-{next(_numbers)}"
    with tempfile.TemporaryDirectory(prefix="t-") as name:  # a path that is short enough for sockets
        folder = Path(name)
        async with Reports(folder) as reports:
            started = Machine(request.param, Premises(instance, folder, folder / "shm"), reports)
            yield started
            if started.runtime is not None:
                await started.runtime.close()


async def test_a_container_is_ready_when_it_dials_and_runs_until_it_is_killed(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    launch = machine.reports.launch()
    container = await runtime.launch(launch)
    assert (await machine.reports.next()).container == launch.spec.id
    assert not is_gone(container.pid)
    container.kill()
    assert await container.wait() == -signal.SIGKILL
    await until(lambda: is_gone(container.pid))
    container.kill()


async def test_its_size_is_cpus_and_threads_and_its_exit_status_is_told(machine: Machine) -> None:
    runtime = await machine.start("describe")
    container = await runtime.launch(machine.reports.launch(cpus=(0,), threads=1))
    facts = dict(fact.split("=") for fact in (await machine.reports.next()).text.split())
    assert (facts["cpus"], facts["threads"], facts["omp"], facts["main"]) == ("0", "1", "1", "False")
    assert await container.wait() == 7


async def test_many_may_wait_for_the_end(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    container = await runtime.launch(machine.reports.launch())
    waiting = [asyncio.create_task(container.wait()) for _ in range(3)]
    await asyncio.sleep(0)
    waiting[0].cancel()
    container.kill()
    assert await waiting[1] == await waiting[2] == await container.wait() == -signal.SIGKILL


async def test_a_container_of_one_core_cannot_use_two(machine: Machine) -> None:
    runtime = await machine.start("burn")
    await runtime.launch(machine.reports.launch(cpus=(0,)))
    assert float((await machine.reports.next()).text) < 1.3


async def test_layers_are_seen_and_so_is_what_is_put_beside_them_later(machine: Machine) -> None:
    layers = machine.layers()
    runtime = await machine.start("read_layers")
    container = await runtime.launch(machine.reports.launch(layers=str(layers)))
    assert (await machine.reports.next()).text == "the layers"
    (layers / "late.index").write_text("an index")
    container.layers_grew()
    assert (await machine.reports.next()).text == "an index"
    assert await container.wait() == 0


async def test_what_cannot_begin_is_told(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    try:
        status = await (await runtime.launch(machine.reports.launch(cpus=(4095,)))).wait()
    except Unavailable:
        return
    assert status == 1


async def test_several_at_a_time_are_all_ended_by_close_and_no_more_start(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    started = await asyncio.gather(*(runtime.launch(machine.reports.launch()) for _ in range(3)))
    reported = {(await machine.reports.next()).container for _ in started}
    assert len(reported) == 3
    await runtime.close()
    await until(lambda: all(is_gone(container.pid) for container in started))
    assert [await container.wait() for container in started] == [-signal.SIGKILL] * 3
    assert [entry.name for entry in machine.premises.run_dir.iterdir() if entry.name.startswith("c-")] == []
    with pytest.raises(Unavailable, match="closed"):
        await runtime.launch(machine.reports.launch())


async def test_a_launch_that_is_given_up_leaves_no_container(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    launching = asyncio.create_task(runtime.launch(machine.reports.launch()))
    await asyncio.sleep(0)
    launching.cancel()
    with pytest.raises(asyncio.CancelledError):
        await launching
    launch = machine.reports.launch()
    await runtime.launch(launch)
    assert (await machine.reports.next()).container == launch.spec.id


async def test_an_entry_that_does_not_exist_is_told_at_the_start(machine: Machine) -> None:
    with pytest.raises(Unavailable, match="nothing"):
        await machine.start("nothing")
