"""Control groups of container processes; some tests need a kernel that lets us create groups."""

import itertools
import signal
import tempfile
import threading
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from engine.agent.entries import loaded_before
from engine.processes.instances import instance_name
from engine.runtimes.process.control_groups import V2, ControlGroups, Hierarchy, hierarchies, own_hierarchies
from engine.runtimes.process.runtime import ProcessRuntime
from engine.specs.containers import Launch
from tests.support.engine.launches import Reports
from tests.support.engine.processes import is_gone
from tests.support.waiting import until

MIB = 1 << 20

V1_MOUNTS = """\
tmpfs /sys/fs/cgroup tmpfs rw,relatime,mode=755 0 0
cgroup /sys/fs/cgroup/cpu,cpuacct cgroup rw,relatime,cpu,cpuacct 0 0
cgroup /sys/fs/cgroup/memory cgroup rw,relatime,memory 0 0
cgroup /sys/fs/cgroup/systemd cgroup rw,relatime,name=systemd 0 0
"""

V1_OWN = """\
4:memory:/ours
3:cpu,cpuacct:/
1:name=systemd:/ours
0::/
"""

_numbers = itertools.count(1)


def sized(launch: Launch, cores: float) -> Launch:
    return replace(launch, spec=replace(launch.spec, cores=cores))


@pytest.fixture
def launch(tmp_path: Path) -> Launch:
    return Reports(tmp_path).launch()


@pytest.fixture
def instance() -> str:
    return f"{instance_name()}-g{next(_numbers)}"


def entries(folder: Path) -> list[str]:
    return [entry.name for entry in folder.iterdir()]


def test_version_1_has_a_hierarchy_for_each_controller() -> None:
    found = {tuple(place.settings): str(place.parent) for place in hierarchies(V1_MOUNTS, V1_OWN)}
    assert found == {
        ("cpu.shares",): "/sys/fs/cgroup/cpu,cpuacct",
        ("memory.limit_in_bytes",): "/sys/fs/cgroup/memory/ours",
    }


def test_version_2_groups_need_both_controllers_and_a_parent(tmp_path: Path) -> None:
    mounts, own = f"cgroup2 {tmp_path} cgroup2 rw 0 0\n", "0::/ppaas.service/main\n"
    (tmp_path / "ppaas.service" / "main").mkdir(parents=True)
    controllers = tmp_path / "ppaas.service" / "cgroup.controllers"
    controllers.write_text("pids\n")
    assert hierarchies(mounts, own) == []
    controllers.write_text("cpu io memory pids\n")
    [place] = hierarchies(mounts, own)
    assert (place.parent, place.settings) == (tmp_path / "ppaas.service", V2)
    assert {str(file.relative_to(tmp_path)): text for file, text in place.first.items()} == {
        "ppaas.service/cgroup.subtree_control": "+cpu +memory", "ppaas.service/main/cpu.weight": "10000",
    }  # fmt: skip
    assert hierarchies(mounts, "0::/\n") == [], "this process is in the root group, which has no siblings"


def test_size_sets_weight_and_memory(tmp_path: Path, instance: str, launch: Launch) -> None:
    groups = ControlGroups(instance, [Hierarchy(tmp_path, V2, {tmp_path / "first": "done"})])
    group = tmp_path / f"ppaas-{instance}.{launch.spec.id}"
    assert entries(tmp_path) == ["first"]
    groups.put(77, sized(launch, 0.25)).result()
    assert [(group / file).read_text() for file in ("cpu.weight", "memory.max", "cgroup.procs")] == [
        "100", str(640 * MIB), "77",
    ]  # fmt: skip
    groups.resize(sized(launch, 2.0)).result()
    assert [(group / file).read_text() for file in V2] == ["800", str(1536 * MIB)]


async def test_without_groups_containers_have_no_limits(tmp_path: Path, instance: str, launch: Launch) -> None:
    groups = ControlGroups(instance, [Hierarchy(tmp_path / "nowhere", V2)])
    assert groups.controlled == []
    for done in (groups.put(77, launch), groups.resize(launch), groups.remove(launch.spec.id)):
        done.result()
    await groups.close()
    assert entries(tmp_path) == []


def test_groups_of_dead_processes_are_removed(tmp_path: Path, instance: str) -> None:
    namespace, pid, _ = instance_name().split("-")
    living = f"ppaas-{instance_name()}.c1"
    for left in (f"ppaas-{namespace}-{pid}-1.c1", f"ppaas-{instance}.c1", living):
        (tmp_path / left).mkdir()
    ControlGroups(instance, [Hierarchy(tmp_path, {})])
    assert entries(tmp_path) == [living]


def test_a_group_with_an_exiting_process_is_removed_a_moment_later(tmp_path: Path, instance: str) -> None:
    ending = tmp_path / f"ppaas-{instance}.c1" / "ending"
    ending.mkdir(parents=True)
    end = threading.Timer(0.05, ending.rmdir)
    end.start()
    ControlGroups(instance, [Hierarchy(tmp_path, {})])
    end.join()
    assert entries(tmp_path) == []


def test_a_group_that_stays_busy_is_logged(tmp_path: Path, instance: str, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / f"ppaas-{instance}.c1" / "busy").mkdir(parents=True)
    ControlGroups(instance, [Hierarchy(tmp_path, {})])
    assert f"ppaas-{instance}.c1 cannot be removed" in caplog.text


# -- over a real kernel ------------------------------------------------------------------------------------------------


class Controlled:
    """A runtime whose containers are in control groups."""

    def __init__(self, instance: str, reports: Reports, groups: ControlGroups) -> None:
        self.instance, self.reports, self.groups = instance, reports, groups
        self.places = [place for place in own_hierarchies() if set(place.settings) <= set(groups.controlled)]
        self.runtime: ProcessRuntime | None = None

    async def start(self, entry: str) -> ProcessRuntime:
        self.runtime = ProcessRuntime(loaded_before(f"tests.support.engine.container_entries:{entry}"), self.groups)
        await self.runtime.start()
        return self.runtime

    def files(self, container: str) -> dict[str, int]:
        """Return the content of the files of a container's groups."""
        return {
            file: int((place.parent / f"ppaas-{self.instance}.{container}" / file).read_text())
            for place in self.places
            for file in place.settings
        }

    def left(self) -> list[Path]:
        """Return the existing groups of the runtime."""
        return [group for place in self.places for group in place.parent.glob(f"ppaas-{self.instance}.*")]


@pytest.fixture
async def groups(instance: str) -> AsyncIterator[ControlGroups]:
    made = ControlGroups(instance, own_hierarchies())
    if len(made.controlled) < 2:
        await made.close()
        pytest.skip("no control groups of CPU and memory can be made here")
    yield made
    await made.close()


@pytest.fixture
async def controlled(instance: str, groups: ControlGroups) -> AsyncIterator[Controlled]:
    with tempfile.TemporaryDirectory(prefix="t-") as folder:
        async with Reports(Path(folder)) as reports:
            made = Controlled(instance, reports, groups)
            yield made
            if made.runtime is not None:
                await made.runtime.close()
            assert made.left() == []


def groups_of(pid: int) -> str:
    return Path(f"/proc/{pid}/cgroup").read_text()


async def test_groups_follow_the_size_and_end_with_the_container(controlled: Controlled) -> None:
    runtime = await controlled.start("dial_and_stay")
    launch = controlled.reports.launch(cpus=(0,))
    container = await runtime.launch(launch)
    await until(lambda: groups_of(container.pid).count(f".{launch.spec.id}") == len(controlled.places))
    assert len(controlled.left()) == len(controlled.places)
    small = controlled.files(launch.spec.id)
    container.resize(sized(launch, 2.0))
    await until(lambda: all(small[file] < now for file, now in controlled.files(launch.spec.id).items()))
    container.kill()
    assert await container.wait() == -signal.SIGKILL
    await until(lambda: not controlled.left())


async def test_only_a_container_above_its_memory_limit_is_killed(controlled: Controlled) -> None:
    runtime = await controlled.start("take_memory_if_told")
    modest = await runtime.launch(controlled.reports.launch())
    greedy = await runtime.launch(controlled.reports.launch(secret="take"))
    assert await greedy.wait() == -signal.SIGKILL
    assert not is_gone(modest.pid)


async def test_a_larger_container_gets_more_of_a_shared_cpu(controlled: Controlled) -> None:
    runtime = await controlled.start("compete")
    small = sized(controlled.reports.launch(cpus=(0,)), 0.25)
    large = sized(controlled.reports.launch(cpus=(0,)), 1.0)
    for launch in (small, large):
        await runtime.launch(launch)
    used = {report.container: float(report.text) for report in [await controlled.reports.next() for _ in range(2)]}
    assert used[large.spec.id] > 2.0 * used[small.spec.id]
