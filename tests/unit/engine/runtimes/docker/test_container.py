"""Folders and sizes of Docker containers; needs no Docker Engine."""

import asyncio
import socket
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from engine.processes.background import Background
from engine.runtimes.docker import container as docker_limits
from engine.runtimes.docker.container import ContainerFolders, DockerContainer
from engine.specs.containers import Launch
from ppaas.errors import Unavailable
from tests.support.engine.launches import Reports


@pytest.fixture
def folders(short_path: Path) -> ContainerFolders:
    return ContainerFolders(short_path / "c-1", short_path / "shm" / "seen-1")


@pytest.fixture
def launch(short_path: Path) -> Iterator[Launch]:
    layers = short_path / "shm" / "map"
    layers.mkdir(parents=True, mode=0o700)
    for name in ("info.json", "grid.npy", ".astar-12"):
        (layers / name).write_text(name)
    with socket.socket(socket.AF_UNIX) as link, socket.socket(socket.AF_UNIX) as gateway:
        for server, name in ((link, "link-of-all.sock"), (gateway, "gate.sock")):
            server.bind(str(short_path / name))
            server.listen()
        launch = Reports(short_path).launch(layers=str(layers))
        yield replace(launch, link=str(short_path / "link-of-all.sock"), machine=str(short_path / "gate.sock"))


def test_container_sees_two_sockets_and_its_map_layers_only(folders: ContainerFolders, launch: Launch) -> None:
    seen = folders.link(launch)
    assert (seen.link, seen.machine, seen.layers) == ("/run/ppaas/link.sock", "/run/ppaas/gate.sock", "/run/map")
    assert {entry.name for entry in folders.sockets.iterdir()} == {"link.sock", "gate.sock"}
    assert {entry.name for entry in folders.layers.iterdir()} == {"info.json", "grid.npy"}


def test_linked_socket_reaches_the_endpoint(folders: ContainerFolders, launch: Launch) -> None:
    folders.link(launch)
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(str(folders.sockets / "link.sock"))


def test_replaced_endpoint_socket_is_linked_again(folders: ContainerFolders, launch: Launch) -> None:
    folders.link(launch)
    seen, link = folders.sockets / "link.sock", Path(launch.link)
    link.unlink()
    with pytest.raises(FileNotFoundError):
        folders.link_endpoint()
    for _ in range(2):
        with socket.socket(socket.AF_UNIX) as another, socket.socket(socket.AF_UNIX) as client:
            link.unlink(missing_ok=True)
            another.bind(str(link))
            another.listen()
            folders.link_endpoint()
            folders.link_endpoint()  # also if it is still the same
            client.connect(str(seen))
            another.accept()[0].close()
            assert seen.stat().st_mode & 0o666 == 0o666, "the container runs as another user"


def test_layers_share_memory_and_later_files_are_added(folders: ContainerFolders, launch: Launch) -> None:
    folders.link(launch)
    layers = Path(launch.layers)
    (layers / "hub_labels.index").write_text("late")
    folders.link_layers(layers)
    assert (folders.layers / "hub_labels.index").samefile(layers / "hub_labels.index")
    assert (folders.layers / "grid.npy").samefile(layers / "grid.npy")


def test_files_of_the_machine_are_kept_when_the_container_is_removed(folders: ContainerFolders, launch: Launch) -> None:
    folders.link(launch)
    folders.remove()
    assert not folders.sockets.exists()
    assert not folders.layers.exists()
    assert (Path(launch.layers) / "grid.npy").read_text() == "grid.npy"
    assert Path(launch.link).is_socket()


def test_layers_are_private_to_this_user(folders: ContainerFolders) -> None:
    assert folders.layers.parent.stat().st_mode & 0o077 == 0


class Engine:
    """An engine that is slow for some calls, and refuses to take away memory in use."""

    def __init__(self, *seconds: float, memory_in_use: int = 0) -> None:
        self.seconds = list(seconds)
        self.memory_in_use = memory_in_use
        self.held: dict[str, Any] = {}

    async def limit(self, container: str, limits: Mapping[str, Any]) -> None:
        if self.seconds:
            await asyncio.sleep(self.seconds.pop(0))
        if limits.get("mem_limit", self.memory_in_use) < self.memory_in_use:
            raise Unavailable("device or resource busy")
        self.held |= limits


def resized(engine: Any, folders: ContainerFolders, work: Background) -> DockerContainer:
    return DockerContainer(engine, folders, work.run, lambda _: None)


async def test_later_size_wins_with_a_slow_engine(folders: ContainerFolders, launch: Launch) -> None:
    engine, work = Engine(0.05, 0.0), Background()
    container = resized(engine, folders, work)
    for cores in (2.0, 0.5):
        container.resize(replace(launch, spec=replace(launch.spec, cores=cores)))
    await work.join()
    assert engine.held["cpu_quota"] / engine.held["cpu_period"] == 0.5


async def test_memory_in_use_keeps_its_limit_and_cpus_are_limited(
    folders: ContainerFolders, launch: Launch, caplog: pytest.LogCaptureFixture
) -> None:
    engine, work = Engine(memory_in_use=1 << 40), Background()
    resized(engine, folders, work).resize(launch)
    await work.join()
    assert engine.held["cpu_quota"] == engine.held["cpu_period"]
    assert "mem_limit" not in engine.held
    assert "keeps its old memory limit" in caplog.text


@pytest.fixture
def launching(tmp_path):
    return Reports(tmp_path).launch


def test_size_sets_cpu_quota_and_cpu_set(launching):
    limits = docker_limits.launch_limits(launching(cpus=(1, 3)))
    assert (limits["cpu_quota"] / limits["cpu_period"], limits["cpuset_cpus"]) == (2.0, "1,3")


def test_more_cores_get_more_cpu_shares_and_memory_without_swap(launching):
    one, two = (docker_limits.launch_limits(launching(cpus=cpus)) for cpus in ((0,), (0, 1)))
    assert two["cpu_shares"] == 2 * one["cpu_shares"] > docker_limits.spare_limits()["cpu_shares"]
    assert two["mem_limit"] > one["mem_limit"] > docker_limits.spare_limits()["mem_limit"]
    assert all(limits["memswap_limit"] == limits["mem_limit"] for limits in (one, two))


def test_the_smallest_size_is_accepted_by_the_kernel(launching):
    tiny = launching(cpus=(0,))
    limits = docker_limits.launch_limits(replace(tiny, spec=replace(tiny.spec, cores=1e-6)))
    assert limits["cpu_quota"] >= 1000
    assert limits["cpu_shares"] >= 2
