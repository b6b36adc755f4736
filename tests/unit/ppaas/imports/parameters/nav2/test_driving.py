"""Robots with translated files drive in the simulator: an example of ours, and files as people have them."""

import math
from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import robot_file
from ppaas.imports.parameters.nav2.importer import import_nav2
from ppaas.imports.report import ImportOutcome
from ppaas.messages.actionlib_msgs import Status
from tests.support.sources import ROOT
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import walled_map
from tests.support.world.simulated_world import SimulatedWorld

EXAMPLES = ROOT / "docs" / "examples"
WALL = [(2.4, 0.0, 2.6, 1.2)]
START, GOAL = Pose2D(1.0, 0.8, math.pi / 2), Pose2D(3.4, 0.8, 0.0)


def drive(content: bytes, name: str, tree: bytes | None = None) -> ClosedLoop:
    """Translate a file, and let a robot with it drive around the end of a wall."""
    translation = import_nav2(content, name, tree=tree)
    file = robot_file([translation], {"map": "room"}, refusal)
    assert not list(translation[1].of(ImportOutcome.REFUSED))
    assert refusal(file) is None
    del file["map"]
    driving = ClosedLoop(SimulatedWorld(walled_map(4.5, 3.5, WALL), START), **file)
    driving.run(1.0)
    driving.send_goal(GOAL)
    driving.run(60.0)
    return driving


def test_the_example_drives_to_its_goal_within_its_limits() -> None:
    driving = drive((EXAMPLES / "nav2_turtlebot4.yaml").read_bytes(), "nav2_turtlebot4.yaml")
    assert driving.results[-1].status.status == Status.SUCCEEDED
    assert driving.world.pose.distance_to(GOAL) < 0.3
    speeds = [command.linear.x for command in driving.commands]
    assert 0.2 < max(speeds) <= 0.26  # by the velocity smoother


@pytest.mark.parametrize("name", ["tb4_nav2.yaml", "nav2_params.yaml"])
def test_files_as_people_have_them_drive(data: Path, name: str) -> None:
    driving = drive((data / "foreign" / name).read_bytes(), name, (EXAMPLES / "nav2_navigate.xml").read_bytes())
    assert driving.results[-1].status.status == Status.SUCCEEDED
    assert driving.world.pose.distance_to(GOAL) < 0.6  # the tolerances of both files are 0.25 m, and 0.5 m of plans
    assert driving.world.touched == 0
