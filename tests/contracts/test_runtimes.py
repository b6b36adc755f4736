"""The contract of every runtime; what only one runtime does has its own test file."""

import asyncio
import itertools
import os
import signal
import tempfile
from collections.abc import AsyncIterator, Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from engine.agent import entries
from engine.processes.instances import instance_name
from engine.runtimes.base import Premises, Runtime
from engine.runtimes.fork_server.server import UNKNOWN_STATUS
from engine.runtimes.process.runtime import ProcessRuntime
from engine.specs.containers import Launch
from ppaas.errors import PPaaSError, Unavailable
from tests.ray.ray_cluster import RayCluster
from tests.support.engine.docker_engine import image_for_tests
from tests.support.engine.launches import Reports
from tests.support.engine.processes import is_gone
from tests.support.sources import ROOT
from tests.support.waiting import until

ENTRIES = "tests.support.engine.container_entries"

_numbers = itertools.count(1)


@dataclass
class Machine:
    """The premises of a runtime whose containers report to the test."""

    make: Callable[[str, Premises], Runtime]
    premises: Premises
    reports: Reports
    runtime: Runtime | None = None
    status_at_close: int = -signal.SIGKILL
    """Exit status of a container that the end of its runtime ends."""

    async def start(self, entry: str) -> Runtime:
        """Start the runtime, whose containers run a function of the entries of tests."""
        self.runtime = self.make(f"{ENTRIES}:{entry}", self.premises)
        await self.runtime.start()
        return self.runtime

    def layers(self) -> Path:
        """Create map layers that contain only a mark."""
        folder = self.premises.shared_memory / "map"
        folder.mkdir(parents=True)
        (folder / "info.json").write_text("the layers")
        return folder

    async def launch_with_layers(self, runtime: Runtime) -> tuple[Any, Path]:
        """Start a container that sees layers of a map; return it, and the folder that these are in."""
        layers = self.layers()
        return await runtime.launch(self.reports.launch(layers=str(layers))), layers


class RayMachine(Machine):
    """A node of a real cluster, whose agent makes the layers of a real map."""

    async def launch_with_layers(self, runtime: Any) -> tuple[Any, Path]:
        container = await runtime.launch(self.reports.launch())
        return container, runtime.layers()


Make = Callable[[pytest.FixtureRequest, Premises, Reports], Machine]


def by_processes(_: pytest.FixtureRequest, premises: Premises, reports: Reports) -> Machine:
    return Machine(lambda entry, _: ProcessRuntime(entries.loaded_before(entry)), premises, reports)


def by_docker(_: pytest.FixtureRequest, premises: Premises, reports: Reports) -> Machine:
    from engine.runtimes.docker.runtime import DockerRuntime

    image = premises._replace(image=image_for_tests())
    return Machine(
        lambda entry, premises: DockerRuntime(premises, entries.loaded_before(entry), spares=1), image, reports
    )


def by_ray(request: pytest.FixtureRequest, premises: Premises, reports: Reports) -> Machine:
    from tests.ray.ray_runtime import RayRuntime

    cluster = request.getfixturevalue("ray_cluster")
    made = RayMachine(lambda entry, premises: RayRuntime(entry, premises, cluster, reports), premises, reports)
    made.status_at_close = UNKNOWN_STATUS  # the agent ends before them, so their status is unknown
    return made


PROCESS, DOCKER, RAY = (
    by_processes,
    pytest.param(by_docker, marks=pytest.mark.docker),
    pytest.param(by_ray, marks=[pytest.mark.ray, pytest.mark.timeout(600)]),
)


@pytest.fixture(scope="module")
def ray_cluster() -> Iterator[RayCluster]:
    """Return a cluster with one node, on which the agents of these tests run one after the other."""
    from tests.ray.ray_runtime import PLUGIN

    with pytest.MonkeyPatch.context() as patch:
        running = RayCluster(PYTHONPATH=f"{ROOT}:{PLUGIN}")
        for name, value in running.credentials.items():
            patch.setenv(name, value)
        try:
            running.join()
            yield running
        finally:
            running.stop()


@pytest.fixture(params=[PROCESS, DOCKER, RAY])
async def machine(request: pytest.FixtureRequest) -> AsyncIterator[Machine]:
    make: Make = request.param
    instance = f"{instance_name()}-{next(_numbers)}"
    with tempfile.TemporaryDirectory(prefix="t-") as name:  # a path that is short enough for sockets
        folder = Path(name)
        async with Reports(folder) as reports:
            started = make(request, Premises(instance, folder, folder / "shm", entries=entries.ENTRIES), reports)
            yield started
            if started.runtime is not None:
                await started.runtime.close()


def sized(launch: Launch, cores: float, *cpus: int) -> Launch:
    """Return a launch of another size, on other CPUs."""
    return replace(launch, spec=replace(launch.spec, cores=cores), cpus=cpus)


async def test_a_container_connects_when_ready_and_runs_until_killed(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    launch = machine.reports.launch()
    container = await runtime.launch(launch)
    assert (await machine.reports.next()).container == launch.spec.id
    assert not is_gone(container.pid)
    container.kill()
    assert await container.wait() == -signal.SIGKILL
    await until(lambda: is_gone(container.pid))
    container.kill()


async def test_size_sets_cpus_and_threads_and_the_exit_status_is_returned(machine: Machine) -> None:
    runtime = await machine.start("describe")
    container = await runtime.launch(machine.reports.launch(cpus=(0,), threads=1))
    facts = dict(fact.split("=") for fact in (await machine.reports.next()).text.split())
    assert (facts["cpus"], facts["threads"], facts["omp"], facts["main"]) == ("0", "1", "1", "False")
    assert facts["told_ray_token"] == "False", "the token of the cluster must not reach a container"
    assert await container.wait() == 7


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one CPU: no other to run on")
async def test_resize_changes_the_cpus_of_a_running_container(machine: Machine) -> None:
    runtime = await machine.start("tell_cpus")
    launch = machine.reports.launch(cpus=(0,))
    container = await runtime.launch(launch)
    assert (await machine.reports.next()).text == "0"
    container.resize(sized(launch, 2.0, 0, 1))
    assert (await machine.reports.next()).text == "0,1"
    container.resize(sized(launch, 0.5, 0))
    assert (await machine.reports.next()).text == "0"
    container.kill()
    assert await container.wait() == -signal.SIGKILL
    container.resize(launch)


async def test_a_kill_by_another_process_is_reported(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    container = await runtime.launch(machine.reports.launch())
    await machine.reports.next()
    os.kill(container.pid, signal.SIGKILL)
    assert await container.wait() == -signal.SIGKILL


async def test_several_callers_wait_for_the_end(machine: Machine) -> None:
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


async def test_layers_and_files_added_later_are_visible(machine: Machine) -> None:
    runtime = await machine.start("read_layers")
    container, layers = await machine.launch_with_layers(runtime)
    assert (await machine.reports.next()).text == (layers / "info.json").read_text()
    (layers / "late.index").write_text("an index")
    container.layers_grew()
    assert (await machine.reports.next()).text == "an index"
    assert await container.wait() == 0


async def test_a_launch_of_an_impossible_size_fails(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    try:
        status = await (await runtime.launch(sized(machine.reports.launch(), 4096.0, 4095))).wait()
    except PPaaSError:
        return
    assert status == 1


async def test_close_ends_all_containers_and_refuses_new_ones(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    started = await asyncio.gather(*(runtime.launch(machine.reports.launch()) for _ in range(3)))
    reported = {(await machine.reports.next()).container for _ in started}
    assert len(reported) == 3
    await runtime.close()
    await until(lambda: all(is_gone(container.pid) for container in started))
    assert [await container.wait() for container in started] == [machine.status_at_close] * 3
    assert [entry.name for entry in machine.premises.run_dir.iterdir() if entry.name.startswith("c-")] == []
    with pytest.raises(Unavailable, match=r"closed|not connected"):
        await runtime.launch(machine.reports.launch())


async def test_a_cancelled_launch_leaves_no_container(machine: Machine) -> None:
    runtime = await machine.start("dial_and_stay")
    given_up = machine.reports.launch()
    launching = asyncio.create_task(runtime.launch(given_up))
    await asyncio.sleep(0)
    launching.cancel()
    with pytest.raises(asyncio.CancelledError):
        await launching
    launch = machine.reports.launch()
    await runtime.launch(launch)
    report = await machine.reports.next()
    if report.container == given_up.spec.id:  # it had come up before it was killed
        await until(lambda: given_up.spec.id in machine.reports.hung_up)
        report = await machine.reports.next()
    assert report.container == launch.spec.id


# On a Ray node the agent receives the error and logs it.
@pytest.mark.parametrize("machine", [PROCESS, DOCKER], indirect=True)
async def test_a_missing_entry_point_is_reported_at_the_start(machine: Machine) -> None:
    with pytest.raises(Unavailable, match="nothing"):
        await machine.start("nothing")
