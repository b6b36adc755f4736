"""Container supervisor, with a runtime and a layer builder that the test controls."""

import asyncio
import os
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from engine.agent import container_supervisor, map_cache
from engine.agent.container_gateway import ContainerGateway
from engine.agent.container_supervisor import ContainerSupervisor, FollowedMap
from engine.agent.map_cache import MapCache
from engine.protocols import control_link, machine_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal
from engine.specs.containers import ContainerSpec, LayerSpec, MapVersion
from ppaas.errors import InvalidMap, NotFound, Unavailable
from ppaas.maps.cell_rectangle import Rectangle
from ppaas.robot_model.describe import describe
from ppaas.robot_model.known_models import robot_model
from storage.memory.store import MemoryStore
from tests.support.engine.engine_links import dial_gateway, receive
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.fake_runtime import FakeRuntime
from tests.support.engine.specs import coordinator_spec, mapping_spec, planning_spec, robot_config, robot_spec
from tests.support.storage import records
from tests.support.waiting import patience, until
from tests.support.world.urdf import example

HOUSE = MapVersion("house", records.house().version)


class FakeBuilder:
    """Layer builder that waits for the test, and fails on request."""

    def __init__(self) -> None:
        self.specs: list[LayerSpec] = []
        self.error: Exception | None = None
        self.go = asyncio.Event()
        self.go.set()

    @property
    def radii(self) -> list[float]:
        return [spec.robot_radius for spec in self.specs]

    async def __call__(self, spec: LayerSpec, folder: Path) -> None:
        self.specs.append(spec)
        await self.go.wait()
        if self.error is not None:
            raise self.error
        (folder / "layers").write_text(spec.map.version)


class Host:
    """Supervisor of a machine with four CPUs."""

    def __init__(self, folder: Path) -> None:
        self.runtime = FakeRuntime()
        self.building = FakeBuilder()
        self.gateway = ContainerGateway(folder / "gate.sock", MemoryStore(), FakeFabric())
        self.cache = MapCache(folder / "maps", build=self.building, spare=0)
        self.news: list[msgspec.Struct] = []
        self.hosting = ContainerSupervisor(
            runtime=self.runtime,
            gateway=self.gateway,
            cache=self.cache,
            cpus=(0, 1, 2, 3),
            tell=self.news.append,
        )

    def start(self, spec: ContainerSpec) -> None:
        self.hosting.start(control_link.StartContainer(spec, "secret", "link.sock"))

    async def reported(self, event: msgspec.Struct) -> None:
        await until(lambda: event in self.news)

    def assert_forgotten(self) -> None:
        """Assert that no container and no used layers are left."""
        assert self.hosting._hosted == {}
        assert self.gateway.awaited == 0
        assert dict(self.cache._users) == {}


@pytest.fixture
async def host(tmp_path: Path) -> AsyncIterator[Host]:
    made = Host(tmp_path)
    yield made
    await made.hosting.close()
    made.assert_forgotten()


def launched(container: str = "c1") -> control_link.Launched:
    return control_link.Launched(container, os.getpid())


def spec(container: str = "c1", cores: float = 1.0) -> ContainerSpec:
    return robot_spec(container, version=HOUSE, cores=cores)


def small_spec(container: str) -> ContainerSpec:
    return ContainerSpec(container, "ann", HOUSE, 1.0, robot_config(model="turtlebot3_burger"))


async def test_container_is_launched_and_its_exit_reported(host: Host) -> None:
    host.start(spec())
    await host.reported(launched("c1"))
    (launch,) = host.runtime.launches
    assert (launch.spec, launch.link, launch.secret) == (spec(), "link.sock", "secret")
    assert launch.machine == str(host.gateway.path)
    assert (Path(launch.layers) / "layers").read_text() == HOUSE.version
    assert host.gateway.awaited == 1
    host.runtime.processes["c1"].end(3)
    await host.reported(control_link.Exited("c1", 3))
    host.assert_forgotten()


async def test_resized_container_moves_to_the_least_used_cpus(host: Host) -> None:
    host.start(spec("c1"))
    await host.reported(launched("c1"))
    host.start(spec("c2"))
    await host.reported(launched("c2"))
    host.hosting.resize(control_link.ResizeContainer("c1", 2.5))
    resized = host.runtime.processes["c1"].launch
    assert (resized.spec.cores, resized.cpus, resized.threads) == (2.5, (0, 2, 3), 2)
    host.start(spec("c3"))
    await host.reported(launched("c3"))
    assert host.runtime.processes["c3"].launch.cpus == (0,), "the CPU of which least is given away now"
    host.hosting.resize(control_link.ResizeContainer("c9", 1.0))


async def test_layers_are_inflated_for_the_robot_or_a_turtlebot2(host: Host) -> None:
    host.start(small_spec("c1"))
    await host.reported(launched("c1"))
    host.start(planning_spec("p1", version=HOUSE))
    await host.reported(launched("p1"))
    assert host.building.radii == [robot_model(model).robot_radius for model in ("turtlebot3_burger", "turtlebot2")]


async def test_a_robot_that_makes_a_map_gets_no_layers(host: Host) -> None:
    host.start(mapping_spec("m1"))
    await host.reported(launched("m1"))
    assert (host.runtime.launches[0].layers, host.building.specs) == ("", [])
    host.runtime.processes["m1"].end(0)
    await host.reported(control_link.Exited("m1", 0))
    host.assert_forgotten()


async def test_layers_are_inflated_for_the_radius_of_urdf_or_parameters(host: Host) -> None:
    urdf = describe(example("turtlebot3_waffle"))
    described = robot_config(urdf=urdf)
    own = robot_config(urdf=urdf, parameters={"global_costmap": {"robot_radius": 0.3}})
    for number, config in enumerate((described, own)):
        host.start(ContainerSpec(f"c{number}", "ann", HOUSE, 1.0, config))
        await host.reported(launched(f"c{number}"))
    assert host.building.radii == [0.238, 0.3]


async def test_masks_are_applied_to_the_layers_of_their_robot_only(host: Host) -> None:
    masks = {"keepout_filter": MapVersion("kept", "v1")}
    newer = {"keepout_filter": MapVersion("kept", "v2")}
    for number, own in enumerate((masks, {}, newer, masks)):
        host.start(ContainerSpec(f"c{number}", "ann", HOUSE, 1.0, robot_config(masks=own)))
        await host.reported(launched(f"c{number}"))
    assert [spec.masks for spec in host.building.specs] == [masks, {}, newer]
    folders = [launch.layers for launch in host.runtime.launches]
    assert len(set(folders)) == 3
    assert folders[0] == folders[3]


async def test_layers_of_an_octomap_use_the_robots_height(host: Host) -> None:
    given: list[dict[str, Any]] = [
        {"in_space": True},
        {"in_space": False},
        {"in_space": True, "urdf": describe(example("turtlebot2"))},
        {"in_space": True, "parameters": {"voxel_layer": {"min_obstacle_height": 0.1, "max_obstacle_height": 1.2}}},
        {"in_space": True, "parameters": {"voxel_layer": {"enabled": False}}},
    ]
    for number, fields in enumerate(given):
        host.start(ContainerSpec(f"c{number}", "ann", HOUSE, 1.0, robot_config(**fields)))
        await host.reported(launched(f"c{number}"))
    heights = [spec.heights for spec in host.building.specs]
    assert heights == [(None, 0.42), None, (None, pytest.approx(0.4602)), (0.1, 1.2)]
    folders = [launch.layers for launch in host.runtime.launches]
    assert len(set(folders)) == 4
    assert folders[1] == folders[4]


async def test_container_with_an_invalid_footprint_is_refused(host: Host) -> None:
    bad = robot_config(parameters={"global_costmap": {"footprint": [[0, 0]]}})
    host.start(ContainerSpec("c1", "ann", HOUSE, 1.0, bad))
    refusal = Refusal("invalid-parameter", "footprint must be a list of at least three corners x, y [m]")
    await host.reported(control_link.LaunchFailed("c1", refusal))


async def test_containers_are_spread_over_the_cpus_and_exits_free_them(host: Host) -> None:
    for number in range(4):
        host.start(spec(f"c{number}"))
        await host.reported(launched(f"c{number}"))
    assert [launch.cpus for launch in host.runtime.launches] == [(n,) for n in range(4)]
    host.runtime.processes["c2"].end(0)
    await host.reported(control_link.Exited("c2", 0))
    host.start(spec("c4"))
    await host.reported(launched("c4"))
    assert host.runtime.launches[-1].cpus == (2,)
    host.start(spec("c5", cores=2.5))
    await host.reported(launched("c5"))
    last = host.runtime.launches[-1]
    assert last.cpus == (0, 1, 2)
    assert last.threads == 2


async def test_containers_launched_at_once_are_spread_over_the_cpus(host: Host) -> None:
    host.runtime.go.clear()
    for number in range(4):
        host.start(spec(f"c{number}"))
    await until(lambda: len(host.runtime.launches) == 4)
    assert sorted(launch.cpus for launch in host.runtime.launches) == [(0,), (1,), (2,), (3,)]
    host.runtime.go.set()


@pytest.mark.parametrize(
    ("error", "slug"),
    [(Unavailable("no room"), "unavailable"), (OSError(24, "too many open files"), "error")],
    ids=["known", "unknown"],
)
async def test_failed_launch_is_reported_and_cleaned_up(host: Host, error: Exception, slug: str) -> None:
    host.runtime.error = error
    host.start(spec())
    await until(lambda: host.news)
    (failed,) = host.news
    assert isinstance(failed, control_link.LaunchFailed)
    assert failed.refusal.slug == slug
    host.assert_forgotten()


async def test_invalid_map_is_reported(host: Host) -> None:
    host.building.error = InvalidMap("not square")
    host.start(spec())
    await host.reported(control_link.LaunchFailed("c1", Refusal("invalid-map", "not square")))
    host.assert_forgotten()


async def test_missing_map_is_reported(host: Host) -> None:
    host.building.error = NotFound("map", "house")
    host.start(spec())
    await host.reported(control_link.LaunchFailed("c1", Refusal("not-found", "unknown map 'house'")))
    host.assert_forgotten()
    assert host.runtime.launches == []


async def test_size_above_the_machines_cores_is_reported(host: Host) -> None:
    host.start(spec(cores=5.0))
    await until(lambda: host.news)
    (failed,) = host.news
    assert isinstance(failed, control_link.LaunchFailed)
    assert failed.refusal.slug == "quota-exceeded"
    host.assert_forgotten()


async def test_container_stopped_during_the_map_build_never_runs(host: Host) -> None:
    host.building.go.clear()
    host.start(spec())
    await until(lambda: host.building.radii)
    host.hosting.stop(control_link.StopContainer("c1"))
    host.building.go.set()
    await until(lambda: host.news)
    assert isinstance(host.news[0], control_link.LaunchFailed)
    assert host.runtime.launches == []
    host.assert_forgotten()


async def test_container_stopped_during_launch_is_killed_once_it_runs(host: Host) -> None:
    host.runtime.go.clear()
    host.start(spec())
    await until(lambda: host.runtime.launches)
    host.hosting.stop(control_link.StopContainer("c1"))
    host.runtime.go.set()
    await host.reported(control_link.Exited("c1", -9))
    host.assert_forgotten()


async def test_container_is_killed_after_its_grace_period(host: Host) -> None:
    host.start(spec())
    await host.reported(launched())
    host.hosting.stop(control_link.StopContainer("c1", grace=0.05))
    assert not host.runtime.processes["c1"].killed
    await host.reported(control_link.Exited("c1", -9))


async def test_exit_during_the_grace_period_reports_its_own_code(host: Host) -> None:
    host.start(spec())
    await host.reported(launched())
    host.hosting.stop(control_link.StopContainer("c1", grace=0.05))
    host.runtime.processes["c1"].end(0)
    await host.reported(control_link.Exited("c1", 0))
    await until(lambda: host.runtime.processes["c1"].killed)  # which does nothing to an exited process
    assert [event for event in host.news if isinstance(event, control_link.Exited)] == [control_link.Exited("c1", 0)]


async def test_stopping_an_unknown_container_changes_nothing(host: Host) -> None:
    host.hosting.stop(control_link.StopContainer("c99"))
    assert host.hosting._hosted == {}


async def test_layers_are_kept_while_any_of_their_containers_runs(host: Host) -> None:
    for name in ("c1", "c2"):
        host.start(spec(name))
        await host.reported(launched(name))
    layers = Path(host.runtime.launches[0].layers)
    host.runtime.processes["c1"].end(0)
    await host.reported(control_link.Exited("c1", 0))
    assert (layers / "layers").exists()
    host.runtime.processes["c2"].end(0)
    await host.reported(control_link.Exited("c2", 0))
    await until(lambda: not layers.exists())


async def test_loads_cover_running_containers_only(host: Host) -> None:
    assert host.hosting.loads() == []
    host.start(spec())
    await host.reported(launched())
    host.runtime.go.clear()
    host.start(spec("c2"))
    (load,) = host.hosting.loads()
    assert load.container == "c1"
    assert load.cpu > 0.0
    assert load.pss > 1 << 20
    host.runtime.processes["c1"].pid = 2**22 + 1  # no such process
    assert host.hosting.loads() == []


async def test_closing_kills_containers_and_cancels_starts(tmp_path: Path) -> None:
    host = Host(tmp_path)
    host.start(spec())
    await host.reported(launched())
    host.building.go.clear()
    host.start(small_spec("c2"))
    host.start(planning_spec("p1", version=HOUSE))
    await asyncio.sleep(0)
    async with patience(10):
        await host.hosting.close()
    assert host.runtime.processes["c1"].killed
    assert host.runtime.closed
    host.assert_forgotten()
    host.cache.remove_all()


async def test_running_containers_are_listed_and_those_not_kept_end(host: Host) -> None:
    spec = msgspec.structs.replace(robot_spec("c1", version=HOUSE), checkpoint={"amcl": b"{}"})
    host.start(spec)
    host.start(coordinator_spec("c2", version=HOUSE))
    host.start(planning_spec("p1", version=HOUSE))
    await until(lambda: len(host.runtime.processes) == 3)
    host.hosting.resize(control_link.ResizeContainer("c1", 2.0))
    host.runtime.go.clear()
    host.start(robot_spec("c3", robot="tb3", version=HOUSE))
    await until(lambda: len(host.runtime.launches) == 4)
    first, second = host.hosting.carried()
    assert first == control_link.RunningContainer(
        msgspec.structs.replace(spec, checkpoint={}), 2.0, "secret", os.getpid()
    )
    assert second.spec.id == "c2", "and neither what only plans nor what is still to be started"
    host.hosting.keep_only({"c1"})
    host.runtime.go.set()
    for ended in ("c2", "c3", "p1"):
        await host.reported(control_link.Exited(ended, -9))
    assert [carried.spec.id for carried in host.hosting.carried()] == ["c1"]
    await host.gateway.start()
    attached = await dial_gateway(host.gateway.path)
    attached.write(machine_link.AttachContainer("c1", "secret"))
    await until(lambda: host.gateway.awaited == 0)
    host.hosting.endpoint_came()
    assert host.runtime.processes["c1"].told_of_endpoints == 1
    assert await receive(attached) == machine_link.EndpointCame()
    await attached.close()
    await host.gateway.close()
    host.runtime.processes["c1"].end(0)
    await host.reported(control_link.Exited("c1", 0))
    host.assert_forgotten()


NEXT = MapVersion("house", "f" * 64)


async def attached(host: Host, container: str = "c1") -> FrameStream[machine_link.ToContainer]:
    """Attach a container as its process does."""
    stream = await dial_gateway(host.gateway.path)
    stream.write(machine_link.AttachContainer(container, "secret"))
    return stream


def use_map(version: MapVersion, container: str = "c1") -> control_link.UseMapVersions:
    return control_link.UseMapVersions(container, version, {}, in_space=False)


@pytest.fixture
async def served(host: Host) -> AsyncIterator[Host]:
    """Return the supervisor, with a gateway that containers can attach to."""
    await host.gateway.start()
    yield host
    await host.gateway.close()


@pytest.fixture
def compared(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, str]]:
    """Return the versions that are compared, whose difference is one rectangle."""
    found: list[tuple[str, str]] = []

    def changed_cells(before: Path, after: Path) -> list[Rectangle]:
        found.append(((before / "layers").read_text(), (after / "layers").read_text()))
        return [Rectangle(1, 2, 3, 4)]

    monkeypatch.setattr(map_cache, "changed_cells", changed_cells)
    return found


async def test_clones_follow_their_map_with_layers_made_once(served: Host, compared: list[tuple[str, str]]) -> None:
    streams = []
    for container in ("c1", "c2"):
        served.start(spec(container))
        await served.reported(launched(container))
        served.hosting.use_map(use_map(NEXT, container))  # also if it attaches only later
        streams.append(await attached(served, container))
    for stream in streams:
        frame = await receive(stream)
        assert isinstance(frame, machine_link.UseLayers)
        assert (frame.map, frame.changes) == (NEXT, [(1, 2, 3, 4)])
        assert (Path(frame.layers) / "layers").read_text() == NEXT.version
        stream.write(machine_link.MapInUse(NEXT))
    await until(lambda: [carried.spec.map for carried in served.hosting.carried()] == [NEXT, NEXT])
    assert len(served.building.specs) == 2
    assert compared == [(HOUSE.version, NEXT.version)]
    assert [folder.name.split("@")[1] for folder in served.cache._users] == [NEXT.version]
    assert all(path.name.split("@")[1] == NEXT.version for path in (served.gateway.path.parent / "maps").iterdir())
    served.hosting.use_map(use_map(NEXT))
    for stream in streams:
        await stream.close()


async def test_a_container_that_refuses_layers_keeps_its_own(served: Host, compared: list[tuple[str, str]]) -> None:
    served.start(spec())
    await served.reported(launched())
    stream = await attached(served)
    served.hosting.use_map(use_map(NEXT))
    await receive(stream)
    stream.write(machine_link.MapInUse(NEXT, Refusal("invalid-map", "no")))
    await until(lambda: [folder.name.split("@")[1] for folder in served.cache._users] == [HOUSE.version])
    assert [carried.spec.map for carried in served.hosting.carried()] == [HOUSE]
    await stream.close()


async def test_layers_that_cannot_be_made_now_are_tried_again(
    served: Host, compared: list[tuple[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(container_supervisor, "RETRY", 0.01)
    served.start(spec())
    await served.reported(launched())
    stream = await attached(served)
    served.building.error = Unavailable("shared memory is full")
    served.hosting.use_map(use_map(NEXT))
    await until(lambda: len(served.building.specs) > 2)
    served.building.error = None
    assert isinstance(await receive(stream), machine_link.UseLayers)
    await stream.close()


async def test_requests_act_for_the_version_in_use(served: Host, compared: list[tuple[str, str]]) -> None:
    served.start(spec())
    await served.reported(launched())
    stream = await attached(served)
    served.hosting.use_map(use_map(NEXT))
    await receive(stream)
    for number, version in enumerate((HOUSE, NEXT)):
        if version == NEXT:
            stream.write(machine_link.MapInUse(NEXT))
        plan = records.plan(f"p{number}", user="ann", robot="tb1", map="house", version=version.version)
        stream.write(machine_link.KeepPlan(number, plan))
        assert await receive(stream) == machine_link.Done(number)
    await stream.close()


async def test_an_order_that_arrives_after_the_exit_is_ignored(served: Host) -> None:
    layers = await served.cache.ensure(LayerSpec(HOUSE, 0.2))
    followed = FollowedMap(spec(), layers, lambda _spec, _layers: None)
    await followed.close(served.cache)
    followed.follow(use_map(NEXT), served.cache, served.gateway)
    await asyncio.sleep(0.01)
    assert [one.map for one in served.building.specs] == [HOUSE]
    assert not +served.cache._users
