"""Body of a robot from model, URDF and parameters."""

import json
import math

import pytest

from ppaas.clone.assembly import build_clone
from ppaas.clone.outline_planning import planner_of
from ppaas.clone.robot_body import robot_body, robot_heights
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidParameter, NotFound
from ppaas.messages.base.rosapi import GetParamRequest
from ppaas.nodes.graph import Graph
from ppaas.robot_model.describe import describe
from ppaas.robot_model.known_models import robot_model
from tests.support.world.planar_world import walled_map
from tests.support.world.urdf import box, cylinder, example, joint, link, origin, part, urdf

LONG = describe(urdf(link("base_link", part(box(0.8, 0.3, 0.5), origin((0.1, 0, 0))))))
WAFFLE = describe(example("turtlebot3_waffle"))
LAYERS = build_layers(walled_map(4, 3, []))


def in_use(**options) -> dict:
    graph, answers = Graph(), []
    build_clone(graph, LAYERS, **{"model": "turtlebot2", "initial_pose": (1.0, 1.0, 0.0)} | options)
    graph.call("rosapi/get_param", GetParamRequest("/"), answers.append)
    return json.loads(answers[0].value)


def test_robot_without_a_urdf_has_the_body_of_its_model():
    assert robot_body("turtlebot3_waffle") == robot_model("turtlebot3_waffle")
    with pytest.raises(NotFound, match="turtlebot2"):
        robot_body("roomba", LONG)


def test_urdf_takes_precedence_over_the_model():
    body = robot_body("turtlebot2", LONG)
    assert body.robot_radius == pytest.approx(math.hypot(0.5, 0.15), abs=1.1e-3)
    assert (body.footprint, body.height) == (LONG.footprint, 0.5)
    assert (body.limits, body.laser, body.laser_frame) == (robot_model("turtlebot2").limits, (0, 0, 0), "base_scan")


def test_wheels_of_the_urdf_set_speed_limits_up_to_the_models():
    limits = robot_body("turtlebot2", WAFFLE).limits
    assert (limits.max_vel_x, limits.max_vel_theta) == (pytest.approx(0.26, abs=1e-3), 1.8)
    assert robot_body("turtlebot3_burger", WAFFLE).limits.max_vel_theta == pytest.approx(1.806, abs=1e-3)
    assert limits.acc_lim_x == robot_model("turtlebot2").limits.acc_lim_x


def test_wheels_of_the_urdf_do_not_make_a_robot_faster_than_its_model():
    """Placeholders such as velocity="100" are in many files, and no planner of ROS reads them."""
    wheels = [
        link(name, part(cylinder(0.1, 0.02)))
        + joint(name, "base_link", "continuous", origin((0, y, 0), (math.pi / 2, 0, 0)), '<axis xyz="0 0 1"/>',
                '<limit effort="1" velocity="100"/>')
        for name, y in (("left", 0.2), ("right", -0.2))
    ]  # fmt: skip
    fast = describe(urdf(link("base_link", part(box(0.4, 0.4, 0.2))), *wheels))
    assert fast.max_vel_x == pytest.approx(10.0)
    assert robot_body("turtlebot2", fast).limits == robot_model("turtlebot2").limits
    assert in_use(urdf=fast, parameters={"dwa": {"max_vel_x": 1.5}})["dwa"]["max_vel_x"] == 1.5


def test_most_level_laser_is_the_laser_of_the_body():
    mounts = (("upright", math.pi / 2), ("hanging", math.pi), ("level", 0.0))
    turned = [
        link(f"laser_{name}") + joint(f"laser_{name}", "base_link", "fixed", origin((0.1, 0, 0), (roll, 0, 0)))
        for name, roll in mounts
    ]
    body = robot_body("turtlebot2", describe(urdf(link("base_link", part(box(0.4, 0.4, 0.2))), *turned)))
    assert body.laser_frame == "laser_hanging"


def test_laser_pose_is_taken_from_the_urdf():
    assert robot_body("turtlebot2", WAFFLE).laser == pytest.approx((-0.064, 0.0, 0.0))


def test_parameters_take_precedence_over_the_urdf():
    square = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]
    body = robot_body("turtlebot2", LONG, {"global_costmap": {"footprint": square}})
    assert (body.robot_radius, body.footprint) == (0.283, tuple(map(tuple, square)))
    assert robot_body("turtlebot2", LONG, {"global_costmap": {"robot_radius": 0.2}}).robot_radius == 0.2
    both = robot_body("turtlebot2", LONG, {"global_costmap": {"robot_radius": 0.2, "footprint": square}})
    assert (both.robot_radius, both.footprint) == (0.2, tuple(map(tuple, square)))


@pytest.mark.parametrize(
    "parameters",
    [
        {"robot_radius": -0.1}, {"robot_radius": 100.0}, {"robot_radius": "wide"}, {"robot_radius": math.nan},
        {"footprint": [[0, 0], [1, 0]]}, {"footprint": [[0, 0], [1, 0], [math.inf, 1]]},
        {"footprint": [[0, 0, 0]] * 3}, {"footprint": [[0, 1], [1, 0], [1e9, 1]]}, {"radius": 1.0}, [],
    ],
)  # fmt: skip
def test_invalid_radius_or_footprint_is_refused(parameters):
    with pytest.raises(InvalidParameter):
        robot_body("turtlebot2", LONG, {"global_costmap": parameters})


def test_lattice_planner_takes_the_footprint_of_the_body():
    body = robot_body("turtlebot2", LONG)
    assert planner_of(body, "lattice", {}).parameters.footprint == LONG.footprint
    own = [[0, 0], [1, 0], [0, 1]]
    assert planner_of(body, "lattice", {"footprint": own}).parameters.footprint == tuple(map(tuple, own))
    assert planner_of(robot_body("turtlebot2"), "lattice", {}).parameters.footprint == ()
    assert planner_of(body, "dijkstra", {}).name == "dijkstra"


def test_clone_uses_urdf_values_unless_parameters_override_them():
    values = in_use(urdf=WAFFLE)
    assert values["dwa"]["max_vel_x"] == pytest.approx(0.26, abs=1e-3)
    assert values["dwa"]["robot_radius"] == values["global_costmap"]["robot_radius"] == 0.238
    assert len(values["global_costmap"]["footprint"]) == 8
    slower = in_use(urdf=WAFFLE, parameters={"dwa": {"max_vel_x": 0.2}, "global_costmap": {"robot_radius": 0.25}})
    assert (slower["dwa"]["max_vel_x"], slower["dwa"]["robot_radius"]) == (0.2, 0.25)
    assert (in_use()["global_costmap"]["robot_radius"], in_use()["global_costmap"]["footprint"]) == (0.18, [])


@pytest.mark.parametrize(
    ("parameters", "heights"),
    [
        ({}, (None, 0.5)),
        ({"max_obstacle_height": 1.2}, (None, 1.2)),
        ({"min_obstacle_height": 0.02}, (0.02, 0.5)),
        ({"min_obstacle_height": -0.5, "max_obstacle_height": 0.1}, (-0.5, 0.1)),
        ({"enabled": False, "max_obstacle_height": 1.2}, None),
    ],
)
def test_obstacle_heights_reach_the_body_height_unless_set(parameters, heights):
    assert robot_heights(robot_body("turtlebot2", LONG), {"voxel_layer": parameters, "dwa": {}}) == heights


def test_height_of_the_model_is_used_if_the_urdf_has_none():
    flat = describe(urdf(link("base_link", "")))
    assert flat.height is None
    assert robot_heights(robot_body("turtlebot3_burger", flat), {}) == (None, 0.192)


@pytest.mark.parametrize(
    ("parameters", "why"),
    [
        ({"min_obstacle_height": 1.0, "max_obstacle_height": 1.0}, "above 1 m, not 1"),
        ({"max_obstacle_height": 0.0}, "above 0 m, not 0"),
        ({"min_obstacle_height": math.nan}, "min_obstacle_height must be finite"),
        ({"max_obstacle_height": math.inf}, "max_obstacle_height must be finite"),
        ({"height": 1.0}, "known: enabled, max_obstacle_height, min_obstacle_height"),
    ],
)
def test_invalid_heights_are_refused_by_name(parameters, why):
    with pytest.raises(InvalidParameter, match=why):
        robot_heights(robot_body("turtlebot2"), {"voxel_layer": parameters})


def test_lowest_obstacle_height_above_the_robot_is_refused():
    with pytest.raises(InvalidParameter, match=r"above 0\.6 m, not 0\.5"):
        in_use(urdf=LONG, parameters={"voxel_layer": {"min_obstacle_height": 0.6}})
    assert in_use(urdf=LONG)["voxel_layer"]["max_obstacle_height"] == 0.5
