"""Planners and map rules in planning.md are those of the code, and its commands work."""

import json
import re
from pathlib import Path

import msgspec
import pytest
from PIL import Image

from ppaas.clone.planning_variants import allows_unknown
from ppaas.clone.robot_body import costmap_parameters
from ppaas.costmap.global_parameters import GlobalCostmapParameters
from ppaas.maps.formats.map_yaml import MapYaml, Mode, Rules
from ppaas.maps.formats.pictures import MAX_PIXELS
from ppaas.planners import create, planner_names
from ppaas.planners.registry import PLANNERS
from ppaas.plans.path_service import PathRequest
from ppaas.plugins import parameters_in_use
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of
from tests.support.sources import ROOT

PAGE = "docs/planning.md"


def test_the_planners_are_those_installed() -> None:
    rows = table(PAGE, "planner", "ROS alias", "use it for")
    assert sorted(name for name, _, _ in rows) == list(planner_names())
    for name, alias, purpose in rows:
        assert create(name).purpose == purpose
        assert tuple(re.findall(r"\w+/\w+", alias)) == PLANNERS.aliases(name)


def test_rules_modes_and_limits_are_those_of_the_code() -> None:
    text = text_of(PAGE)
    keys = MapYaml(image="a.pgm", resolution=1.0, origin=(0.0, 0.0, 0.0))
    assert "| | " + " | ".join(f"`{rules.value}`" for rules in Rules) + " |" in text
    assert all(f"`{mode.value}`" in text for mode in Mode)
    assert f"| {keys.occupied_thresh} and {keys.free_thresh} | refused |" in text
    assert f"up to {MAX_PIXELS} pixels" in text


def test_the_parameters_are_those_of_the_code() -> None:
    rows = table(PAGE, "parameter", "default", "what it is")
    documented = {name.strip("`"): default for name, default, _ in rows}
    usual = GlobalCostmapParameters()
    defaults = {name: getattr(usual, name) for name in usual.__struct_fields__}
    expected = {name: f"{value:g}" if value else "" for name, value in defaults.items()}
    assert documented == expected | {"allow_unknown": "true"}
    assert all(parameters_in_use(create(name))["allow_unknown"] is True for name in planner_names())


def test_the_documented_parameters_are_taken() -> None:
    request, file, _ = map(json.loads, blocks(PAGE, "json"))
    parsed = msgspec.convert(request, PathRequest)
    assert allows_unknown(parsed.parameters) is False
    assert costmap_parameters(file["parameters"]).changed == {"inflation_radius": 1}
    assert "GlobalPlanner" in PLANNERS.spellings("dijkstra")


@pytest.mark.journey
def test_the_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    printed = [line.split() for line in run_shell(script(PAGE), tmp_path, cloud).splitlines()]
    assert printed[1][0] == "astar"
    assert printed[-1][1:3] == ["office", "astar"]
    with Image.open(tmp_path / "path.png") as drawn, Image.open(ROOT / "docs" / "images" / "path.png") as shown:
        assert drawn.size == shown.size
