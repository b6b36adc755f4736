"""Planners and map rules in planning.md are those of the code, and its commands work."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
from PIL import Image

from endpoints.rest.plans.schemas import CostFile
from ppaas.clone.assembly import build_clone
from ppaas.clone.planning_variants import allows_unknown
from ppaas.clone.robot_body import costmap_parameters
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.global_parameters import GlobalCostmapParameters
from ppaas.maps.formats.map_yaml import MapYaml, Mode, Rules
from ppaas.maps.formats.pictures import MAX_PIXELS
from ppaas.maps.octomap import binary_octomap, parse_octomap
from ppaas.maps.octree import octree_of
from ppaas.maps.voxels import MAX_VOXELS
from ppaas.nodes.graph import Graph
from ppaas.nodes.planner_server.node import MAX_COSTS, MAX_ENDS
from ppaas.planners import create, planner_names
from ppaas.planners.registry import PLANNERS
from ppaas.planners.volume import create as create_in_space
from ppaas.planners.volume import planner_names as names_in_space
from ppaas.planners.weights import RELATIVE_ERROR
from ppaas.plans.path_service import PathRequest
from ppaas.plugins import parameters_in_use
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of
from tests.support.sources import ROOT
from tests.support.world.planar_world import walled_map

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


def test_the_3d_planners_are_those_installed():
    for name in names_in_space():
        assert f"- **`{name}`**: {create_in_space(name).purpose}\n" in text_of(PAGE)


def test_the_numbers_are_those_of_the_code():
    assert f"more than {MAX_VOXELS} voxels" in text_of(PAGE)
    assert "by less than 0.02 %; `cost` is recounted" in " ".join(text_of(PAGE).split())
    assert 2 * RELATIVE_ERROR < 0.0002


def test_the_program_in_space_runs():
    [program] = [code for code in blocks(PAGE, "python") if "inflate_voxels" in code]
    command = [sys.executable, "-c", program]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_the_octomap_of_the_example_is_written_as_read():
    text = (ROOT / "docs" / "examples" / "table.bt").read_bytes()
    assert binary_octomap(octree_of(parse_octomap(text).voxels())) == text


MANY_PAGE = "docs/many-paths.md"


def test_the_program_of_many_paths_runs() -> None:
    [program] = blocks(MANY_PAGE, "python")
    ended = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env=os.environ,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (ended.returncode, ended.stderr) == (0, "")


def test_the_relative_error_of_costs_is_as_stated() -> None:
    assert "to less than 0.01 %" in text_of(MANY_PAGE)
    assert RELATIVE_ERROR < 1e-4


def test_a_robot_file_tunes_its_planner_as_described() -> None:
    file = [json.loads(block) for block in blocks("docs/planning.md", "json")][-1]
    graph = Graph()
    layers = build_layers(walled_map(4, 3, []))
    named = {"base_global_planner": file["base_global_planner"], "parameters": file["parameters"]}
    build_clone(graph, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), **named)
    assert graph.nodes["move_base"]._paths.services._planner("navfn").use_astar  # type: ignore[attr-defined]


def test_the_limits_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(MANY_PAGE))
    assert f"at most {MAX_COSTS} costs, from up to {MAX_ENDS} starts to up to {MAX_ENDS} goals" in text
    assert CostFile.model_fields["starts"].metadata[0].max_length == MAX_ENDS


@pytest.mark.journey
def test_a_cloud_returns_costs_as_described(cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(MANY_PAGE)}", tmp_path, cloud)
    matrix = json.loads(printed[printed.rindex('{"costs"') :])
    assert [len(row) for row in matrix["costs"]] == [2, 2]
    assert all(cost > 0.0 for row in matrix["costs"] for cost in row)
    assert matrix["map"] == "office"
