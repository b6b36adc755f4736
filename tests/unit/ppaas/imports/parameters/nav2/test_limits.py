"""Limits of the velocity smoother, and limits that suit each other."""

from typing import Any

import pytest

from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.nav2.importer import import_nav2
from ppaas.imports.report import ImportOutcome, ImportReport


def limited(plugin: str, given: str, smoother: str = "") -> tuple[dict[str, Any], ImportReport]:
    text = f"""
velocity_smoother:
  ros__parameters: {{{smoother}}}
controller_server:
  ros__parameters:
    FollowPath: {{plugin: "{plugin}", {given}}}
"""
    return import_nav2(text.encode(), "nav2.yaml")


DWB = "dwb_core::DWBLocalPlanner"
RPP = "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController"


def test_the_stricter_limits_count() -> None:
    smoother = "max_velocity: [0.3, 0.0, 2.0], min_velocity: [-0.1, 0.0, -2.0], max_accel: [9.0, 0.0, 2.5]"
    draft, report = limited(DWB, "max_vel_x: 0.5, min_vel_x: -0.4, max_vel_theta: 1.0, acc_lim_x: 1.0", smoother)
    assert draft["parameters"]["dwa"] == {
        "max_vel_x": 0.3, "min_vel_x": -0.1, "max_vel_theta": 1.0, "acc_lim_x": 1.0, "acc_lim_theta": 2.5,
    }  # fmt: skip
    lost = [entry for entry in report.entries if entry.part == "controller_server.FollowPath.max_vel_x"]
    assert [(entry.outcome, "wins" in entry.text) for entry in lost] == [(ImportOutcome.NO_EFFECT, True)]


def test_limits_that_change_nothing_have_no_effect() -> None:
    smoother = "max_velocity: [1.0, 0.0, 2.0], deadband_velocity: [0.0, 0.0, 0.0]"
    draft, report = limited(DWB, "max_vel_x: 0.5, max_vel_theta: 1.0", smoother)
    assert draft["parameters"]["dwa"] == {"max_vel_x": 0.5, "max_vel_theta": 1.0}
    idle = [entry for entry in report.entries if entry.part.startswith("velocity_smoother")]
    assert [entry.outcome for entry in idle] == [ImportOutcome.NO_EFFECT] * 2


def test_limits_of_six_axes_are_read_and_others_refused() -> None:
    draft, _ = limited(DWB, "max_vel_x: 0.5, max_vel_theta: 2.0", "max_velocity: [0.2, 0, 0, 0, 0, 1.5]")
    assert draft["parameters"]["dwa"] == {"max_vel_x": 0.2, "max_vel_theta": 1.5}
    for wrong in ("[0.2, 0.1]", "fast", "[a, b, c]"):
        _, report = limited(DWB, "max_vel_x: 0.5", f"max_velocity: {wrong}")
        assert [entry.part for entry in report.of(ImportOutcome.REFUSED)] == ["velocity_smoother.max_velocity"]


@pytest.mark.parametrize(
    ("plugin", "given"),
    [
        (DWB, "max_vel_x: 0.03, max_vel_theta: 0.1"),
        (RPP, "desired_linear_vel: 0.2, allow_reversing: true, use_rotate_to_heading: false"),
        (RPP, "allow_reversing: true"),
        (RPP, "rotate_to_heading_angular_vel: 0.1"),
        (RPP, "min_lookahead_dist: 1.2"),
        (RPP, "max_lookahead_dist: 0.2"),
        ("nav2_mppi_controller::MPPIController", "vx_max: 0.04, wz_max: 0.1"),
        ("teb_local_planner::TebLocalPlannerROS", "max_vel_x: 0.4, max_vel_x_backwards: 0.2"),
    ],
)
def test_the_clone_accepts_limits_that_its_defaults_would_not_suit(plugin: str, given: str) -> None:
    draft, report = limited(plugin, given)
    assert refusal({"map": "office", **draft}) is None
    assert not list(report.of(ImportOutcome.REFUSED))


def test_a_tolerance_that_mppi_does_not_reach_is_raised() -> None:
    goals = "goal_checker: {plugin: 'nav2_controller::SimpleGoalChecker', xy_goal_tolerance: 0.02}"
    text = f"""
controller_server:
  ros__parameters:
    {goals}
    FollowPath: {{plugin: "nav2_mppi_controller::MPPIController"}}
"""
    draft, report = import_nav2(text.encode(), "nav2.yaml")
    assert draft["parameters"]["mppi"] == {"xy_goal_tolerance": 0.05}
    assert "mppi does not come to rest nearer" in "".join(entry.text for entry in report.entries)


def test_beams_do_not_clear_farther_than_they_mark() -> None:
    text = """
local_costmap:
  local_costmap:
    ros__parameters:
      plugins: [obstacle_layer]
      obstacle_layer:
        plugin: "nav2_costmap_2d::ObstacleLayer"
        observation_sources: scan
        scan: {obstacle_max_range: 2.0}
"""
    draft, _ = import_nav2(text.encode(), "nav2.yaml")
    assert draft["parameters"]["local_costmap"] == {"obstacle_range": 2.0, "raytrace_range": 2.0}
