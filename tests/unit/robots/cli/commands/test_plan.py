"""``ppaas plan``: on map files without a cloud, and on the maps of a cloud."""

import json
from pathlib import Path

import pytest
from PIL import Image

from ppaas.errors import GoalOccupied
from ppaas.maps.formats.image import ENDINGS
from robots.cli.commands.plan import IMAGES
from tests.support.cloud.command_line import CommandLine
from tests.support.sources import ROOT
from tests.support.storage.records import house, put_map
from tests.support.world.urdf import EXAMPLES

OFFICE = str(ROOT / "docs" / "examples" / "office.yaml")
WAFFLE = str(EXAMPLES / "turtlebot3_waffle.urdf")
IN_OFFICE = (OFFICE, "--start", "2", "2", "--goal", "10", "8")
IN_HOUSE = ("house", "--start", "0", "0", "--goal", "3", "4")


@pytest.fixture(autouse=True)
def published(ppaas: CommandLine) -> None:
    put_map(ppaas.services.map_store, house())


def test_every_image_of_a_map_is_taken_for_a_file() -> None:
    assert sorted(IMAGES) == sorted(ENDINGS)


async def test_a_plan_is_shown_in_one_row(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "house", "--start", "0", "0", "--goal", "3", "4", "1.5")
    assert ended.status == 0, ended.err
    assert ended.rows[0] == ["plan_id", "planner", "length", "cost", "expanded", "seconds", "container", "pid"]
    assert ended.rows[1][1:] == ["dijkstra", "5", "50", "2", "0.001", "c9", "4711"]


async def test_json_contains_the_poses(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "house", "--start", "0", "0", "--goal", "3", "4", "--json")
    assert [pose[:2] for pose in json.loads(ended.out)["poses"]] == [[0.0, 0.0], [3.0, 4.0]]


async def test_negative_numbers_planner_and_tolerance_reach_the_cloud(ppaas: CommandLine) -> None:
    await ppaas(
        "plan", "house", "--start", "-1", "-2", "-0.5", "--goal", "0", "0", "--planner", "navfn", "--tolerance", "0.5"
    )
    [(user, version, request)] = ppaas.cloud.asked
    assert (user, version.id) == ("ann", "house")
    assert (request.start, request.goal[:2]) == ((-1.0, -2.0, -0.5), (0.0, 0.0))
    assert (request.planner, request.tolerance) == ("navfn", 0.5)


async def test_parameters_reach_the_cloud(ppaas: CommandLine) -> None:
    given = ("--parameter", "allow_unknown=false", "--parameter", "robot_radius=0.3")
    assert (await ppaas("plan", *IN_HOUSE, *given)).status == 0
    assert ppaas.cloud.asked[0][2].parameters == {"allow_unknown": False, "robot_radius": 0.3}
    refused = await ppaas("plan", *IN_HOUSE, "--parameter", "allow_unknown")
    assert "'allow_unknown' is not a valid change; write NAME=VALUE" in refused.err


async def test_parameters_apply_on_a_map_file(ppaas: CommandLine) -> None:
    usual = json.loads((await ppaas("plan", *IN_OFFICE, "--json", user=None)).out)
    wide = await ppaas("plan", *IN_OFFICE, "--parameter", "inflation_radius=2", "--json", user=None)
    assert json.loads(wide.out)["cost"] > usual["cost"], wide.err
    refused = await ppaas("plan", *IN_OFFICE, "--parameter", "speed=1", user=None)
    assert "planner 'dijkstra' has no parameter 'speed'; known: allow_unknown" in refused.err
    assert "of the costmap: cost_scaling_factor, footprint, inflation_radius" in refused.err


async def test_a_planning_error_of_the_cloud_is_reported(ppaas: CommandLine) -> None:
    ppaas.cloud.error = GoalOccupied("the goal is in a wall")
    ended = await ppaas("plan", "house", "--start", "0", "0", "--goal", "1", "1")
    assert (ended.status, ended.out, ended.err) == (1, "", "ppaas: goal-occupied: the goal is in a wall\n")


async def test_a_map_without_read_access_is_unknown(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "house", "--start", "0", "0", "--goal", "1", "1", user="bob")
    assert ended.err == "ppaas: not-found: unknown map 'house'\n"


@pytest.mark.parametrize("numbers", [["1"], ["1", "2", "3", "4"]])
async def test_a_pose_has_two_or_three_numbers(ppaas: CommandLine, numbers: list[str]) -> None:
    ended = await ppaas("plan", "house", "--start", *numbers, "--goal", "1", "1")
    assert ended.status == 1
    assert "--start must be x y [yaw]" in ended.err
    assert ppaas.cloud.asked == []


async def test_a_coordinate_that_is_not_a_number_is_refused(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "house", "--start", "here", "0", "--goal", "1", "1")
    assert ended.status == 2
    assert "--start" in ended.err


@pytest.mark.parametrize("number", ["nan", "inf"])
async def test_a_pose_that_is_not_finite_is_refused(ppaas: CommandLine, number: str) -> None:
    for where in ("house", OFFICE):
        ended = await ppaas("plan", where, "--start", "0", "0", "--goal", number, "1")
        assert ended.err == f"ppaas: invalid-input: --goal must be finite numbers, not {number} 1.0\n"
    assert ppaas.cloud.asked == []


# -- on a map file -----------------------------------------------------------------------------------------------------


async def test_planning_on_a_map_file_needs_no_cloud(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", *IN_OFFICE, "--planner", "astar", user=None)
    assert ended.status == 0, ended.err
    assert ended.rows[0] == ["planner", "length", "cost", "expanded", "seconds"]
    assert ended.rows[1][:2] == ["astar", "12.5207"]
    assert ppaas.cloud.asked == []


async def test_json_of_a_map_file_contains_the_poses(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", *IN_OFFICE, "--json", user=None)
    answer = json.loads(ended.out)
    assert (answer["poses"][0][:2], answer["poses"][-1][:2]) == ([2.0, 2.0], [10.0, 8.0])


async def test_a_large_robot_keeps_a_larger_distance(ppaas: CommandLine) -> None:
    costs = []
    for robot in ((), ("--model", "turtlebot3_waffle"), ("--urdf", WAFFLE), ("--radius", "0.35")):
        ended = await ppaas("plan", *IN_OFFICE, *robot, "--json", user=None)
        costs.append(json.loads(ended.out)["cost"])
    assert costs == sorted(costs)
    assert costs[0] < costs[-1]


async def test_the_path_on_a_map_file_is_drawn(ppaas: CommandLine, tmp_path: Path) -> None:
    picture = tmp_path / "path.png"
    ended = await ppaas("plan", *IN_OFFICE, "--plot", str(picture), user=None)
    assert ended.status == 0, ended.err
    with Image.open(picture) as drawn:
        assert drawn.width > 800


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((*IN_OFFICE, "--planner", "teleport"), "not-found: unknown planner 'teleport'; known: astar, dijkstra"),
        ((*IN_OFFICE, "--model", "r2d2"), "not-found: unknown robot model 'r2d2'; known: turtlebot2, "),
        ((*IN_OFFICE, "--radius", "-1"), "invalid-parameter: robot_radius must be from 0 to 100 m, not -1.0"),
        ((*IN_OFFICE, "--urdf", "no.urdf"), "invalid-input: cannot read the URDF: "),
        ((*IN_OFFICE, "--urdf", OFFICE), "invalid-urdf: the URDF is not XML: "),
        (
            (*IN_OFFICE, "--tolerance", "nan"),
            "invalid-input: the tolerance must be at least 0 metres, not nan",
        ),
        ((*IN_OFFICE, "--plot", "a.jpg"), "invalid-input: pictures are PNG files; use a.png, not 'a.jpg'"),
        (("no.yaml", *IN_OFFICE[1:]), "invalid-map: cannot read the map: "),
        (("no.png", *IN_OFFICE[1:]), "invalid-map: cannot read the map: "),
        ((str(ROOT / "README.md"), *IN_OFFICE[1:]), "invalid-map: the map's YAML "),
        (
            (OFFICE, "--start", "0.01", "0.01", "--goal", "2", "2"),
            "start-occupied: the start x=0.010 y=0.010 is in ",
        ),
        (
            (OFFICE, "--start", "2", "2", "--goal", "99", "2"),
            "goal-outside-map: the goal x=99.000 y=2.000 is outside",
        ),
        ((*IN_HOUSE, "--radius", "1"), "invalid-input: --radius, --model, --urdf and --rules need a map file"),
    ],
)
async def test_a_planning_error_on_a_map_file_is_reported(
    ppaas: CommandLine, arguments: tuple[str, ...], error: str
) -> None:
    ended = await ppaas("plan", *arguments, user=None)
    assert (ended.status, ended.out) == (1, "")
    assert ended.err.startswith(f"ppaas: {error}")


# -- stored in a cloud -------------------------------------------------------------------------------------------------


async def test_the_verb_create_may_be_given(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", "create", *IN_HOUSE)
    assert ended.status == 0, ended.err
    assert ended.rows[1][1] == "dijkstra"


async def test_stored_plans_are_listed_shown_drawn_and_deleted(ppaas: CommandLine, tmp_path: Path) -> None:
    assert "no stored paths on this map" in (await ppaas("plan", "list", "house")).out
    plan_id = (await ppaas("plan", *IN_HOUSE)).rows[1][0]
    assert [row[0] for row in (await ppaas("plan", "list", "house")).rows] == ["plan_id", plan_id]
    shown = await ppaas("plan", "show", plan_id, "--json", "--plot", str(tmp_path / "a.png"))
    assert [pose[:2] for pose in json.loads(shown.out)["poses"]] == [[0.0, 0.0], [3.0, 4.0]]
    assert (tmp_path / "a.png").is_file()
    assert (await ppaas("plan", "delete", plan_id)).status == 0
    assert (await ppaas("plan", "show", plan_id)).err == f"ppaas: not-found: unknown plan {plan_id!r}\n"


async def test_a_new_path_of_the_cloud_is_drawn(ppaas: CommandLine, tmp_path: Path) -> None:
    ended = await ppaas("plan", *IN_HOUSE, "--plot", str(tmp_path / "a.png"))
    assert ended.status == 0, ended.err
    assert (tmp_path / "a.png").is_file()
