"""Parameter files of slam_toolbox: mapping, lifelong mapping and localization."""

import pytest

from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import Translation, robot_file
from ppaas.imports.parameters.slam.slam_toolbox import import_slam_toolbox
from tests.support.imported_parameters import entry_of, outcomes, refused

COMMON = """
    odom_frame: odom
    base_frame: base_footprint
    resolution: 0.1
    max_laser_range: 8.0
    minimum_travel_distance: 0.0
    minimum_travel_heading: 0.4
    scan_buffer_size: 90
    solver_plugin: solver_plugins::CeresSolver
    use_scan_matching: true
    loop_match_minimum_chain_size: 10
"""


def imported(text: str, node: str = "slam_toolbox") -> Translation:
    return import_slam_toolbox(f"{node}:\n  ros__parameters:{COMMON}{text}".encode(), "slam.yaml", "hall")


def test_a_robot_that_maps_gets_a_new_map() -> None:
    draft, report = imported("    mode: mapping\n    map_update_interval: 2.0\n")
    assert draft["map"] == "new:hall"
    assert draft["parameters"]["grid_slam"] == {
        "mode": "mapping", "odom_frame": "odom", "base_frame": "base_footprint", "resolution": 0.1,
        "max_laser_range": 8.0, "minimum_travel_distance": 0.05, "minimum_travel_heading": 0.4, "scan_buffer_size": 64,
        "map_update_interval": 2.0,
    }  # fmt: skip
    assert report.counts() == {"taken": 6, "translated": 3, "no effect": 3, "refused": 0}


def test_entries_are_in_the_order_of_the_file() -> None:
    lines = [entry.line for entry in imported("    mode: mapping\n")[1].entries]
    assert lines == sorted(lines)


def test_a_distance_of_zero_becomes_the_least_one_with_its_reason() -> None:
    entry = entry_of(imported(""), "slam_toolbox.minimum_travel_distance")
    assert entry.outcome.value == "translated"
    assert "a robot that stands would add a key frame with each scan" in entry.text


def test_a_robot_in_the_mode_localization_is_localized_by_amcl() -> None:
    into = imported("    mode: localization\n    map_file_name: /maps/hall\n    map_start_pose: [1.0, 2.0, 0.5]\n")
    assert into[0] == {
        "parameters": {
            "amcl": {
                "odom_frame_id": "odom", "base_frame_id": "base_footprint", "laser_max_range": 8.0, "update_min_d": 0.0,
                "update_min_a": 0.4,
            }
        },
        "initial_pose": [1.0, 2.0, 0.5],
    }  # fmt: skip
    assert refused(into) == ["'/maps/hall' is a file of the robot's disk: name a published map by --map"]


def test_a_file_of_the_lifelong_node_says_so_by_its_parameters() -> None:
    into = imported("    mode: mapping\n    lifelong_iou_match: 0.8\n    lifelong_minimum_score: 0.1\n")
    slam = into[0]["parameters"]["grid_slam"]
    assert (slam["mode"], slam["lifelong_iou_match"]) == ("lifelong", 0.8)
    assert outcomes(into)["slam_toolbox.mode"] == "translated"
    assert outcomes(into)["slam_toolbox.lifelong_minimum_score"] == "no effect"


def test_a_pose_graph_of_the_disk_is_refused_with_the_next_step() -> None:
    into = imported("    map_file_name: maps/hall\n    map_start_at_dock: true\n    map_start_pose: [0.0, 0.0, 0.0]\n")
    assert "set parameters.grid_slam.map_file_name to its id" in refused(into)[0]
    assert outcomes(into)["slam_toolbox.map_start_pose"] == "no effect"


def test_an_unknown_mode_is_refused_and_the_robot_maps() -> None:
    into = imported("    mode: maping\n")
    assert into[0]["parameters"]["grid_slam"]["mode"] == "mapping"
    assert refused(into) == ["unknown mode 'maping'; known: mapping, localization, lifelong"]


@pytest.mark.parametrize(
    "node", ["$(var namespace)/slam_toolbox", "/r1/slam_toolbox", "/**", "async_slam_toolbox_node"]
)
def test_the_node_may_have_another_name(node: str) -> None:
    assert imported("    mode: mapping\n", node)[0]["parameters"]["grid_slam"]["resolution"] == 0.1


def test_files_of_ros_1_have_no_node() -> None:
    draft, report = import_slam_toolbox(
        b"mode: mapping\nresolution: 0.05\ninverted_laser: true\n", "mapper_params.yaml"
    )
    assert draft == {"map": "new:map", "parameters": {"grid_slam": {"mode": "mapping", "resolution": 0.05}}}
    assert report.counts()["refused"] == 0


def test_a_pose_of_two_numbers_is_refused() -> None:
    into = imported("    mode: localization\n    map_start_pose: [1.0, 2.0]\n")
    assert "initial_pose" not in into[0]
    assert refused(into) == ["it must be a list of 3 numbers, not [1.0, 2.0]"]


def test_a_value_that_the_clone_refuses_is_left_out() -> None:
    into = imported("    map_update_interval: -1.0\n    transform_timeout: soon\n    mode: mapping\n")
    file = robot_file([into], {}, refusal)
    assert refusal(file) is None
    found = outcomes(into)
    assert (found["slam_toolbox.map_update_interval"], found["slam_toolbox.transform_timeout"]) == (
        "refused",
        "refused",
    )
    assert "map_update_interval" not in file["parameters"]["grid_slam"]
