"""Merged translations, of which the clone accepts every value."""

import math
from typing import Any

from ppaas.imports.parameters.clone_check import refusal
from ppaas.imports.parameters.draft import Draft, robot_file
from ppaas.imports.parameters.ros_yaml import GivenValue
from ppaas.imports.parameters.rules import ParameterRule, apply_rule
from ppaas.imports.report import ImportOutcome, ImportReport


def translation(values: dict[str, Any], source: str = "nav2.yaml") -> tuple[Draft, ImportReport]:
    """Return a translation that puts each value at its dotted place."""
    draft: Draft = {}
    report = ImportReport(source)
    for line, (place, value) in enumerate(values.items(), 1):
        apply_rule(ParameterRule(place), f"their.{place}", GivenValue(value, line), draft, report)
    return draft, report


def refused(report: ImportReport) -> dict[str, str]:
    return {entry.part: entry.text for entry in report.of(ImportOutcome.REFUSED)}


def test_the_own_file_wins_and_the_report_says_so() -> None:
    nav2 = translation({"parameters.amcl.min_particles": 100, "parameters.amcl.max_particles": 900})
    own = {"map": "office", "parameters": {"amcl": {"min_particles": 300}}}
    file = robot_file([nav2], own, refusal)
    assert file == {"map": "office", "parameters": {"amcl": {"min_particles": 300, "max_particles": 900}}}
    (lost,) = nav2[1].of(ImportOutcome.NO_EFFECT)
    assert lost.part == "their.parameters.amcl.min_particles"
    assert "the robot file sets parameters.amcl.min_particles" in lost.text


def test_a_later_translation_wins() -> None:
    first = translation({"parameters.amcl.kld_err": 0.02, "parameters.amcl.kld_z": 0.9})
    second = translation({"parameters.amcl.kld_err": 0.03}, "amcl.yaml")
    file = robot_file([first, second], {"map": "office"}, refusal)
    assert file["parameters"]["amcl"] == {"kld_err": 0.03, "kld_z": 0.9}
    (lost,) = first[1].of(ImportOutcome.NO_EFFECT)
    assert lost.text == "amcl.yaml sets parameters.amcl.kld_err, and wins"
    assert [entry.outcome for entry in second[1].entries] == [ImportOutcome.TAKEN]


def test_what_the_clone_refuses_is_left_out_and_named() -> None:
    nav2 = translation(
        {
            "parameters.dwa.max_vel_x": 0.3,
            "parameters.dwa.sim_time": -1.0,
            "parameters.dwa.vx_samples": "many",
            "parameters.amcl.laser_model_type": "guess",
            "base_global_planner": "teleport",
            "parameters.global_costmap.robot_radius": 0.2,
        }
    )
    file = robot_file([nav2], {"map": "office"}, refusal)
    assert file == {
        "map": "office",
        "parameters": {"dwa": {"max_vel_x": 0.3}, "amcl": {}, "global_costmap": {"robot_radius": 0.2}},
    }
    assert refusal(file) is None
    assert set(refused(nav2[1])) == {
        "their.parameters.dwa.sim_time",
        "their.parameters.dwa.vx_samples",
        "their.parameters.amcl.laser_model_type",
        "their.base_global_planner",
    }
    assert "sim_time must be above 0" in refused(nav2[1])["their.parameters.dwa.sim_time"]


def test_more_faults_than_one_check_lists_are_all_left_out() -> None:
    names = [f"parameters.amcl.{name}{number}" for name in ("a", "b", "c") for number in range(10)]
    nav2 = translation(dict.fromkeys(names, 1.0))
    assert refusal(robot_file([nav2], {"map": "office"}, refusal)) is None
    assert len(refused(nav2[1])) == len(names)


def test_numbers_that_are_not_finite_are_refused_by_name() -> None:
    nav2 = translation({"parameters.amcl.kld_err": math.nan, "parameters.global_costmap.footprint": [[math.inf, 0.0]]})
    assert robot_file([nav2], {"map": "office"}, refusal) == {"map": "office", "parameters": {}}
    assert all("must be finite" in text for text in refused(nav2[1]).values())
    assert len(refused(nav2[1])) == 2


def test_parameters_of_a_local_planner_that_the_own_file_replaces_have_no_effect() -> None:
    nav2 = translation({"base_local_planner": "dwa", "parameters.dwa.max_vel_x": 0.3})
    file = robot_file([nav2], {"map": "office", "base_local_planner": "mppi"}, refusal)
    assert file == {"map": "office", "base_local_planner": "mppi", "parameters": {}}
    assert [entry.outcome for entry in nav2[1].entries] == [ImportOutcome.NO_EFFECT] * 2
    assert nav2[1].entries[1].text == "the robot drives with the local planner 'mppi'"


def test_faults_of_the_own_file_stay_for_the_cloud() -> None:
    nav2 = translation({"parameters.amcl.kld_err": 0.02})
    own = {"map": "office", "parameters": {"amcl": {"min_particles": -1}, "recorder": {}}}
    file = robot_file([nav2], own, refusal)
    assert file["parameters"] == {"amcl": {"kld_err": 0.02, "min_particles": -1}, "recorder": {}}
    assert not refused(nav2[1])


def test_a_robot_that_makes_a_map_is_checked_without_one() -> None:
    nav2 = translation({"parameters.keepout_filter.filter_mask": "office_keepout", "parameters.amcl.kld_err": 0.02})
    file = robot_file([nav2], {"map": "new:office"}, refusal)
    assert file["parameters"]["amcl"] == {"kld_err": 0.02}
    assert "cannot have the mask" in refused(nav2[1])["their.parameters.keepout_filter.filter_mask"]
