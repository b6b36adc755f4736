"""Descriptions of robots from their URDF."""

import math

import pytest

from ppaas.errors import NotFound
from ppaas.robot_model.describe import MAX_FRAMES, describe
from ppaas.robot_model.known_models import model_names, robot_model
from ppaas.transforms.spatial import Rigid
from tests.support.world import urdf
from tests.support.world.urdf import box, cylinder, example, joint, link, origin, part, sphere

WHEEL = part(cylinder(0.05, 0.02))
FORK = link("fork") + joint("fork", "base_link", "revolute", '<axis xyz="0 0 1"/>')
TO_THE_SIDE = (-math.pi / 2, 0, 0)


def wheel(name: str, y: float, *inside: str, velocity: float = 10.0, parent: str = "base_link") -> str:
    limit = f'<limit effort="1" velocity="{velocity}"/>'
    turned = origin((0, y, 0), TO_THE_SIDE)
    return link(name, WHEEL) + joint(name, parent, "continuous", turned, '<axis xyz="0 0 1"/>', limit, *inside)


@pytest.mark.parametrize("name", ["turtlebot2", "turtlebot3_burger", "turtlebot3_waffle"])
def test_example_robots_resemble_the_models_of_their_names(name):
    description, model = describe(example(name)), robot_model(name)
    assert (description.name, description.base_frame, description.warnings) == (name, "base_footprint", ())
    assert description.circumscribed_radius == pytest.approx(model.robot_radius, abs=0.02)
    assert description.max_vel_x == pytest.approx(model.limits.max_vel_x, rel=0.01)
    assert description.max_vel_theta >= 0.99 * model.limits.max_vel_theta
    laser = next(sensor for sensor in description.sensors if sensor.kind == "laser")
    assert laser.link == model.laser_frame
    assert laser.pose[:2] == pytest.approx(model.laser[:2])


def test_a_box_has_its_own_four_corners_and_two_radii():
    description = describe(urdf.urdf(link("base_link", part(box(0.6, 0.4, 0.2), origin((0.1, 0, 0.3))))))
    assert description.footprint == ((-0.2, -0.2), (0.4, -0.2), (0.4, 0.2), (-0.2, 0.2))
    assert (description.inscribed_radius, description.circumscribed_radius) == (pytest.approx(0.2), 0.448)
    assert description.height == pytest.approx(0.2)
    assert (description.max_vel_x, description.max_vel_theta, description.sensors) == (None, None, ())


def test_the_ground_is_at_the_base_footprint():
    description = describe(
        urdf.urdf(
            link("base_link", part(box(0.2, 0.2, 0.2), origin((0, 0, 0.1)))),
            link("base_footprint"),
            joint("base_link", "base_footprint", "fixed", origin((0, 0, 0.05))),
        )
    )
    assert (description.base_frame, description.height) == ("base_footprint", pytest.approx(0.25))


def test_a_robot_beside_its_frame_has_no_inscribed_disc():
    description = describe(urdf.urdf(link("base_link", part(sphere(0.1), origin((1.0, 0, 0))))))
    assert (description.inscribed_radius, description.circumscribed_radius) == (0.0, pytest.approx(1.1, abs=2e-3))


def test_a_mesh_counts_as_its_bounding_box():
    mesh = '<mesh filename="package://r/base.stl" scale="0.001 -0.001 0.001" bounding_box="-100 -50 0 300 150 80"/>'
    description = describe(urdf.urdf(link("base_link", part(mesh))))
    assert description.footprint == ((-0.1, -0.15), (0.3, -0.15), (0.3, 0.05), (-0.1, 0.05))
    assert (description.height, description.warnings) == (pytest.approx(0.08), ())


def test_a_robot_with_a_mesh_of_unknown_extent_has_no_footprint():
    mesh = part('<mesh filename="package://r/arm.dae"/>')
    description = describe(urdf.urdf(link("base_link", part(box(0.2, 0.2, 0.2)), mesh), wheel("w", 0.2)))
    assert (
        description.footprint,
        description.circumscribed_radius,
        description.inscribed_radius,
        description.height,
    ) == ((), None, None, None)
    assert len(description.warnings) == 1
    assert "link 'base_link': the extent of mesh 'package://r/arm.dae' is unknown" in description.warnings[0]
    assert description.max_vel_x == pytest.approx(0.5)


def test_visual_shapes_are_used_without_collision_shapes():
    description = describe(urdf.urdf(link("base_link", part(box(0.2, 0.2, 0.2), kind="visual"))))
    assert description.circumscribed_radius == 0.142
    assert description.warnings == ("no link has a <collision>: <visual> shapes are used",)
    assert describe(urdf.urdf(link("base_link"))).warnings == (
        "no link has a <collision>: footprint and height are unknown",
    )


def test_wheels_limit_the_speed_and_the_turning_speed():
    description = describe(urdf.urdf(link("base_link"), wheel("left", 0.25), wheel("right", -0.25, velocity=8.0)))
    assert (description.max_vel_x, description.max_vel_theta) == (pytest.approx(0.4), pytest.approx(1.6))


@pytest.mark.parametrize(
    ("others", "speed", "turn"),
    [
        ((), 0.5, None),
        ((wheel("right", -0.25, velocity=0.0),), 0.5, None),
        ((FORK, wheel("f", -0.2, parent="fork")), 0.5, None),
        ((wheel("caster", -0.25).replace("continuous", "fixed"),), 0.5, None),
        ((wheel("right", -0.25), wheel("middle", 0.0)), 0.5, 2.0),
    ],
    ids=["one side", "driven on one side", "steers", "skids", "six-wheeled"],
)  # fmt: skip
def test_limits_that_wheels_do_not_determine_are_unknown(others, speed, turn):
    description = describe(urdf.urdf(link("base_link"), wheel("left", 0.25), *others))
    assert description.max_vel_x == pytest.approx(speed)
    assert description.max_vel_theta == (turn if turn is None else pytest.approx(turn))


def test_other_turning_parts_do_not_limit_the_speed():
    limit = '<limit velocity="3"/>'
    lidar = link("mast", part(cylinder(0.05, 0.02))) + joint(
        "mast", "base_link", "continuous", '<axis xyz="0 0 1"/>', limit
    )
    arm = link("arm", part(cylinder(0.05, 1.0))) + joint("arm", "base_link", "revolute", '<axis xyz="0 1 0"/>', limit)
    assert describe(urdf.urdf(link("base_link"), lidar, arm)).max_vel_x is None


def test_sensors_are_found_by_name_and_by_tag_which_takes_precedence():
    description = describe(
        urdf.urdf(
            link("base_link"),
            *(link(name) + joint(name, "base_link", "fixed", origin((0.1, 0, 0.2), (0, 0, 1.5)))
              for name in ("front_laser", "rplidar", "scan_link", "scandinavian", "head_camera", "camera_depth_frame",
                           "eye", "imu_link", "gps")),
            '<gazebo reference="eye"><sensor type="gpu_ray" name="x"/></gazebo>',
            '<gazebo reference="rplidar"><sensor type="depth_camera"/></gazebo>',
            '<gazebo reference="nowhere"><sensor type="ray"/></gazebo>',
            '<sensor name="i"><parent link="imu_link"/><imu/></sensor>',
            '<sensor name="g" type="gps"><parent link="gps"/></sensor>',
        )
    )  # fmt: skip
    assert {sensor.link: sensor.kind for sensor in description.sensors} == {
        "front_laser": "laser", "rplidar": "depth", "scan_link": "laser", "head_camera": "camera",
        "camera_depth_frame": "depth", "eye": "laser", "imu_link": "other", "gps": "gps",
    }  # fmt: skip
    assert description.sensors[0].pose == pytest.approx((0.1, 0, 0.2, 0, 0, 1.5))


@pytest.mark.parametrize(
    ("rpy", "said"),
    [
        ((0, 0, 1), None), ((math.pi, 0, 0), None), ((0, math.pi, 0), None), ((0.1, 0.1, 0), None),
        ((0.4, 0, 0), "tilted by 23°: its beams are projected"), ((math.pi + 0.4, 0, 0), "tilted by 23°"),
        ((math.pi / 2, 0, 0), "tilted by 90°: its scans are refused"),
    ],
)  # fmt: skip
def test_only_a_laser_that_sees_few_walls_causes_a_warning(rpy, said):
    """Lasers upside down are mirrored, and those that are a little tilted are projected: both are usual."""
    mounted = joint("laser", "base_link", "fixed", origin((0, 0, 0.2), rpy))
    description = describe(urdf.urdf(link("base_link", part(sphere(0.1))), link("laser"), mounted))
    assert [said in warning for warning in description.warnings] == ([] if said is None else [True])


def test_warnings_of_what_gets_a_robot_lost_come_first_and_meshes_share_one():
    meshes = [part(f'<mesh filename="package://r/{number}.stl"/>') for number in range(12)]
    mounted = joint("laser", "base_link", "fixed", origin((0, 0, 0.2), (1.0, 0, 0)))
    first, second = describe(urdf.urdf(link("base_link", *meshes), link("laser"), mounted)).warnings
    assert "'laser' is tilted by 57°" in first
    assert "mesh 'package://r/0.stl' and of 11 more is unknown" in second


def test_wheel_limits_that_are_placeholders_cause_a_warning():
    fast = urdf.urdf(link("base_link", part(sphere(0.1))), wheel("left", 0.25, velocity=100.0))
    assert ["allows 5 m/s" in warning for warning in describe(fast).warnings] == [True]


def test_frames_are_the_links_that_do_not_move_and_the_sensors():
    description = describe(
        urdf.urdf(
            link("base_footprint"), link("base_link"),
            joint("base_link", "base_footprint", "fixed", origin((0, 0, 0.1))),
            link("mast"), joint("mast", "base_link", "fixed", origin((0.2, 0, 0))),
            link("sick"), joint("sick", "mast", "fixed", origin((0, 0, 0.3), (math.pi, 0, 0))),
            wheel("w", 0.2),
            link("head"), joint("head", "mast", "revolute", '<axis xyz="0 0 1"/>'),
            link("head_camera"), joint("head_camera", "head", "fixed", origin((0.1, 0, 0))),
        )
    )  # fmt: skip
    frames = dict(description.frames)
    assert set(frames) == {"base_footprint", "base_link", "mast", "sick", "head_camera"}
    assert frames["sick"][:3] == pytest.approx((0.2, 0, 0.4))
    assert (frames["sick"].tilt, frames["sick"].qx) == (pytest.approx(0.0, abs=1e-6), pytest.approx(1.0))
    assert frames["base_footprint"] == Rigid()


def test_number_of_frames_is_limited_and_sensors_come_first():
    many = [link(f"l{n}") + joint(f"l{n}", "base_link", "fixed") for n in range(300)]
    description = describe(urdf.urdf(link("base_link"), *many, link("laser"), joint("laser", "base_link", "fixed")))
    assert len(description.frames) == MAX_FRAMES
    assert [name for name, _ in description.frames[:3]] == ["base_link", "laser", "l0"]


def test_a_mimic_joint_is_at_its_offset():
    arm = part(box(1.0, 0.1, 0.1), origin((0.5, 0, 0)))
    follows = '<axis xyz="0 0 1"/><mimic joint="a_joint" multiplier="2" offset="{}"/>'
    description = describe(
        urdf.urdf(
            link("base_link", part(sphere(0.01))),
            link("a"), joint("a", "base_link", "revolute", '<axis xyz="0 0 1"/><mimic joint="c_joint" offset="0.5"/>'),
            link("b", arm), joint("b", "base_link", "revolute", follows.format(math.pi / 2 - 1.0)),
            link("c"), joint("c", "base_link", "prismatic", '<axis xyz="1 0 0"/>'),
        )
    )  # fmt: skip
    assert max(y for _, y in description.footprint) == pytest.approx(1.0, abs=1e-3)
    assert max(x for x, _ in description.footprint) == pytest.approx(0.05, abs=1e-3)


def test_numbers_are_plain_floats():
    description = describe(example("turtlebot2"))
    numbers = [
        description.height,
        description.max_vel_x,
        description.max_vel_theta,
        *description.footprint[0],
        *description.sensors[0].pose,
    ]
    assert {type(number) for number in numbers} == {float}


def test_turtlebot2_has_the_manufacturers_values():
    model = robot_model("turtlebot2")
    assert (model.robot_radius, model.limits.max_vel_x) == (0.18, 0.65)


def test_every_model_is_found_by_its_name():
    assert [robot_model(name).name for name in model_names()] == list(model_names())


def test_an_unknown_model_is_refused_with_the_known_ones():
    with pytest.raises(NotFound, match=r"unknown robot model 'roomba'; known: .*turtlebot2"):
        robot_model("roomba")
