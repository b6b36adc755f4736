"""Parameter files of amcl, of ROS 1 and of Nav2."""

import pytest

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import Translation, robot_file
from ppaas.imports.parameters.ros1.amcl import import_amcl
from tests.support.imported_parameters import entry_of, outcomes

ROS1 = b"""
use_map_topic: true
odom_model_type: omni
laser_max_beams: 40
odom_alpha1: 0.15
initial_pose_x: 2.5
initial_pose_a: 0.5
base_frame_id: /base_footprint
"""

NAV2 = b"""
amcl:
  ros__parameters:
    use_sim_time: true
    robot_model_type: "nav2_amcl::OmniMotionModel"
    alpha1: 0.15
    max_beams: 40
    pf_err: 0.04
    z_hit: 0.6
    set_initial_pose: true
    initial_pose: {x: 2.5, y: 0.0, z: 0.0, yaw: 0.5}
    random_seed: 7
    laser_model_type: likelihood_field_prob
"""


def imported(content: bytes) -> Translation:
    return import_amcl(content, "amcl.yaml")


def test_files_of_ros_1_have_the_names_of_our_node() -> None:
    draft, report = imported(ROS1)
    assert draft["parameters"]["amcl"] == {
        "odom_model_type": "omni", "laser_max_beams": 40, "odom_alpha1": 0.15, "base_frame_id": "base_footprint",
    }  # fmt: skip
    assert draft["initial_pose"] == [2.5, 0.0, 0.5]
    assert report.counts() == {"taken": 3, "translated": 3, "no effect": 1, "refused": 0}


def test_files_of_nav2_are_renamed() -> None:
    into = imported(NAV2)
    assert into[0]["parameters"]["amcl"] == {
        "odom_model_type": "omni-corrected", "odom_alpha1": 0.15, "laser_max_beams": 40, "kld_err": 0.04,
        "laser_z_hit": 0.6, "laser_model_type": "likelihood_field_prob", "seed": 7,
    }  # fmt: skip
    assert into[0]["initial_pose"] == [2.5, 0.0, 0.5]
    assert outcomes(into)["amcl.initial_pose.z"] == "no effect"


def test_a_node_of_nav2_may_have_another_name_and_starts_where_it_was_unless_the_file_says_so() -> None:
    into = imported(b"locator:\n  ros__parameters:\n    initial_pose: {x: 2.5}\n    alpha1: 0.3\n")
    assert into[0] == {"parameters": {"amcl": {"odom_alpha1": 0.3}}}
    assert outcomes(into) == {"locator.initial_pose.x": "no effect", "locator.alpha1": "translated"}


def test_values_that_the_clone_refuses_are_left_out_and_reported() -> None:
    into = imported(b"amcl: {max_particles: 0, min_particles: 20, laser_sigma_hit: .inf, kld_z: 0.98}")
    file = robot_file([into], {"map": "office"}, refusal)
    assert refusal(file) is None
    assert "min_particles must be from 1 to max_particles" in entry_of(into, "amcl.max_particles").text
    assert entry_of(into, "amcl.laser_sigma_hit").text == "it must be finite, not inf"
    assert file["parameters"]["amcl"]["kld_z"] == 0.98


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (b"odom_model_type: car", "one of diff, omni"),
        (b"laser_model_type: sonar", "one of likelihood_field"),
        (b"odom_frame_id: 3", "it must be text"),
        (b"initial_pose_x: here", "it must be a number"),
    ],
)
def test_values_that_mean_nothing_are_refused(line: bytes, words: str) -> None:
    (entry,) = imported(line)[1].entries
    assert (entry.outcome.value, entry.line) == ("refused", 1)
    assert words in entry.text


def test_a_file_that_is_no_mapping_is_an_error() -> None:
    with pytest.raises(InvalidParameter):
        imported(b"[1, 2]")
