"""The page about zones: its examples are valid, and its kinds, fields, numbers and commands are those of the code."""

import json
import re
from pathlib import Path
from typing import Any, get_args

import msgspec
import pytest

from endpoints.rest.maps.upload_form import MAX_ZONES
from ppaas.maps.formats.map_files import read_info
from ppaas.zones.gate import check_on_map
from ppaas.zones.reading import EDITORS, KEYS, STYLES, zones_of
from ppaas.zones.schedule import DAYS, Hours
from ppaas.zones.zone import (
    LONGEST_NAME,
    MOST_CAPACITIES,
    MOST_MARKS,
    MOST_ON_LANES,
    MOST_POSITIONS,
    MOST_ZONES,
    AnyRule,
    Dock,
    Door,
    Lane,
    LiftCar,
    Passage,
)
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of
from tests.support.endpoints.fuzzed_rest import operations
from tests.support.sources import ROOT

PAGE = "docs/zones.md"
EXAMPLES = ROOT / "docs" / "examples"
FILE, LANES = EXAMPLES / "office.zones.geojson", EXAMPLES / "office.lanes.geojson"
KINDS = {msgspec.inspect.type_info(rule).tag: rule for rule in get_args(AnyRule)}  # type: ignore[attr-defined]


@pytest.fixture(scope="module")
def page() -> str:
    """Return the text of the page, in one line."""
    return re.sub(r"\s+", " ", text_of(PAGE))


def collection(*features: Any) -> bytes:
    return msgspec.json.encode({"type": "FeatureCollection", "features": features})


def test_the_examples_are_zones_on_the_office_of_every_kind() -> None:
    info = read_info((EXAMPLES / "office.yaml").read_bytes(), (EXAMPLES / "office.pgm").read_bytes())
    shown = zones_of(collection(*map(json.loads, blocks(PAGE, "json"))))
    file, lanes = zones_of(FILE.read_bytes()), zones_of(LANES.read_bytes())
    for zones in (shown, file, lanes):
        assert check_on_map(zones, info) == []
    assert {type(zone.rule) for zone in shown.zones} == set(get_args(AnyRule))
    without = {Lane, Door, LiftCar, Passage, Dock}  # lanes would close the rooms
    assert {type(zone.rule) for zone in file.zones} == set(get_args(AnyRule)) - without
    assert lanes.lanes == lanes.zones
    by_name = {zone.name: zone for zone in shown.zones}
    assert by_name["store room"].rule == KINDS["capacity"](name="store room", robots=2)
    assert by_name["workshop"].rule.percent == 50.0  # type: ignore[union-attr]


def test_the_kinds_and_their_properties_are_those_of_the_code() -> None:
    rows = table(PAGE, "kind", "rule", "who obeys")
    assert [kind.strip("`") for kind, *_ in rows] == list(KINDS)
    for kind, rule, _ in rows:
        own = set(KINDS[kind.strip("`")].__struct_fields__) - {"name", "times", "time_zone"}
        assert set(re.findall(r"`(\w+)`", rule)) == own, kind


def test_the_fields_and_days_of_times_are_those_of_the_code(page: str) -> None:
    rows = table(PAGE, "field of `times`", "default", "meaning")
    names = [field.encode_name for field in msgspec.structs.fields(Hours)]
    assert [name for name, *_ in rows] == names
    assert ", ".join(f"`{day}`" for day in DAYS) in rows[0][2]
    begin, end = Hours().begin, Hours().end
    assert [default for _, default, _ in rows] == ["all", begin, end, "", ""]
    [example] = re.findall(r'So `(\{"days".*?\})` is from Friday', page)
    assert msgspec.json.decode(example, type=Hours) == Hours(["fri"], "22:00", "06:00")


def test_the_numbers_and_ignored_properties_are_those_of_the_code(page: str) -> None:
    limits = f"{MOST_MARKS} stations, doors, lifts, passages and docks, and {MOST_ZONES} other zones"
    limits += f" with {MOST_POSITIONS} positions together"
    limits += f", of which {MOST_ON_LANES} are of lanes, and"
    assert f"up to {limits} {MOST_CAPACITIES} zones of" in page
    assert f"of up to {LONGEST_NAME} characters" in page
    assert f"of up to {MAX_ZONES >> 20} MiB" in page
    [named, prefixes] = re.findall(r"editors add: (.*?), and all that begin with (.*?)\.", page)[0]
    assert set(re.findall(r"`(.+?)`", named)) == EDITORS
    assert tuple(re.findall(r"`(.+?)`", prefixes)) == STYLES
    [columns] = re.findall(r"tables of a GIS add, in capitals or not: (.*?)\.", page)
    assert set(re.findall(r"`(.+?)`", columns)) == KEYS


def test_the_operations_are_those_of_the_service() -> None:
    of_zones = [(method, path) for path, method, _ in operations() if path.endswith(("/zones", "/zones/check"))]
    known = {(method.upper(), path.format(map_id="ID", version="V")) for method, path in of_zones}
    assert {tuple(operation.split()) for operation, _ in table(PAGE, "operation", "what it does")} == known


@pytest.mark.journey
def test_the_shell_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(PAGE)}", tmp_path, cloud)
    assert "speed_limit  0.3 m/s" in printed
    assert "mon tue wed thu fri 09:00-17:00" in printed
    assert zones_of((tmp_path / "office.zones.geojson").read_bytes()) == zones_of(FILE.read_bytes())
    versions = printed[printed.rindex("restored") :].splitlines()
    assert ["zones" in line for line in versions[1:]].count(True) >= 1
