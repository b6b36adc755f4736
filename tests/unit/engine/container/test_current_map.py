"""The map of a container is replaced while the robot drives; planners use indexes that the machine prepared."""

import asyncio
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.container import current_map
from engine.container.current_map import CurrentMap, SharedIndexes
from engine.protocols import machine_link
from engine.specs.containers import ContainerSpec, Launch, MapVersion
from engine.specs.layer_files import open_layers, write_index, write_layers
from ppaas.clone.planning_container import build_planning
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidPlanner, NoValidPath, PlanCancelled, Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.ppaas_msgs import ComputePathRequest, ComputePathResponse
from ppaas.nodes.graph import Graph
from ppaas.planners.watch import proceed
from ppaas.plans.reuse.setup import discard_note
from ppaas.plans.reuse.time_estimates import Times
from ppaas.plans.stored import EmptyLibrary
from ppaas.zones.schedule import Hours
from ppaas.zones.zone import KeepOut, Zone, ZoneSet
from tests.support.world.planar_world import walled_map
from tests.support.zones import rectangle

OPENS, CLOSES = 1_000_000.0, 1_001_000.0
ACROSS = (2.9, 0.0, 3.1, 4.0)


def gate(begin: float = OPENS, end: float = CLOSES) -> Zone:
    """Return a zone that parts the room while it is closed."""
    hours = Hours(since=datetime.fromtimestamp(begin, UTC), until=datetime.fromtimestamp(end, UTC))
    return rectangle(KeepOut(name="gate", times=[hours]), *ACROSS)


def folder_with(folder: Path, *zones: Zone) -> Path:
    folder.mkdir()
    write_layers(folder, build_layers(walled_map(6, 4, []), robot_radius=0.18, zones=ZoneSet([*zones])), created=0.0)
    return folder


class Room:
    """A container that plans in a room, and the time."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, now: float) -> None:
        self.now = now
        monkeypatch.setattr(current_map, "epoch", lambda: self.now)
        spec = ContainerSpec("c1", "ann", MapVersion("room", "v1"), 1.0)
        launch = Launch(spec, str(folder), "", "", secret="", cpus=(0,), threads=1)
        self.current = CurrentMap(launch, EmptyLibrary(), Times(), discard_note)
        self.graph = Graph()
        assert self.current.layers is not None
        build_planning(self.graph, self.current.layers, reuse=self.current.reuse)

    def answer(self) -> Any:
        """Ask for a path through the room."""
        answers: list[Any] = []
        ends = Pose.of(Pose2D(1.0, 2.0)), Pose.of(Pose2D(5.0, 2.0))
        self.graph.call("compute_path", ComputePathRequest(*ends), answers.append)
        return answers[0]


def test_a_zone_is_closed_in_its_times_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    room = Room(folder_with(tmp_path / "a", gate()), monkeypatch, OPENS - 10.0)
    assert room.current.next_change == OPENS
    assert isinstance(room.answer(), ComputePathResponse)
    room.now = OPENS
    room.current.follow_zones(room.graph, None)
    assert isinstance(room.answer(), NoValidPath)
    assert room.current.reuse.filters == {"zones": ["gate"]}, "plans of other times are not reused"
    room.now = CLOSES
    room.current.follow_zones(room.graph, None)
    assert isinstance(room.answer(), ComputePathResponse)
    assert room.current.reuse.filters == {}


def test_a_container_that_starts_while_a_zone_is_closed_keeps_out_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    room = Room(folder_with(tmp_path / "a", gate()), monkeypatch, OPENS + 1.0)
    assert isinstance(room.answer(), NoValidPath)


def test_zones_of_the_next_version_are_used_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    room = Room(folder_with(tmp_path / "a"), monkeypatch, OPENS + 1.0)
    after = folder_with(tmp_path / "b", gate())
    room.current.use(machine_link.UseLayers(MapVersion("room", "v2"), {}, False, str(after), []), room.graph, None)
    assert isinstance(room.answer(), NoValidPath)
    assert room.current.spec.map.version == "v2"
    room.now = CLOSES
    room.current.follow_zones(room.graph, None)
    assert isinstance(room.answer(), ComputePathResponse)


def test_zones_without_times_are_part_of_the_layers(tmp_path: Path) -> None:
    layers = open_layers(folder_with(tmp_path / "a", rectangle(KeepOut(name="wall"), *ACROSS)))
    assert [zone.name for zone in layers.zones.zones] == ["wall"]
    assert layers.keepout is not None
    rows, columns = np.nonzero(layers.keepout.data == OCCUPIED)
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (0, 79, 57, 62)
    assert (layers.to_lethal <= layers.distance).all() and (layers.to_lethal < layers.distance).any()


class Machine:
    """Machine that makes the index when the test allows it."""

    def __init__(self, folder: Path, failure: Exception | None = None) -> None:
        self.folder = folder
        self.failure = failure
        self.go = asyncio.Event()
        self.go.set()
        self.requested: list[str] = []

    async def prepare_index(self, planner: str) -> None:
        self.requested.append(planner)
        await self.go.wait()
        if self.failure is not None:
            raise self.failure
        write_index(self.folder, planner, memoryview(b"made"))


async def call(machine, check=proceed):
    indexes = SharedIndexes(machine.folder)
    indexes.ask(machine, asyncio.get_running_loop())
    return await asyncio.to_thread(indexes, "p", check)


async def test_existing_index_is_opened_without_a_request(tmp_path):
    machine = Machine(tmp_path)
    write_index(tmp_path, "p", memoryview(b"there"))
    assert bytes(await call(machine)) == b"there"
    assert machine.requested == []


async def test_missing_index_is_requested_and_awaited(tmp_path):
    machine = Machine(tmp_path)
    machine.go.clear()
    asyncio.get_running_loop().call_later(0.02, machine.go.set)
    assert bytes(await call(machine)) == b"made"
    assert machine.requested == ["p"]


async def test_unavailable_index_is_none(tmp_path):
    assert await call(Machine(tmp_path, Unavailable("full"))) is None


async def test_map_that_the_planner_cannot_prepare_is_reported(tmp_path):
    with pytest.raises(InvalidPlanner, match="cluttered"):
        await call(Machine(tmp_path, InvalidPlanner("too cluttered")))


async def test_cancelled_planner_stops_waiting_for_the_index(tmp_path):
    machine = Machine(tmp_path)
    machine.go.clear()
    calls = iter(range(3))

    def check() -> None:
        if next(calls, None) is None:
            raise PlanCancelled("no time")

    with pytest.raises(PlanCancelled):
        await call(machine, check)


def test_index_is_none_without_a_machine(tmp_path):
    assert SharedIndexes(tmp_path)("p", proceed) is None
