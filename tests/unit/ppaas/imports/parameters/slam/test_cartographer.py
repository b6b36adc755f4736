"""Option files of cartographer."""

from ppaas.imports.parameters.draft import Translation
from ppaas.imports.parameters.slam.cartographer import import_cartographer
from tests.support.imported_parameters import entry_of, outcomes, refused

OPTIONS = """
include "map_builder.lua"
options = {
  map_builder = MAP_BUILDER, trajectory_builder = TRAJECTORY_BUILDER, map_frame = "earth", tracking_frame = "imu_link",
  published_frame = "odom", provide_odom_frame = false, num_laser_scans = 1, submap_publish_period_sec = 0.3,
}
MAP_BUILDER.use_trajectory_builder_2d = true
TRAJECTORY_BUILDER_2D.min_range = 0.2
TRAJECTORY_BUILDER_2D.max_range = 9.
TRAJECTORY_BUILDER_2D.motion_filter.max_angle_radians = math.rad(10.)
TRAJECTORY_BUILDER_2D.submaps.grid_options_2d.resolution = 0.1
"""


def imported(more: str = "") -> Translation:
    return import_cartographer(f"{OPTIONS}{more}return options\n".encode(), "robot.lua", "hall")


def test_options_that_map_become_parameters_of_grid_slam() -> None:
    draft, report = imported()
    assert draft["map"] == "new:hall"
    slam = draft["parameters"]["grid_slam"]
    assert round(slam.pop("minimum_travel_heading"), 4) == 0.1745
    assert slam == {
        "map_frame": "earth", "map_update_interval": 1.0, "minimum_laser_range": 0.2, "max_laser_range": 9.0,
        "resolution": 0.1,
    }  # fmt: skip
    assert report.counts()["refused"] == 0


def test_pure_localization_is_amcl_on_a_published_map() -> None:
    for line in ("TRAJECTORY_BUILDER.pure_localization = true\n",
                 "TRAJECTORY_BUILDER.pure_localization_trimmer = { max_submaps_to_keep = 3 }\n"):  # fmt: skip
        into = imported(line)
        assert "map" not in into[0]
        amcl = into[0]["parameters"]["amcl"]
        assert (amcl["laser_max_range"], amcl["global_frame_id"]) == (9.0, "earth")
        path = "TRAJECTORY_BUILDER_2D.submaps.grid_options_2d.resolution"
        assert entry_of(into, path).text == "a robot on a published map makes none"


def test_closures_are_off_if_the_graph_is_never_optimized() -> None:
    assert imported("POSE_GRAPH.optimize_every_n_nodes = 0\n")[0]["parameters"]["grid_slam"]["do_loop_closing"] is False
    assert (
        "do_loop_closing"
        not in imported("SPARSE_POSE_GRAPH.optimize_every_n_scans = 35\n")[0]["parameters"]["grid_slam"]
    )


def test_maps_in_space_are_refused() -> None:
    into = imported("MAP_BUILDER.use_trajectory_builder_3d = true\nTRAJECTORY_BUILDER_3D.min_range = 1.\n")
    assert "octomap_server" in refused(into)[0]
    assert outcomes(into)["TRAJECTORY_BUILDER_3D.min_range"] == "no effect"


def test_unknown_options_get_the_nearest_one() -> None:
    into = imported("TRAJECTORY_BUILDER_2D.max_rnage = 3.\nPOSE_GRAPH.constraint_builder.min_scor = 0.6\n")
    assert refused(into) == [
        "unknown parameter; did you mean 'TRAJECTORY_BUILDER_2D.max_range'?",
        "unknown parameter; did you mean 'POSE_GRAPH.constraint_builder.min_score'?",
    ]


def test_a_file_that_builds_on_another_one_of_its_user_says_so() -> None:
    into = imported('include "robot_base.lua"\n')
    assert refused(into) == ["each file is read alone: give robot_base.lua by --cartographer before this one"]
