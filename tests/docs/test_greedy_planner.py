"""The example of a custom planner can be installed like any distribution, and plans."""

import json
import subprocess
import sys

import pytest

from ppaas.errors import NotFound
from ppaas.planners import create
from robots import cli
from tests.support.installed_packages import install
from tests.support.sources import ROOT

PACKAGE = ROOT / "docs" / "examples" / "greedy_planner"
MAP = ROOT / "docs" / "examples" / "office.yaml"

PLAN_IN_THE_OPEN = """
import json, sys
import numpy as np
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.planners import PlanRequest, create, planner_names
from ppaas.planners.registry import PLANNERS

planner = create("greedy", caution=2)
result = planner.plan(Costmap(np.zeros((50, 50), np.uint8), GridInfo(1.0, 50, 50)),
                      PlanRequest(Pose2D(5.5, 5.5), Pose2D(45.5, 25.5)))
try:
    create("greedy", caution="much")
except Exception as error:
    refused = f"{error.slug}: {error}"
print(json.dumps([planner_names(), planner.caution, result.planner, result.cost, result.expanded, refused]))
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Install the package into its own folder; return an environment in which Python finds it."""
    return install(tmp_path_factory.mktemp("greedy"), PACKAGE)


def run(environment: dict[str, str], *command: str) -> str:
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_planner_is_created_by_name_with_parameters_and_plans(installed: dict[str, str]) -> None:
    names, caution, planner, cost, expanded, refused = json.loads(
        run(installed, sys.executable, "-c", PLAN_IN_THE_OPEN)
    )
    assert {"greedy", "dijkstra"} <= set(names)
    assert (caution, planner) == (2.0, "greedy")
    assert cost == pytest.approx(50.0 * (20 * 2**0.5 + 20))
    assert expanded < 500
    assert refused == "invalid-parameter: parameter 'caution' of planner 'greedy': Expected `float`, got `str`"


def test_the_command_line_plans_with_it(installed: dict[str, str]) -> None:
    ppaas = [
        sys.executable,
        "-m",
        cli.__name__,
        "plan",
        str(MAP),
        "--start",
        "2",
        "2",
        "--goal",
        "10",
        "8",
        "--json",
    ]
    answer = json.loads(run(installed, *ppaas, "--planner", "greedy"))
    assert answer["planner"] == "greedy"
    assert answer["poses"][-1][:2] == [10.0, 8.0]


def test_the_planner_is_unknown_if_not_installed() -> None:
    with pytest.raises(NotFound, match="unknown planner 'greedy'"):
        create("greedy")
