"""Current map of a container: zones that are closed at times only are closed for its nodes, too."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.container import current_map
from engine.container.current_map import CurrentMap
from engine.protocols import machine_link
from engine.specs.containers import ContainerSpec, Launch, MapVersion
from engine.specs.layer_files import open_layers, write_layers
from ppaas.clone.planning_container import build_planning
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import NoValidPath
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.ppaas_msgs import ComputePathRequest, ComputePathResponse
from ppaas.nodes.graph import Graph
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
