"""The plan over REST of fleet.md works as described."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fleet.checking import faults_of
from endpoints.rest.plans import fleet_plans
from engine.control.planning.requests import DEFAULT_MARGIN, DEFAULT_SPEED
from ppaas.costmap.build_layers import build_layers
from ppaas.fleet.improvement import MOST_TURN
from ppaas.fleet.lattice_roadmap import MOST_PLACES, lattice_roadmap
from ppaas.fleet.metric_roadmap import MOST_DISTANCES, WITHIN
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.robot_sizes import RobotSizes, clearance_of
from ppaas.nodes.planner_server.fleet_service import MAX_PLACES, MAX_ROBOTS, MAX_SCHEDULE, MAX_SECONDS, MAX_TURN
from ppaas.plans.path_service import DEFAULT_TIMEOUT
from robots.plans.offline import read_map_file
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of
from tests.support.sources import ROOT

PAGE = "docs/fleet.md"
OFFICE = ROOT / "docs" / "examples" / "office.yaml"


def test_fields_and_limits_are_those_of_the_code() -> None:
    fields = dict(table(PAGE, "field", "meaning"))
    named = {name for names in fields for name in re.findall(r"\w+", names)}
    assert named == set(fleet_plans.FleetFile.model_fields)
    assert f"up to {MAX_ROBOTS:,};" in fields["`starts`, `goals`"]
    assert f"; {DEFAULT_MARGIN:g} without it" in fields["margin"]
    assert f"; {DEFAULT_SPEED:g} without it" in fields["speed"]
    assert f"at most {MAX_SECONDS:g} s; 0 without it" in fields["seconds"]
    assert f"at most {MAX_TURN:,.0f}; 0 without it" in fields["turn_seconds"]
    assert f"at most {MOST_TURN:g}; prints" in dict(table(PAGE, "option", "meaning"))["--turn STEPS"]
    assert f"{DEFAULT_TIMEOUT:g} s without it" in fields["`timeout`, `labels`"]
    text = re.sub(r"\s+", " ", text_of(PAGE))
    assert f"Robots times cells may be {MOST_DISTANCES // 1_000_000} million" in text
    assert (MAX_PLACES, WITHIN) == (1_000_000, 0.75)
    assert f"a map may have {MOST_PLACES:,} cells" in text
    assert f"more than {MAX_SCHEDULE // 1_000_000} million" in text
    assert f"as near as {math.sqrt(0.5):.2f} · `spacing`" in text


def test_the_example_has_the_fields_of_the_answer() -> None:
    [example] = [block for block in map(json.loads, blocks(PAGE, "json")) if "spacing" in block]
    assert set(example) == set(fleet_plans.FleetPlanAnswer.model_fields)


@pytest.mark.journey
def test_a_cloud_plans_for_a_fleet_as_described(cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    [commands] = blocks(PAGE, "sh")
    printed = run_shell(f"{login}\n{commands}", tmp_path, cloud)
    answer = json.loads(printed[printed.rindex('{"paths"') :])
    [example] = [block for block in map(json.loads, blocks(PAGE, "json")) if "spacing" in block]
    for name in ("spacing", "step_seconds", "cost", "bound", "makespan", "turns"):
        assert answer[name] == pytest.approx(example[name])
    assert answer["map"] == "office"
    assert [path[:2] for path in answer["paths"]] == example["paths"]
    assert [times[:2] for times in answer["times"]] == example["times"]
    assert [len(times) for times in answer["times"]] == [len(path) for path in answer["paths"]]
    layers = build_layers(read_map_file(OFFICE))
    metric = lattice_roadmap(clearance_of(layers), layers.grid.info, RobotSizes(0.18, 0.05))
    steps = np.array([[metric.nearest(*place, 0.01) for place in path] for path in answer["paths"]], np.int32).T
    ends = [
        [metric.nearest(*place, 0.75 * metric.spacing) for place in places]
        for places in (((2, 2), (10, 8)), ((10, 2), (2, 8)))
    ]
    assert faults_of(metric.roadmap, FleetPlan(steps, answer["bound"]), *ends) == []
