"""The report of an export is true: what has no effect in Nav2 is not reported as translated, and nothing twice."""

from typing import Any

import pytest

from ppaas.exports.ros2.releases import Release
from ppaas.exports.ros2.robot import robot_to_export
from ppaas.exports.ros2.setup import export_ros2
from tests.unit.ppaas.exports.ros2.test_setup import entries, exported, map_of, parameters, zone


@pytest.mark.parametrize(
    ("planner", "tolerance", "timeout"),
    [
        ("dijkstra", "translated", "no effect"),
        ("theta_star", "no effect", "no effect"),
        ("astar", "translated", "translated"),
    ],
)
def test_limits_of_planning_have_an_effect_where_nav2s_planner_has_them(
    planner: str, tolerance: str, timeout: str
) -> None:
    setup = exported({"base_global_planner": planner})
    assert list(entries(setup, "move_base.default_tolerance")) == [tolerance]
    assert list(entries(setup, "move_base.planner_timeout")) == [timeout]


@pytest.mark.parametrize(
    "file",
    [
        {"base_local_planner": "mppi", "parameters": {"mppi": {"model_dt": 0.01}}},
        {
            "base_local_planner": "pure_pursuit",
            "parameters": {"pure_pursuit": {"allow_reversing": True, "use_rotate_to_heading": True, "min_vel_x": -0.2}},
        },
    ],
)
def test_each_parameter_is_in_the_report_once(file: dict[str, Any]) -> None:
    parts = [entry.part for entry in exported(file).report.entries]
    assert sorted(set(parts)) == sorted(parts)


def test_a_patience_in_place_of_no_check_for_oscillation_is_reported() -> None:
    text = entries(exported(), "move_base.oscillation_timeout")["translated"]
    assert text.startswith("controller_server.progress_checker.movement_time_allowance = ")
    assert text.endswith("Nav2 does not do without this check")


def test_a_filter_that_is_off_is_reported() -> None:
    setup = exported({"parameters": {"keepout_filter": {"enabled": False, "filter_mask": "k"}}})
    why = {"no effect": "the filter is not enabled, or has no mask"}
    assert entries(setup, "keepout_filter.enabled") == entries(setup, "keepout_filter.filter_mask") == why
    assert entries(setup, "speed_filter.enabled") == {}


def test_a_controller_that_nav2_does_not_have_is_refused_once(monkeypatch: pytest.MonkeyPatch) -> None:
    robot = robot_to_export("tb1", {"map": "office"}, map_of())
    monkeypatch.setitem(robot.in_use["move_base"], "base_local_planner", "own_planner")  # type: ignore[arg-type]
    setup = export_ros2(robot, Release.JAZZY)
    assert list(entries(setup, "base_local_planner.own_planner")) == ["refused"]
    assert entries(setup, "base_local_planner") == {}
    follow = parameters(setup, "controller_server")["FollowPath"]
    assert (follow["plugin"], follow["vx_max"]) == ("nav2_mppi_controller::MPPIController", 0.65)


def test_marks_of_a_map_are_no_rules_of_traffic() -> None:
    setup = exported(map_=map_of(zone("no_stop", 0.0), zone("lift", 1.0)))
    assert entries(setup, "zone no_stop 0")["no effect"].startswith("Nav2 has no such rule of traffic")
    assert entries(setup, "zone lift 1") == {"no effect": "no filter of Nav2 knows marks of a map: lift"}
