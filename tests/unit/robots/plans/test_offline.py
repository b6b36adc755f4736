"""Offline planning gives the same paths as a clone, for the given robot."""

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, InvalidMap, InvalidParameter, NotFound, NoValidPath, PlanningError
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.formats.map_yaml import Rules
from ppaas.planners.volume import Pose3D
from ppaas.robot_model.known_models import robot_model
from robots.plans import offline, space
from tests.support.sources import ROOT
from tests.support.world.urdf import box, example, link, part, urdf

OFFICE = ROOT / "docs" / "examples" / "office.yaml"
ROBOT = offline.PlannedRobot(radius=0.18)


def test_the_costmap_equals_that_of_a_clone():
    grid = load_map(OFFICE.read_bytes(), OFFICE.with_suffix(".pgm").read_bytes())
    radius = offline.PlannedRobot().radius_of()
    assert radius == robot_model("turtlebot2").robot_radius
    assert np.array_equal(
        offline.costmap_for(OFFICE, offline.PlannedRobot()).data,
        build_layers(grid, robot_radius=radius).costmap.data,
    )


def test_a_round_robot_needs_only_its_radius():
    assert np.array_equal(offline.costmap_of_file(OFFICE, 0.18).data, offline.costmap_for(OFFICE, ROBOT).data)


def test_a_map_may_be_given_by_its_image_or_by_a_file_of_movingai(tmp_path):
    assert np.array_equal(
        offline.costmap_for(OFFICE.with_suffix(".pgm"), ROBOT).data, offline.costmap_for(OFFICE, ROBOT).data
    )
    (tmp_path / "tiny.map").write_bytes(b"type octile\nheight 1\nwidth 3\nmap\n..@\n")
    assert offline.costmap_for(tmp_path / "tiny.map", ROBOT).data.tolist() == [[0, 0, 254]]


def test_the_occupancy_rules_are_configurable(tmp_path):
    (tmp_path / "a.yaml").write_bytes(b"image: a.pgm\nresolution: 1.0\norigin: [0, 0, 0]\n")
    (tmp_path / "a.pgm").write_bytes(b"P2 1 1 255 254")
    assert offline.costmap_for(tmp_path / "a.yaml", ROBOT).data.tolist() == [[0]]
    with pytest.raises(InvalidMap, match="Nav2"):
        offline.costmap_for(tmp_path / "a.yaml", ROBOT, Rules.NAV2)


def test_the_radius_overrides_the_model():
    assert offline.PlannedRobot("turtlebot3_burger").radius_of() == 0.105
    assert offline.PlannedRobot("turtlebot3_burger", 0.3).radius_of() == 0.3


@pytest.mark.parametrize("radius", [-0.1, 100.0, float("nan"), float("inf")])
def test_an_invalid_radius_is_refused(radius):
    with pytest.raises(InvalidParameter, match="robot_radius must be"):
        offline.PlannedRobot(radius=radius).radius_of()


def test_parameters_of_costmap_and_planner_apply(tmp_path):
    (tmp_path / "a.yaml").write_bytes(b"image: a.pgm\nresolution: 1.0\norigin: [0, 0, 0]\n")
    (tmp_path / "a.pgm").write_bytes(b"P2 5 1 255 254 254 205 254 254")
    ends = Pose2D(0.5, 0.5), Pose2D(4.5, 0.5)
    careful = offline.PlannedRobot(parameters={"allow_unknown": False, "inflation_radius": 0.3, "robot_radius": 0.1})
    costmap = offline.costmap_for(tmp_path / "a.yaml", careful)
    assert offline.plan(costmap, *ends, "dijkstra", 0.0).length == 4.0
    with pytest.raises(NoValidPath):
        offline.plan(costmap, *ends, "dijkstra", 0.0, robot=careful)
    assert (careful.radius_of(), careful.costs().inflation_radius, careful.allows_unknown()) == (0.1, 0.3, False)
    assert offline.PlannedRobot(radius=0.2, parameters={"robot_radius": 0.1}).radius_of() == 0.2


@pytest.mark.parametrize("planner", ["dijkstra", "astar", "global_planner/GlobalPlanner"])
def test_an_answer_has_the_fields_of_the_cloud(planner):
    result = offline.plan(offline.costmap_for(OFFICE, ROBOT), Pose2D(2, 2), Pose2D(10, 8, 1.5), planner, 0.0)
    answer = offline.answer_of(result)
    assert answer["length"] == pytest.approx(12.52, abs=0.01)
    assert answer["poses"][0][:2] == [2, 2]
    assert answer["poses"][-1][:2] == [10, 8]
    assert len(answer["poses"][0]) == 7
    assert set(answer) == {"planner", "length", "cost", "expanded", "seconds", "poses"}


def test_an_unknown_planner_is_reported_with_the_known_ones():
    with pytest.raises(NotFound, match=r"unknown planner 'teleport'; known: astar.*dijkstra"):
        offline.plan(offline.costmap_for(OFFICE, ROBOT), Pose2D(2, 2), Pose2D(10, 8), "teleport", 0.0)


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
    costmap = offline.costmap_for(OFFICE, ROBOT)
    ends = Pose2D(2, 2), Pose2D(10, 8)
    assert offline.plan(costmap, *ends, "dijkstra", 0.0, robot=offline.PlannedRobot(urdf=slim)).length > 12.0
    standing = offline.PlannedRobot(radius=0.18, urdf=urdf(link("base_link", part(box(12.0, 0.2, 0.2)))))
    with pytest.raises(PlanningError):
        offline.plan(costmap, *ends, "lattice", 0.0, robot=standing)


TABLE = ROOT / "docs" / "examples" / "table.bt"
ACROSS = (Pose3D(0.5, 1.5, 0.0), Pose3D(3.5, 1.5, 0.0))


@pytest.mark.parametrize("planner", ["astar3d", "dijkstra3d"])
def test_the_body_decides_between_under_around_and_over_the_table(planner):
    bodies = space.SpaceBody(0.18), space.SpaceBody(0.18, 1.2), space.SpaceBody(0.18, 1.0, flies=True)
    under, around, over = (space.plan(space.costmap_of_file(TABLE, body), *ACROSS, planner, 0.0) for body in bodies)
    assert under.length < 3.1 < over.length < around.length
    assert under.poses[:, 2].max() == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(around.poses[:, 1]) > 0.9
    assert np.ptp(over.poses[:, 1]) < 0.6


def test_the_default_step_is_one_voxel():
    one, none = (space.costmap_of_file(TABLE, space.SpaceBody(0.1, step=step)) for step in (None, 0.0))
    assert np.flatnonzero((one.data == 0).any(axis=(1, 2))).tolist()[:2] == [1, 2]
    assert not (none.data[2] == 0).any()
    assert space.costmap_of_file(TABLE, space.SpaceBody(0.1), depth=15).info.resolution == 0.2


def test_invalid_maps_bodies_and_planners_are_refused(tmp_path):
    with pytest.raises(InvalidMap, match="No such file"):
        space.costmap_of_file(tmp_path / "none.bt", space.SpaceBody(0.1))
    with pytest.raises(InvalidInput):
        space.costmap_of_file(TABLE, space.SpaceBody(0.1, height=-1.0))
    with pytest.raises(NotFound, match="astar3d, dijkstra3d"):
        space.plan(space.costmap_of_file(TABLE, space.SpaceBody(0.1)), *ACROSS, "navfn", 0.0)
