"""Commands of from-ros1.md and from-slam-toolbox.md work, and their tables and reports are those of the code."""

import json
import re
from pathlib import Path

import pytest

from ppaas.imports.parameters.ros1.importing import LOCAL_PLANNERS, import_ros1, import_ros1_files
from ppaas.imports.parameters.ros1.move_base_rules import global_planner
from ppaas.imports.parameters.slam.slam_toolbox import import_slam_toolbox
from ppaas.imports.report import ImportReport
from robots.cli.verbs import robot_import
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import blocks, run_shell, script, table, text_of
from tests.support.sources import ROOT

ROS1, SLAM = "docs/from-ros1.md", "docs/from-slam-toolbox.md"
EXAMPLES = ROOT / "docs" / "examples"


def shown(document: str) -> list[str]:
    """Return the lines of the first report that a document shows, with single spaces."""
    first = blocks(document, "text")[0]
    return [" ".join(line.split()) for line in first.splitlines()]


def lines(*reports: ImportReport) -> set[str]:
    return {f"{each.part} {each.outcome.value} {each.text}" for report in reports for each in report.entries}


def test_the_reports_are_those_of_the_examples() -> None:
    names = ("ros1_costmaps.yaml", "ros1_move_base.yaml", "ros1_amcl.yaml")
    reports = [report for _, report in import_ros1_files([((EXAMPLES / name).read_bytes(), name) for name in names])]
    assert set(shown(ROS1)) <= lines(*reports)
    assert all(report.counts()["refused"] == 0 for report in reports)
    report = import_slam_toolbox((EXAMPLES / "slam_toolbox.yaml").read_bytes(), "slam_toolbox.yaml")[1]
    assert set(shown(SLAM)) <= lines(report)
    assert report.counts()["refused"] == 0


def test_the_plug_ins_are_those_of_the_code() -> None:
    rows = dict(table(ROS1, "in ROS 1", "here"))
    planners = {name: here for names, here in rows.items() for name in re.findall(r"\w+/\w+", names)}
    for name, (own, _) in LOCAL_PLANNERS.items():
        (found,) = [here for each, here in planners.items() if each.endswith(f"/{name}")]
        assert own in found
    assert global_planner("navfn/NavfnROS") == planners["navfn/NavfnROS"]
    assert import_ros1(b"base_global_planner: global_planner/GlobalPlanner", "f")[0] == {
        "base_global_planner": "dijkstra"
    }


def test_the_options_are_those_of_the_command() -> None:
    for document in (ROS1, SLAM):
        named = set(re.findall(r"`(--[a-z0-9-]+) FILE", text_of(document)))
        assert named and named <= {option for option, _ in robot_import._OPTIONS.values()}


@pytest.mark.journey
def test_the_commands_of_both_pages_work(cloud: RunningCloud, tmp_path: Path) -> None:
    printed = run_shell(f"{script(ROS1)}\n{script(SLAM)}", tmp_path, cloud)
    assert '"astar"' in printed and "new:tb4" in printed
    decoder, text = json.JSONDecoder(), printed[printed.index("{") :]
    file, _ = decoder.raw_decode(text)
    assert (file["base_local_planner"], file["parameters"]["dwa"]["max_vel_x"]) == ("dwa", 0.4)
    drawn, _ = decoder.raw_decode(text[text.rindex("\n{") + 1 :])
    assert drawn["parameters"]["grid_slam"]["max_laser_range"] == 12.0
