"""The Docker runtime; tests of all runtimes are in ``tests/contracts/test_runtimes.py``."""

import asyncio
import itertools
import json
import signal
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from engine.agent import entries
from engine.processes.instances import instance_name
from engine.runtimes.base import Premises
from engine.runtimes.docker.runtime import DockerRuntime
from engine.runtimes.fork_server.server import UNKNOWN_STATUS
from engine.specs.containers import Launch
from ppaas.errors import Unavailable
from tests.support.engine.docker_engine import TEST_IMAGE, containers, image_for_tests, run
from tests.support.engine.launches import Reports
from tests.support.engine.processes import has_ended
from tests.support.waiting import until

ENTRIES = "tests.support.engine.container_entries"

_numbers = itertools.count(1)


@pytest.fixture
async def reports() -> AsyncIterator[Reports]:
    with tempfile.TemporaryDirectory(prefix="t-") as folder:
        async with Reports(Path(folder)) as served:
            yield served


@pytest.fixture
def premises(reports: Reports) -> Premises:
    folder = Path(reports.path).parent
    return Premises(f"{instance_name()}-d{next(_numbers)}", folder, folder / "shm", TEST_IMAGE, entries.ENTRIES)


@pytest.fixture
async def runtime(premises: Premises) -> AsyncIterator[DockerRuntime]:
    image_for_tests()
    started = DockerRuntime(premises, entries.loaded_before(f"{ENTRIES}:dial_and_stay"), spares=1)
    await started.start()
    yield started
    await started.close()


@pytest.mark.docker
async def test_container_has_no_network_privileges_or_writable_mounts(runtime: DockerRuntime, reports: Reports) -> None:
    container = await runtime.launch(reports.launch(cpus=(0,)))
    [inspected] = json.loads(run("docker", "inspect", container.id))
    host = inspected["HostConfig"]
    assert (host["NetworkMode"], host["ReadonlyRootfs"], host["CapDrop"]) == ("none", True, ["ALL"])
    assert "no-new-privileges" in host["SecurityOpt"]
    assert inspected["Config"]["User"].partition(":")[0] not in ("", "0", "root")
    assert (host["CpuQuota"] / host["CpuPeriod"], host["CpusetCpus"]) == (1.0, "0")
    assert 0 < host["Memory"] == host["MemorySwap"]
    assert [mount["RW"] for mount in inspected["Mounts"]] == [False, False]


def limits(container: str) -> tuple[float, str, int, int]:
    """Return the limits of a container: number of CPUs, CPUs, memory [MiB], and memory with swap [MiB]."""
    host = json.loads(run("docker", "inspect", container))[0]["HostConfig"]
    return host["CpuQuota"] / host["CpuPeriod"], host["CpusetCpus"], host["Memory"] >> 20, host["MemorySwap"] >> 20


def sized(launch: Launch, cores: float, *cpus: int) -> Launch:
    return replace(launch, spec=replace(launch.spec, cores=cores), cpus=cpus)


@pytest.mark.docker
async def test_the_last_of_many_sizes_wins(runtime: DockerRuntime, reports: Reports) -> None:
    launch = reports.launch(cpus=(0,))
    container = await runtime.launch(launch)
    for cores in (1.75, 0.25, 1.5, 0.75, 1.25, 0.5):
        container.resize(sized(launch, cores, 0))
    await until(lambda: limits(container.id) == (0.5, "0", 768, 768), 10.0)
    container.resize(sized(launch, 2.0, 0, 1))
    await until(lambda: limits(container.id) == (2.0, "0,1", 1536, 1536), 10.0)


@pytest.mark.docker
async def test_a_smaller_size_keeps_memory_in_use_and_limits_the_cpus(premises: Premises, reports: Reports) -> None:
    image_for_tests()
    runtime = DockerRuntime(premises, entries.loaded_before(f"{ENTRIES}:hold_memory"), spares=1)
    await runtime.start()
    launch = sized(reports.launch(), 2.0, 0, 1)
    container = await runtime.launch(launch)
    assert (await reports.next()).text == "1100 MiB"
    container.resize(sized(launch, 0.5, 0))
    await until(lambda: limits(container.id) == (0.5, "0", 1536, 1536), 10.0)
    assert not container.has_ended
    await runtime.close()


@pytest.mark.docker
async def test_only_a_container_above_its_memory_limit_is_killed(premises: Premises, reports: Reports) -> None:
    image_for_tests()
    runtime = DockerRuntime(premises, entries.loaded_before(f"{ENTRIES}:take_memory"), spares=1)
    await runtime.start()
    greedy = await runtime.launch(reports.launch(cpus=(0,)))
    assert await greedy.wait() == -signal.SIGKILL
    assert not (await runtime.launch(reports.launch(cpus=(0,)))).has_ended
    await runtime.close()


@pytest.mark.docker
async def test_a_spare_that_died_is_not_handed_out(
    runtime: DockerRuntime, reports: Reports, premises: Premises
) -> None:
    [spare] = containers(premises.instance)
    run("docker", "kill", spare)
    launch = reports.launch()
    assert (await runtime.launch(launch)).id != spare
    assert (await reports.next()).container == launch.spec.id


@pytest.mark.docker
async def test_close_removes_all_containers(runtime: DockerRuntime, reports: Reports, premises: Premises) -> None:
    await runtime.launch(reports.launch())
    await runtime.close()
    assert containers(premises.instance) == []
    assert list((premises.shared_memory).iterdir()) == []


@pytest.mark.docker
async def test_containers_end_with_their_agent_and_the_next_removes_them() -> None:
    image_for_tests()
    instance, pid = await asyncio.to_thread(_killed_agent)
    await until(lambda: has_ended(pid), 10.0)
    assert containers(instance)
    with tempfile.TemporaryDirectory(prefix="t-") as name:
        premises = Premises(f"{instance_name()}-next", Path(name), Path(name, "shm"), TEST_IMAGE, entries.ENTRIES)
        next_one = DockerRuntime(premises, entries.loaded_before(f"{ENTRIES}:dial_and_stay"), spares=0)
        await next_one.start()
        assert containers(instance) == []
        await next_one.close()


def _killed_agent() -> tuple[str, int]:
    """Return the instance name of a killed agent, and the process id of its container."""
    script = [sys.executable, "-m", "tests.support.engine.docker_agent", TEST_IMAGE]
    with subprocess.Popen(script, stdout=subprocess.PIPE, text=True) as agent:
        assert agent.stdout is not None
        instance, pid = agent.stdout.readline().split()
        agent.kill()
    return instance, int(pid)


@pytest.mark.docker
async def test_a_missing_image_is_an_error_with_the_build_command(premises: Premises) -> None:
    image_for_tests()
    runtime = DockerRuntime(premises._replace(image="ppaas-nowhere"))
    with pytest.raises(Unavailable, match=r"no image 'ppaas-nowhere'.*docker build -f docker/engine.Dockerfile"):
        await runtime.start()
    await runtime.close()


async def test_a_missing_engine_is_an_error_with_advice(premises: Premises, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DOCKER_HOST", f"unix://{premises.run_dir}/nowhere.sock")
    runtime = DockerRuntime(premises)
    with pytest.raises(Unavailable, match=r"no Docker Engine answers.*--runtime process"):
        await runtime.start()
    await runtime.close()


async def test_a_missing_extra_is_named() -> None:
    script = "import sys; sys.modules['docker'] = None\nimport engine.runtimes.docker.runtime"
    done = await asyncio.to_thread(subprocess.run, [sys.executable, "-c", script], capture_output=True, text=True)
    assert "pip install '.[docker]'" in done.stderr


@pytest.mark.docker
async def test_runtime_reconnects_after_losing_the_engine(
    runtime: DockerRuntime, reports: Reports, premises: Premises
) -> None:
    container = await runtime.launch(reports.launch())
    assert (await reports.next()).pid
    runtime._engine._events.close()
    assert await container.wait() == UNKNOWN_STATUS
    launch = reports.launch()
    again = await runtime.launch(launch)
    assert (await reports.next()).container == launch.spec.id
    again.kill()
    assert await again.wait() == -signal.SIGKILL
    await until(lambda: container.id not in containers(premises.instance), 10.0)


def test_numpy_is_left_to_the_preload_which_sets_its_threads() -> None:
    code = "import sys, engine.runtimes.docker.entry; print({'numpy', 'asyncio', 'uvloop'} & sys.modules.keys())"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout.strip() == "set()"
