"""Commands of many-paths.md work, and so does the tuning of a planner as in planning.md."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from endpoints.rest.plans.schemas import CostFile
from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.nodes.graph import Graph
from ppaas.nodes.planner_server.node import MAX_COSTS, MAX_ENDS
from ppaas.planners.weights import RELATIVE_ERROR
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, text_of
from tests.support.sources import ROOT
from tests.support.world.planar_world import walled_map

PAGE = "docs/many-paths.md"


def test_the_program_runs() -> None:
    [program] = blocks(PAGE, "python")
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
    assert "to less than 0.01 %" in text_of(PAGE)
    assert RELATIVE_ERROR < 1e-4


def test_a_robot_file_tunes_its_planner_as_described() -> None:
    file = [json.loads(block) for block in blocks("docs/planning.md", "json")][-1]
    graph = Graph()
    layers = build_layers(walled_map(4, 3, []))
    named = {"base_global_planner": file["base_global_planner"], "parameters": file["parameters"]}
    build_clone(graph, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), **named)
    assert graph.nodes["move_base"]._paths.services._planner("navfn").use_astar  # type: ignore[attr-defined]


def test_the_limits_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    assert f"at most {MAX_COSTS} costs, from up to {MAX_ENDS} starts to up to {MAX_ENDS} goals" in text
    assert CostFile.model_fields["starts"].metadata[0].max_length == MAX_ENDS


@pytest.mark.journey
def test_a_cloud_returns_costs_as_described(cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(PAGE)}", tmp_path, cloud)
    matrix = json.loads(printed[printed.rindex('{"costs"') :])
    assert [len(row) for row in matrix["costs"]] == [2, 2]
    assert all(cost > 0.0 for row in matrix["costs"] for cost in row)
    assert matrix["map"] == "office"
