"""Offline planning gives the same paths as a clone, for the given robot."""

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, InvalidMap, InvalidParameter, NotFound, PlanningError
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.formats.map_yaml import Rules
from ppaas.robot_model.known_models import robot_model
from robots.plans import offline
from tests.support.sources import ROOT
from tests.support.world.urdf import box, example, link, part, urdf

OFFICE = ROOT / "docs" / "examples" / "office.yaml"


def test_the_costmap_equals_that_of_a_clone():
    grid = load_map(OFFICE.read_bytes(), OFFICE.with_suffix(".pgm").read_bytes())
    radius = offline.PlannedRobot().radius_of()
    assert radius == robot_model("turtlebot2").robot_radius
    assert np.array_equal(
        offline.costmap_of_file(OFFICE, radius).data, build_layers(grid, robot_radius=radius).costmap.data
    )


def test_a_map_may_be_given_by_its_image_or_by_a_file_of_movingai(tmp_path):
    assert np.array_equal(
        offline.costmap_of_file(OFFICE.with_suffix(".pgm"), 0.1).data, offline.costmap_of_file(OFFICE, 0.1).data
    )
    (tmp_path / "tiny.map").write_bytes(b"type octile\nheight 1\nwidth 3\nmap\n..@\n")
    assert offline.costmap_of_file(tmp_path / "tiny.map", 0.1).data.tolist() == [[0, 0, 254]]


def test_the_occupancy_rules_are_configurable(tmp_path):
    (tmp_path / "a.yaml").write_bytes(b"image: a.pgm\nresolution: 1.0\norigin: [0, 0, 0]\n")
    (tmp_path / "a.pgm").write_bytes(b"P2 1 1 255 254")
    assert offline.costmap_of_file(tmp_path / "a.yaml", 0.1).data.tolist() == [[0]]
    with pytest.raises(InvalidMap, match="Nav2"):
        offline.costmap_of_file(tmp_path / "a.yaml", 0.1, Rules.NAV2)


def test_the_radius_overrides_the_model():
    assert offline.PlannedRobot("turtlebot3_burger").radius_of() == 0.105
    assert offline.PlannedRobot("turtlebot3_burger", 0.3).radius_of() == 0.3


@pytest.mark.parametrize("radius", [-0.1, 100.0, float("nan"), float("inf")])
def test_an_invalid_radius_is_refused(radius):
    with pytest.raises(InvalidParameter, match="robot_radius must be"):
        offline.PlannedRobot(radius=radius).radius_of()


@pytest.mark.parametrize("planner", ["dijkstra", "astar", "global_planner/GlobalPlanner"])
def test_an_answer_has_the_fields_of_the_cloud(planner):
    result = offline.plan(offline.costmap_of_file(OFFICE, 0.18), Pose2D(2, 2), Pose2D(10, 8, 1.5), planner, 0.0)
    answer = offline.answer_of(result)
    assert answer["length"] == pytest.approx(12.52, abs=0.01)
    assert answer["poses"][0][:2] == [2, 2]
    assert answer["poses"][-1][:2] == [10, 8]
    assert len(answer["poses"][0]) == 7
    assert set(answer) == {"planner", "length", "cost", "expanded", "seconds", "poses"}


def test_an_unknown_planner_is_reported_with_the_known_ones():
    with pytest.raises(NotFound, match=r"unknown planner 'teleport'; known: astar.*dijkstra"):
        offline.plan(offline.costmap_of_file(OFFICE, 0.18), Pose2D(2, 2), Pose2D(10, 8), "teleport", 0.0)


def test_a_urdf_overrides_the_model_and_a_radius_overrides_both():
    robot = offline.PlannedRobot(urdf=example("turtlebot3_waffle"))
    assert (robot.radius_of(), robot.body().height) == (0.238, pytest.approx(0.148, abs=1e-3))
    assert offline.PlannedRobot(radius=0.1, urdf=example("turtlebot3_waffle")).radius_of() == 0.1


def test_a_urdf_without_a_footprint_is_refused():
    mesh = urdf(link("base_link", part('<mesh filename="arm.stl"/>')))
    with pytest.raises(InvalidInput, match=r"no footprint: link 'base_link': the extent of mesh 'arm\.stl' is unknown"):
        offline.PlannedRobot(urdf=mesh).radius_of()
    assert offline.PlannedRobot(radius=0.1, urdf=mesh).radius_of() == 0.1


def test_planners_use_the_outline_of_the_urdf():
    slim = urdf(link("base_link", part(box(2.0, 0.2, 0.2))))
    costmap = offline.costmap_of_file(OFFICE, 0.18)
    ends = Pose2D(2, 2), Pose2D(10, 8)
    assert offline.plan(costmap, *ends, "dijkstra", 0.0, robot=offline.PlannedRobot(urdf=slim)).length > 12.0
    standing = offline.PlannedRobot(radius=0.18, urdf=urdf(link("base_link", part(box(12.0, 0.2, 0.2)))))
    with pytest.raises(PlanningError):
        offline.plan(costmap, *ends, "lattice", 0.0, robot=standing)
