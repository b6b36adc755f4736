"""What a container of the Docker engine is shown of its machine; no engine is needed for that."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from engine.model import Launch
from engine.runtimes.docker_container import Booth
from tests.support.launches import Reports


@pytest.fixture
def booth(short_path: Path) -> Booth:
    return Booth(short_path / "c-1", short_path / "shm" / "seen-1")


@pytest.fixture
def launch(short_path: Path) -> Iterator[Launch]:
    layers = short_path / "shm" / "map"
    layers.mkdir(parents=True, mode=0o700)
    for name in ("info.json", "grid.npy", ".astar-12"):
        (layers / name).write_text(name)
    with socket.socket(socket.AF_UNIX) as link, socket.socket(socket.AF_UNIX) as gate:
        for server, name in ((link, "link-of-all.sock"), (gate, "gate.sock")):
            server.bind(str(short_path / name))
            server.listen()
        told = Reports(short_path).launch(layers=str(layers))
        yield replace(told, link=str(short_path / "link-of-all.sock"), machine=str(short_path / "gate.sock"))


def test_it_sees_its_two_sockets_and_the_layers_of_its_map_and_nothing_else(booth: Booth, launch: Launch) -> None:
    seen = booth.admit(launch)
    assert (seen.link, seen.machine, seen.layers) == ("/run/ppaas/link.sock", "/run/ppaas/gate.sock", "/run/map")
    assert {entry.name for entry in booth.sockets.iterdir()} == {"link.sock", "gate.sock"}
    assert {entry.name for entry in booth.layers.iterdir()} == {"info.json", "grid.npy"}


def test_what_it_dials_is_what_listens_outside(booth: Booth, launch: Launch) -> None:
    booth.admit(launch)
    with socket.socket(socket.AF_UNIX) as client:
        client.connect(str(booth.sockets / "link.sock"))


def test_layers_are_the_same_memory_and_what_came_later_is_added(booth: Booth, launch: Launch) -> None:
    booth.admit(launch)
    layers = Path(launch.layers)
    (layers / "hub_labels.index").write_text("late")
    booth.link_layers(layers)
    assert (booth.layers / "hub_labels.index").samefile(layers / "hub_labels.index")
    assert (booth.layers / "grid.npy").samefile(layers / "grid.npy")


def test_what_the_machine_has_stays_when_the_container_goes(booth: Booth, launch: Launch) -> None:
    booth.admit(launch)
    booth.remove()
    assert not booth.sockets.exists()
    assert not booth.layers.exists()
    assert (Path(launch.layers) / "grid.npy").read_text() == "grid.npy"
    assert Path(launch.link).is_socket()


def test_layers_lie_where_no_other_user_of_the_computer_comes(booth: Booth) -> None:
    assert booth.layers.parent.stat().st_mode & 0o077 == 0
