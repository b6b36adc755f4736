"""``ppaas map zones``: shown, put, written to a file and removed; and zones of maps that are published and fetched."""

import json
from pathlib import Path
from typing import Any

import pytest

from ppaas.zones.reading import geojson_of, with_time_zones, zones_of
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import found_map, house, put_map

SQUARE = {"type": "Polygon", "coordinates": [[[-1, -2], [-0.9, -2], [-0.9, -1.9], [-1, -2]]]}
LINE = {"type": "LineString", "coordinates": [[-1, -2], [-0.9, -2]]}
WEEK = {"days": ["mon", "fri"], "from": "22:00", "to": "06:00"}
LONG_AGO = {"until": "2001-01-01T00:00:00"}


def feature(name: str, kind: str, geometry: Any = SQUARE, **fields: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": {"name": name, "kind": kind} | fields}


ALL = {
    "type": "FeatureCollection",
    "features": [
        feature("stairs", "keep_out"),
        feature("ramp", "speed_limit", max_speed=0.3, times=[WEEK, LONG_AGO]),
        feature("bend", "speed_limit", percent=50, times=[LONG_AGO]),
        feature("lane", "one_way", LINE, width=1.0, strict=True),
        feature("aisle", "one_way", direction=1.5708),
        feature("main", "lane", LINE),
        feature("out", "lane", LINE, one_way=True),
        feature("door", "no_stop", times=[{"from": "00:00"}]),
        feature("lift", "capacity", robots=1),
        feature("hall", "capacity", robots=3),
    ],
}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return a file with a zone of each kind."""
    path = tmp_path / "house.zones.geojson"
    path.write_text(json.dumps(ALL))
    return path


@pytest.fixture
def owner(ppaas: CommandLine) -> CommandLine:
    """Return the command line of ann, who has the map house."""
    put_map(ppaas.services.map_store, house())
    return ppaas


async def test_zones_are_put_and_shown_with_their_rules_and_times(owner: CommandLine, file: Path) -> None:
    none = await owner("map", "zones", "house")
    assert (none.status, none.out) == (0, "no zones; add some: ppaas map zones MAP --put FILE.geojson\n")
    put = await owner("map", "zones", "house", "--put", str(file), "--message", "rules of the hall & yard")
    assert (put.status, put.err) == (0, "")
    head = owner.services.map_store.map_head("house")
    assert head.present.message == "rules of the hall & yard"
    shown = (await owner("map", "zones", "house")).out.splitlines()
    assert shown[0].split() == ["name", "kind", "detail", "times", "in_force"]
    assert [line.split(maxsplit=2)[:2] for line in shown[1:3]] == [["stairs", "keep_out"], ["ramp", "speed_limit"]]
    text = "\n".join(" ".join(line.split()) for line in shown)
    assert "stairs keep_out - always yes" in text
    assert "ramp speed_limit 0.3 m/s mon fri 22:00-06:00; until 2001-01-01T00:00:00" in text
    assert "bend speed_limit 50 % until 2001-01-01T00:00:00 no" in text
    assert "lane one_way along a line, strict always yes" in text
    assert "aisle one_way 1.57 rad always yes" in text
    assert "main lane - always yes" in text
    assert "out lane one way always yes" in text
    assert "door no_stop - always yes" in text
    assert "lift capacity 1 robot always yes" in text
    assert "hall capacity 3 robots always yes" in text


async def test_places_of_a_building_are_shown_with_what_they_belong_to(owner: CommandLine, tmp_path: Path) -> None:
    def feature(kind: str, geometry: str, coordinates: object, **fields: object) -> dict[str, object]:
        shape = {"type": geometry, "coordinates": coordinates}
        return {"type": "Feature", "geometry": shape, "properties": {"name": kind, "kind": kind, **fields}}

    features = [
        feature("door", "LineString", [[-0.9, -1.9], [-0.95, -1.9]], lift="north"),
        feature("passage", "Point", [-0.9, -1.9], way="ramp", yaw=0.0),
        feature("dock", "Point", [-0.9, -1.9], yaw=0.0, dock_type="v_shape", charges=False),
    ]
    path = tmp_path / "places.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    assert (await owner("map", "zones", "house", "--put", str(path))).status == 0
    text = "\n".join(" ".join(line.split()) for line in (await owner("map", "zones", "house")).out.splitlines())
    assert "door door of lift north always yes" in text
    assert "passage passage ramp always yes" in text
    assert "dock dock v_shape, no charger always yes" in text


async def test_zones_are_printed_and_written_as_geojson(owner: CommandLine, file: Path, tmp_path: Path) -> None:
    version = json.loads((await owner("map", "zones", "house", "--put", str(file), "--json")).out)["version"]
    printed = json.loads((await owner("map", "zones", "house", "--json")).out)
    assert zones_of(json.dumps(printed)) == zones_of(json.dumps(ALL))
    assert "stairs" in printed["in_force"]
    out = tmp_path / "out.geojson"
    await owner("map", "zones", "house", "--remove", "--message", "rebuilt", "--if-match", version[:8])
    for of in (("--version", version[:8]), ("--version", version)):
        assert (await owner("map", "zones", "house", "--out", str(out), *of)).status == 0
        assert out.read_bytes() == geojson_of(with_time_zones(zones_of(json.dumps(ALL))))
    shown = await owner("map", "zones", "house", "--version", version)
    assert shown.rows[0] == ["name", "kind", "detail", "times"]
    assert json.loads((await owner("map", "zones", "house", "--json")).out)["features"] == []


async def test_zones_are_published_and_fetched_with_the_map(
    ppaas: CommandLine, tmp_path: Path, file: Path, house: Path
) -> None:
    published = await ppaas("map", "publish", str(house), "--zones", str(file))
    assert published.status == 0, published.err
    folder = tmp_path / "copies"
    written = (await ppaas("map", "fetch", "house", "--to", str(folder))).out.splitlines()
    assert str(folder / "house.zones.geojson") in written
    assert zones_of((folder / "house.zones.geojson").read_bytes()) == zones_of(
        found_map(ppaas.services.map_store).zones
    )


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("--put", "missing.geojson"), "cannot read the zones"),
        (("--dry-run",), "--dry-run checks the zones of a file; give --put FILE"),
        (("--picture", "zones.jpg"), "pictures are PNG files"),
        (("--picture", "zones.png", "--remove"), "leave out --remove and --out"),
        (("--message", "no"), "give --put FILE or --remove"),
        (("--if-match", "abc"), "give --put FILE or --remove"),
        (("--remove", "--out", "x.geojson"), "leave out --put and --remove"),
        (("--out", "missing/x.geojson"), "cannot write the file"),
        (("--remove",), "zones"),
        (("--version", "abc"), "abc"),
    ],
)
async def test_wrong_arguments_change_nothing(owner: CommandLine, arguments: tuple[str, ...], text: str) -> None:
    ended = await owner("map", "zones", "house", *arguments)
    assert (ended.status, ended.out) == (1, "")
    assert text in ended.err
    assert len(owner.services.map_store.versions("house")) == 1


async def test_wrong_zones_are_refused_with_the_reason(owner: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "wrong.geojson"
    file.write_text(json.dumps(ALL | {"features": [feature("moat", "moat")]}))
    ended = await owner("map", "zones", "house", "--put", str(file))
    assert ended.status == 1
    assert "invalid-zones: properties of zone 'moat'" in ended.err


BOW_TIE = {"type": "Polygon", "coordinates": [[[-1, -2], [-0.9, -1.9], [-0.9, -2], [-1, -1.9], [-1, -2]]]}


async def test_zones_are_checked_and_drawn_before_they_are_published(owner: CommandLine, tmp_path: Path) -> None:
    file, picture = tmp_path / "zones.geojson", tmp_path / "zones.png"
    lift = feature("lift", "capacity", robots=1.0)
    file.write_text("\ufeff" + json.dumps(ALL | {"features": [lift]}), encoding="utf-8")
    ended = await owner("map", "zones", "house", "--put", str(file), "--dry-run", "--picture", str(picture))
    assert (ended.status, ended.err) == (0, "")
    assert ended.out.splitlines()[:2] == ["zones", "1"]
    assert "warning: zone 'lift': properties of a table are read as what they were" in ended.out
    assert len(owner.services.map_store.versions("house")) == 1
    valid = picture.read_bytes()
    file.write_text(json.dumps(ALL | {"features": [lift, feature("server room", "keep_out", BOW_TIE)]}))
    for arguments in (("--dry-run",), ()):
        picture.unlink()
        ended = await owner("map", "zones", "house", "--put", str(file), "--picture", str(picture), *arguments)
        assert ended.status == 1
        assert "zone 'server room': its outline crosses itself at (-0.95, -1.95)" in ended.err
        assert picture.read_bytes() != valid
    assert len(owner.services.map_store.versions("house")) == 1


async def test_the_zones_of_a_map_are_drawn(owner: CommandLine, tmp_path: Path, file: Path) -> None:
    picture = tmp_path / "zones.png"
    put = await owner("map", "zones", "house", "--put", str(file), "--json")
    assert json.loads(put.out)["warnings"] != []
    assert (await owner("map", "zones", "house", "--picture", str(picture))).status == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


async def test_a_file_that_is_no_zones_is_named(owner: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "nav_graph.yaml"
    file.write_text("building_name: office\nlevels:\n  L1: {lanes: []}\n")
    ended = await owner("map", "zones", "house", "--put", str(file), "--picture", str(tmp_path / "zones.png"))
    assert (ended.status, ended.out) == (1, "")
    assert "invalid-zones: zones are not valid JSON: this is YAML of Open-RMF" in ended.err


async def test_a_zone_set_of_vda5050_is_put_and_written(owner: CommandLine, tmp_path: Path) -> None:
    corners = [{"x": -1.0, "y": -2.0}, {"x": -0.9, "y": -2.0}, {"x": -0.9, "y": -1.9}]
    stairs = {"zoneId": "stairs", "zoneType": "BLOCKED", "vertices": corners}
    given, written = tmp_path / "given.json", tmp_path / "written.json"
    given.write_text(json.dumps({"zoneSet": {"mapId": "hall", "zoneSetId": "one", "zones": [stairs]}}))
    put = await owner("map", "zones", "house", "--put", str(given), "--vda5050")
    assert (put.status, put.err) == (0, "")
    assert [zone["properties"]["kind"] for zone in json.loads(await shown(owner))["features"]] == ["keep_out"]
    out = await owner("map", "zones", "house", "--out", str(written), "--vda5050")
    assert (out.status, out.err) == (0, "")
    version = owner.services.map_store.map_head("house").version
    found = json.loads(written.read_text())["zoneSet"]
    assert (found["mapId"], found["zoneSetId"]) == ("house", f"zones-{version[:16]}")
    assert [(zone["zoneId"], zone["zoneType"]) for zone in found["zones"]] == [("stairs", "BLOCKED")]


async def test_the_format_of_vda5050_is_that_of_a_file(owner: CommandLine, tmp_path: Path) -> None:
    refused = await owner("map", "zones", "house", "--vda5050")
    assert (refused.status, refused.out) == (1, "")
    assert "give --put FILE or --out FILE" in refused.err
    wrong = tmp_path / "wrong.json"
    wrong.write_text(json.dumps(ALL))
    refused = await owner("map", "zones", "house", "--put", str(wrong), "--vda5050")
    assert refused.status == 1
    assert "not a zoneSet of VDA 5050 3.0" in refused.err


async def shown(owner: CommandLine) -> str:
    """Return the zones of the house as GeoJSON."""
    return (await owner("map", "zones", "house", "--json")).out
