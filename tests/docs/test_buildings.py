"""The page about buildings: its commands work, and its fields, options and operations are those of the code."""

import argparse
import json
import re
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from endpoints.rest.buildings.buildings import MOST_BUILDINGS
from ppaas.buildings.building import (
    MOST_DOORS,
    MOST_FLOORS,
    MOST_LIFTS,
    MOST_WAYS,
    Building,
    DoorSettings,
    Floor,
    LiftSettings,
    WaySettings,
    building_of,
)
from ppaas.buildings.checks import MOST_APART
from ppaas.imports.graphs.rmf.levels import AGREE
from robots.cli.buildings import building_import
from storage.buildings.records import FORMER_BYTES, MOST_FORMER
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of
from tests.support.endpoints.fuzzed_rest import operations
from tests.support.sources import ROOT

PAGE = "docs/buildings.md"
FILE = ROOT / "docs" / "examples" / "buildings" / "house.json"


@pytest.fixture(scope="module")
def page() -> str:
    """Return the text of the page, in one line."""
    return re.sub(r"\s+", " ", text_of(PAGE))


def test_the_example_is_the_file_beside_the_page() -> None:
    [shown] = blocks(PAGE, "json")
    assert building_of(shown) == building_of(FILE.read_bytes())


def test_the_fields_and_their_defaults_are_those_of_the_code() -> None:
    kinds = {"floors": Floor, "lifts": LiftSettings, "doors": DoorSettings, "ways": WaySettings}
    assert list(kinds) == list(Building.__struct_fields__)
    found = []
    for part, names, shown, meaning in table(PAGE, "part", "field", "default", "meaning"):
        fields = {field.encode_name: field for field in msgspec.structs.fields(kinds[part])}
        for name in re.findall(r"\w+", names):
            found.append((part, name))
            known = fields[name].default
            if known is msgspec.NODEFAULT or known in ("", None):
                assert shown == "", name
            else:
                numbers = known if isinstance(known, tuple) else (known,)
                assert shown == ", ".join(each if isinstance(each, str) else f"{each:g}" for each in numbers), name
        if part == "ways" and "kind" in names:
            assert re.findall(r"`(\w+)`", meaning) == list(get_args(WaySettings.__annotations__["kind"]))
    everything = [(part, field.encode_name) for part, kind in kinds.items() for field in msgspec.structs.fields(kind)]
    assert sorted(found) == sorted(everything)


def test_the_numbers_are_those_of_the_code(page: str) -> None:
    assert f"may have {MOST_FLOORS} floors, {MOST_LIFTS} lifts, {MOST_DOORS} doors and {MOST_WAYS} ways" in page
    assert f"and a user {MOST_BUILDINGS} buildings" in page
    assert f"two places more than {MOST_APART:g} m apart" in page
    assert f"Fiducials that are more than {AGREE:g} m from" in page
    assert f"the last {MOST_FORMER} and the current one, within {FORMER_BYTES >> 10} KiB" in page


def test_the_options_are_those_of_the_import() -> None:
    parser = argparse.ArgumentParser()
    verbs = parser.add_subparsers()
    building_import.configure(verbs)
    known = {name for action in verbs.choices["import"]._actions for name in action.option_strings}
    named = {name for row in table(PAGE, "option", "meaning") for name in re.findall(r"--[a-z-]+", row[0])}
    assert named <= known
    assert {"--graph", "--scale", "--anchor", "--radius", "--resolution", "--id", "--dry-run", "--picture"} <= named


def test_the_operations_are_those_of_the_service() -> None:
    ours = [(method, path) for path, method, _ in operations() if path.startswith("/v1/buildings")]
    known = {(method.upper(), path.format(building_id="ID")) for method, path in ours}
    shown = {tuple(operation.split()) for operation, _ in table(PAGE, "operation", "what it does")}
    assert shown == {(method, path) for method, path in known if not path.endswith(("/plans", "/costs"))}


@pytest.mark.journey
def test_the_shell_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(PAGE)}", tmp_path, cloud)
    assert "warning:" not in printed
    assert re.search(r"^lift +north +L2 +\S+, \S+, \S+ +door north front$", printed, re.MULTILINE)
    assert re.search(r"^way +ramp +ground", printed, re.MULTILINE)
    assert json.loads((tmp_path / "inn.json").read_text())["floors"][1]["anchor"] == [-1.5, 0.5, 0.0]
    assert {"inn.png", "house.png"} <= {file.name for file in tmp_path.iterdir()}
