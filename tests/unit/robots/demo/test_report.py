import json
import math

import pytest

from robots.demo.report import DemoReport, RobotReport


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
