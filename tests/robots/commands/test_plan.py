import json

import pytest

from ppaas.errors import GoalOccupied
from tests.support.command_line import CommandLine
from tests.support.records import house


@pytest.fixture(autouse=True)
def published(ppaas: CommandLine) -> None:
    ppaas.services.map_store.put_map(house())


async def test_a_plan_is_told_in_one_row(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "house", "--start", "0", "0", "--goal", "3", "4", "1.5")
    assert ended.status == 0, ended.err
    assert ended.rows[0] == ["plan_id", "planner", "length", "cost", "expanded", "seconds", "container", "pid"]
    assert ended.rows[1][1:] == ["dijkstra", "5", "50", "2", "0.001", "c9", "4711"]


async def test_json_has_the_poses(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "house", "--start", "0", "0", "--goal", "3", "4", "--json")
    assert [pose[:2] for pose in json.loads(ended.out)["poses"]] == [[0.0, 0.0], [3.0, 4.0]]


async def test_negative_numbers_planner_and_tolerance_reach_the_cloud(ppaas: CommandLine) -> None:
    await ppaas(
        "plan", "house", "--start", "-1", "-2", "-0.5", "--goal", "0", "0", "--planner", "navfn", "--tolerance", "0.5"
    )
    [(user, version, request)] = ppaas.cloud.asked
    assert (user, version.id) == ("ann", "house")
    assert (request.start, request.goal) == ((-1.0, -2.0, -0.5), (0.0, 0.0, 0.0))
    assert (request.planner, request.tolerance) == ("navfn", 0.5)


async def test_what_cannot_be_planned_says_why(ppaas: CommandLine) -> None:
    ppaas.cloud.error = GoalOccupied("the goal is in a wall")
    ended = await ppaas("plan", "house", "--start", "0", "0", "--goal", "1", "1")
    assert (ended.status, ended.out, ended.err) == (1, "", "ppaas: goal-occupied: the goal is in a wall\n")


async def test_a_map_that_may_not_be_seen_is_unknown(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "house", "--start", "0", "0", "--goal", "1", "1", user="bob")
    assert ended.err == "ppaas: not-found: unknown map 'house'\n"


@pytest.mark.parametrize("numbers", [["1"], ["1", "2", "3", "4"]])
async def test_a_pose_has_two_or_three_numbers(ppaas: CommandLine, numbers: list[str]) -> None:
    ended = await ppaas("plan", "house", "--start", *numbers, "--goal", "1", "1")
    assert ended.status == 1
    assert "--start takes x y [yaw]" in ended.err
    assert ppaas.cloud.asked == []


async def test_a_word_is_no_number(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "house", "--start", "here", "0", "--goal", "1", "1")
    assert ended.status == 2
    assert "--start" in ended.err
