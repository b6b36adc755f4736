"""The page about plans over floors: its commands work, and its members, options and numbers are those of the code."""

import argparse
import json
import re
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from endpoints.rest.buildings.plan_schemas import (
    MOST_ALTERNATIVES,
    MOST_PLACES,
    BuildingPlanFile,
    RideBegun,
    TravellingRobot,
)
from engine.control.planning.building_requests import KEPT_SECONDS
from ppaas.buildings.layout import BEFORE_DOOR
from ppaas.buildings.planning.legs import Leg
from ppaas.buildings.planning.sessions import MARGIN
from robots.cli.buildings import building_plan
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of

PAGE = "docs/building-plans.md"


@pytest.fixture(scope="module")
def page() -> str:
    """Return the text of the page, in one line."""
    return re.sub(r"\s+", " ", text_of(PAGE))


def test_the_example_is_a_request_and_its_members_are_those_of_the_code(page: str) -> None:
    [shown] = blocks(PAGE, "json")
    BuildingPlanFile.model_validate(json.loads(shown))
    rows = table(PAGE, "member", "meaning")
    named = [name for row in rows for name in re.findall(r"\w+", row[0])]
    assert sorted(named) == sorted(BuildingPlanFile.model_fields)
    meanings = {row[0]: set(re.findall(r"`(\w+)`", row[1])) for row in rows}
    assert meanings["robot"] == set(TravellingRobot.model_fields)
    assert meanings["session"] == set(RideBegun.model_fields)


def test_the_options_are_those_of_the_command() -> None:
    parser = argparse.ArgumentParser()
    building_plan.configure(parser.add_subparsers())
    options = set(re.findall(r"--[a-z]+", text_of(PAGE)))
    known = {name for action in _verb(parser)._actions for name in action.option_strings}
    assert options - {"--id", "--zones", "--only"} <= known
    own = {"--alternatives", "--avoid", "--closed", "--speed", "--stairs", "--label"}
    assert own <= {name for row in table(PAGE, "option", "meaning") for name in re.findall(r"--[a-z]+", row[0])}


def _verb(parser: argparse.ArgumentParser) -> argparse.ArgumentParser:
    [action] = [each for each in parser._actions if isinstance(each, argparse._SubParsersAction)]
    found: argparse.ArgumentParser = action.choices["plan"]
    return found


def test_the_numbers_are_those_of_the_code(page: str) -> None:
    assert [row[0].strip("`") for row in table(PAGE, "kind", "what it is", "its time")] == list(
        get_args(msgspec.structs.fields(msgspec.defstruct("Kinds", [("kind", Leg.__annotations__["kind"])]))[0].type)
    )
    assert f"from {BEFORE_DOOR:g} m before it to {BEFORE_DOOR:g} m behind it" in page
    assert page.count(f"more than {MARGIN:g} s") == 2
    assert f"up to {MOST_ALTERNATIVES} further routes" in page
    assert f"up to {MOST_PLACES} of each" in page
    assert KEPT_SECONDS == 5 * 60
    assert "kept for five minutes" in page


@pytest.mark.journey
def test_the_shell_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(PAGE)}", tmp_path, cloud)
    assert re.search(r"^way +ramp +ground +upper ", printed, re.MULTILINE)
    assert re.search(r"^[\d.]+ s, [\d.]+ m by ramp\nor [\d.]+ s, [\d.]+ m by north$", printed, re.MULTILINE)
    assert re.search(r"^lift +north +ground +upper ", printed, re.MULTILINE), "without the ramp"
    [direct, costs] = [json.loads(line) for line in printed.splitlines() if line.startswith("{")]
    assert [leg["kind"] for leg in direct["legs"]] == ["drive"]
    assert costs["seconds"][0][0] > 0.0
    assert (tmp_path / "route.png").is_file()
