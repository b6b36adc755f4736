import io
import json
import math

import pytest
from rich.console import Console

from ppaas.geometry import Pose2D
from robots.demo.demonstration import progress_table
from robots.demo.mission import Mission
from robots.demo.report import BuildingReport, DemoReport, ExplorationReport, RobotReport
from robots.sim.courses import Course
from robots.sim.world import World
from tests.support.world.rooms import room


def test_a_report_is_one_line_of_json_with_null_for_nan() -> None:
    robot = RobotReport("tb1", goals_asked=2)
    robot.add_goal(reached=True, error=0.123456, plan_seconds=0.05)
    robot.add_goal(reached=False, error=3.0, plan_seconds=math.nan)
    line = DemoReport("depot", 12.5, [robot]).to_json()
    assert "\n" not in line
    assert json.loads(line) == {
        "map": "depot",
        "seconds": 12.5,
        "robots": [
            {
                "id": "tb1",
                "goals_asked": 2,
                "goals_reached": 1,
                "distance_m": 0.0,
                "final_errors_m": [0.1235, 3.0],
                "collisions": 0,
                "plan_seconds": [0.05, None],
                "ready_seconds": None,
            }
        ],
    }


@pytest.mark.parametrize(
    ("asked", "reached", "collisions", "passed"), [(2, 2, 0, True), (2, 1, 0, False), (2, 2, 1, False), (0, 0, 0, True)]
)
def test_a_report_passes_with_all_goals_reached_and_no_collision(
    asked: int, reached: int, collisions: int, passed: bool
) -> None:
    robot = RobotReport("tb1", goals_asked=asked, goals_reached=reached, collisions=collisions)
    assert DemoReport("depot", 1.0, [RobotReport("tb0"), robot]).passed is passed


def test_a_report_has_a_line_for_each_robot() -> None:
    robot = RobotReport("tb1", 2, 1, 12.34, [0.03, 1.5], collisions=1)
    assert DemoReport("depot", 61.0, [robot]).lines() == [
        "tb1: 1 of 2 goals reached, at most 1.50 m off, 12.3 m travelled, 1 contacts",
        "failed in 61 s on map 'depot'",
    ]


def test_a_report_of_a_building_has_a_line_about_its_lifts() -> None:
    robot = RobotReport("tb1", 2, 2, 12.34, [0.03, 0.02])
    report = BuildingReport(
        "house", 61.0, [robot], rides=2, lift_wait_mean_s=19.4, lift_wait_max_s=36.0, ride_mean_s=26.0
    )
    assert report.passed
    assert report.lines()[1:] == [
        "2 rides in lifts: 19 s of waiting in the mean, at most 36 s; 26 s in the car",
        "passed in 61 s on map 'house'",
    ]
    assert json.loads(report.to_json())["lift_wait_max_s"] == 36.0


def exploration(**changed: object) -> ExplorationReport:
    """Return a report that passes, with some fields changed."""
    drove = RobotReport("follower", 6, 6, 30.0, [0.02], 0)
    fields = {
        "map": "office", "seconds": 200.0, "explored": "succeeded", "explored_seconds": 150.0, "frontiers": 0,
        "unreachable": 1, "area_m2": 100.0, "known_cells": 40_000, "wrong_cells": 400,
        "robots": [RobotReport("explorer", distance_m=70.0), drove], **changed,
    }  # fmt: skip
    return ExplorationReport(**fields)  # type: ignore[arg-type]


def test_an_exploration_passes_with_a_right_map_all_goals_and_no_contact() -> None:
    assert exploration().passed
    assert not exploration(explored="aborted").passed
    assert not exploration(wrong_cells=401).passed
    assert not exploration(robots=[RobotReport("explorer", collisions=1)]).passed
    assert not exploration(robots=[RobotReport("follower", 6, 5)]).passed


def test_an_exploration_is_summed_up_in_lines() -> None:
    report = exploration()
    assert report.lines() == [
        "exploring succeeded after 150 s: 0 frontiers left, 1 given up",
        "map: 100.0 m² known, 400 of 40000 cells wrong (1.00 %)",
        "explorer: 70.0 m travelled, 0 contacts",
        "follower: 6 of 6 goals reached, at most 0.02 m off, 30.0 m travelled, 0 contacts",
        "passed in 200 s on map 'office'",
    ]
    assert exploration(joined_seconds=12.3).lines()[0] == "the maps were joined after 12 s"
    assert '"wrong_cells":400' in report.to_json()


def test_the_table_shows_the_progress_of_each_robot() -> None:
    world = World(room(8.0, 4.0))
    world.add_robot(Pose2D(2.0, 2.0, 0.0))
    mission = Mission(world, 0, "tb1", Course(Pose2D(2.0, 2.0), (Pose2D(5.5, 2.0),), (3.5,)))
    mission.progress.goal, mission.progress.target = 1, Pose2D(5.5, 2.0)
    mission.progress.state = "failed: [red]no[/red]"
    console = Console(file=io.StringIO(), width=120)
    console.print(progress_table([mission]))
    text = console.file.getvalue()  # type: ignore[attr-defined]
    for shown in ("tb1", "1/1", "3.50", "to go (m)", "failed: [red]no[/red]"):
        assert shown in text
