"""``ppaas map import-graph`` and ``export-graph``: reports, dry runs, pictures, and lanes that replace others."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.imports.graphs.reading import import_graph
from ppaas.zones.reading import zones_of
from tests.support.cloud.command_line import CommandLine
from tests.support.geojson import collection, feature
from tests.support.graphs import edge, layout, lif, lif_edge, lif_node, node, route_graph, segments_of
from tests.support.sources import ROOT
from tests.support.storage.records import GivenMap, put_map

OFFICE = ROOT / "docs" / "examples" / "office.yaml"
PLACES = ((1.0, 4.5), (6.0, 4.5), (6.0, 2.0))
GRAPH = route_graph(
    *(node(at, place) for at, place in enumerate(PLACES)),
    edge(3, 0, 1, metadata={"abs_speed_limit": 0.3}),
    edge(4, 1, 0, metadata={"abs_speed_limit": 0.3}),
    edge(5, 1, 2),
    node(9, (900.0, 0.0)),
)
SEGMENTS = {(PLACES[0], PLACES[1]), (PLACES[1], PLACES[0]), (PLACES[1], PLACES[2])}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return a route graph in the office, with a node that is off the map."""
    path = tmp_path / "routes.geojson"
    path.write_bytes(GRAPH)
    return path


@pytest.fixture
def owner(ppaas: CommandLine) -> CommandLine:
    """Return the command line of ann, who has the map office."""
    image = OFFICE.with_suffix(".pgm").read_bytes()
    put_map(ppaas.services.map_store, GivenMap("office", "ann", OFFICE.read_bytes(), image))
    return ppaas


async def test_a_dry_run_reports_without_a_cloud(ppaas: CommandLine, file: Path, tmp_path: Path) -> None:
    picture = tmp_path / "lanes.png"
    options = ["--dry-run", "--on", str(OFFICE), "--picture", str(picture)]
    ended = await ppaas("map", "import-graph", "office", str(file), *options, user=None)
    assert ended.status == 0, ended.err
    assert ended.rows == [["lanes", "zones", "stations"], ["2", "1", "0"]]
    assert "outside of the map, which is at" in ended.err
    assert "routes.geojson: " in ended.err.splitlines()[-1]
    blue = (np.asarray(Image.open(picture).convert("RGB")) == (23, 95, 214)).all(axis=2)
    assert blue.sum() > 100


async def test_a_report_is_json_if_wanted(ppaas: CommandLine, file: Path) -> None:
    ended = await ppaas("map", "import-graph", "office", str(file), "--dry-run", "--json", user=None)
    assert json.loads(ended.out) == {"lanes": 2, "zones": 1, "stations": 0}
    assert json.loads(ended.err)["source"] == "routes.geojson"


async def test_lanes_are_published_and_other_zones_stay(owner: CommandLine, file: Path, tmp_path: Path) -> None:
    before = tmp_path / "before.geojson"
    old = feature({"type": "LineString", "coordinates": [[1, 1], [3, 1]]}, name="old", kind="lane")
    before.write_bytes(collection(feature(name="stairs"), old, feature(name="0.3 m/s", kind="no_stop")))
    assert (await owner("map", "zones", "office", "--put", str(before))).status == 0
    done = await owner(
        "map", "import-graph", "office", str(file), "--message", "by Nav2", "--picture", str(tmp_path / "p.png")
    )
    assert done.status == 0, done.err
    zones = zones_of((await owner("map", "zones", "office", "--json")).out)
    assert {zone.name for zone in zones.zones} == {"stairs", "0 - 1", "1 - 2", "0.3 m/s"}
    assert segments_of(zones) == SEGMENTS
    assert owner.services.map_store.map_head("office").present.message == "by Nav2"
    assert (tmp_path / "p.png").is_file()


async def test_lanes_are_written_for_other_programs_and_read_again(owner: CommandLine, tmp_path: Path) -> None:
    given = tmp_path / "office.lif.json"
    station = {"stationId": "ramp", "interactionNodeIds": ["c"]}
    nodes = [lif_node(name, *place) for name, place in zip("abc", PLACES, strict=True)]
    given.write_bytes(lif(layout(nodes, [lif_edge("a", "b"), lif_edge("b", "a"), lif_edge("b", "c")], [station])))
    assert (await owner("map", "import-graph", "office", str(given))).status == 0
    for name in ("out.lif.json", "out.geojson"):
        done = await owner("map", "export-graph", "office", "--out", str(tmp_path / name))
        assert done.status == 0, done.err
        zones, _ = import_graph((tmp_path / name).read_bytes(), name)
        assert segments_of(zones) == SEGMENTS
        assert [zone.name for zone in zones.stations] == ["ramp"]
    refused = await owner("map", "export-graph", "office", "--out", str(tmp_path / "out.txt"))
    assert "a layout of LIF ends with .lif.json" in refused.err


async def test_stations_are_places_of_tasks(owner: CommandLine, tmp_path: Path) -> None:
    point = {"type": "Point", "coordinates": [2.0, 3.0]}
    zones = tmp_path / "zones.geojson"
    zones.write_bytes(
        collection(
            feature(point, name="dock", kind="station", yaw=1.5), feature(point, name="the ramp", kind="station")
        )
    )
    await owner("map", "zones", "office", "--put", str(zones))
    added = await owner("map", "task", "add", "office", "pick_drop", "--at", "dock", "--at", "the", "ramp", "--json")
    assert json.loads(added.out)["places"] == [[2.0, 3.0, 1.5], [2.0, 3.0, 0.0]], added.err
    added = await owner("map", "task", "add", "office", "go_to", "--at", "-1", "2.5", "--json")
    assert json.loads(added.out)["places"] == [[-1.0, 2.5, 0.0]]
    missing = await owner("map", "task", "add", "office", "go_to", "--at", "duck")
    assert "the map office has no station 'duck'; do you mean 'dock'?" in missing.err


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["--on", str(OFFICE)], "--on is the map of a dry run"),
        (["--dry-run", "--picture", "p.png"], "give its file with --on MAP.yaml"),
        (["--dry-run", "--picture", "p.jpg", "--on", str(OFFICE)], ".png"),
        (
            ["--dry-run", "--shift", "500", "0", "0", "--on", str(OFFICE)],
            "has no lane and no station that can be imported",
        ),
    ],
)
async def test_options_that_do_not_fit_are_refused(
    ppaas: CommandLine, file: Path, arguments: list[str], reason: str
) -> None:
    ended = await ppaas("map", "import-graph", "office", str(file), *arguments)
    assert ended.status != 0
    assert reason in ended.err


async def test_a_file_that_is_missing_is_named(ppaas: CommandLine, tmp_path: Path) -> None:
    ended = await ppaas("map", "import-graph", "office", str(tmp_path / "none.json"), "--dry-run")
    assert "cannot read" in ended.err
