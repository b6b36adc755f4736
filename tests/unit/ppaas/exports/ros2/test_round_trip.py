"""A robot that leaves for Nav2 and comes back has the robot file that it left with, in what both sides have."""

from typing import Any

import pytest

from ppaas.exports.ros2.releases import Release
from ppaas.imports.parameters.nav2.importer import import_nav2
from tests.unit.ppaas.exports.ros2.test_setup import exported, map_of, zone

SHARED: dict[str, dict[str, Any]] = {
    "amcl": {"min_particles": 333, "laser_z_hit": 0.7},
    "move_base": {"controller_frequency": 21.0, "planner_frequency": 2.0, "oscillation_timeout": 12.0},
    "local_costmap": {"width": 4.0, "inflation_radius": 0.44},
    "global_costmap": {"inflation_radius": 0.66, "robot_radius": 0.21},
    "waypoint_follower": {"waypoint_pause_duration": 300},
}


@pytest.mark.parametrize("release", Release)
@pytest.mark.parametrize("controller", ["dwa", "mppi", "pure_pursuit"])
@pytest.mark.parametrize("planner", ["navfn", "lattice", "astar", "theta_star"])
def test_a_robot_comes_back_as_it_left(release: Release, controller: str, planner: str) -> None:
    given = SHARED | {controller: {"max_vel_x": 0.37, "acc_lim_theta": 2.5, "xy_goal_tolerance": 0.21}}
    if controller == "mppi" and release is Release.HUMBLE:
        del given[controller]["acc_lim_theta"]  # Humble's MPPI has no limits of acceleration
    file = {"base_local_planner": controller, "base_global_planner": planner, "parameters": given}
    setup = exported(file, map_of(zone("keep_out", 0.0)), release)
    back, report = import_nav2(
        setup.files["nav2_params.yaml"], "nav2_params.yaml", tree=setup.files["navigate_to_pose.xml"]
    )
    assert report.counts()["refused"] == 0
    assert (back["base_local_planner"], back["base_global_planner"]) == (controller, planner)
    found = {name: {key: back["parameters"][name].get(key) for key in table} for name, table in given.items()}
    assert found == given
