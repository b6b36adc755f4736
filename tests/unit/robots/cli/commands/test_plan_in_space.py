"""``ppaas plan`` on an octomap file."""

import json
from pathlib import Path

import pytest

from tests.support.cloud.command_line import CommandLine
from tests.support.sources import ROOT
from tests.support.world.urdf import box, link, origin, part, urdf

TABLE = str(ROOT / "docs" / "examples" / "table.bt")
IN_ROOM = (TABLE, "--start", "0.5", "1.5", "0", "--goal", "3.5", "1.5", "0")


async def test_a_path_in_an_octomap_is_shown_in_one_row(ppaas: CommandLine) -> None:
    ended = await ppaas("plan", *IN_ROOM, user=None)
    assert ended.status == 0, ended.err
    assert ended.rows[0] == ["planner", "length", "cost", "expanded", "seconds"]
    assert ended.rows[1][:3] == ["astar3d", "3.04142", "1550"]


async def test_body_and_planner_are_configurable(ppaas: CommandLine) -> None:
    options = ("--planner", "dijkstra3d", "--height", "1.2", "--radius", "0.1", "--step", "0", "--json")
    ended = await ppaas("plan", *IN_ROOM, *options, user=None)
    answer = json.loads(ended.out)
    assert answer["planner"] == "dijkstra3d"
    assert {pose[2] for pose in answer["poses"]} == {0.0}
    high = await ppaas("plan", *IN_ROOM, "--fly", "--height", "1.0", "--depth", "16", "--json", user=None)
    assert max(pose[2] for pose in json.loads(high.out)["poses"]) > 0.5


async def test_a_urdf_sets_the_height(ppaas: CommandLine, tmp_path: Path) -> None:
    mast = part(box(0.2, 0.2, 1.2), origin((0, 0, 0.6)))
    (tmp_path / "mast.urdf").write_bytes(urdf(link("base_footprint", mast)))
    lengths = []
    for options in ((), ("--height", "0.3")):
        ended = await ppaas("plan", *IN_ROOM, "--urdf", str(tmp_path / "mast.urdf"), *options, "--json", user=None)
        lengths.append(json.loads(ended.out)["length"])
    assert lengths[0] > lengths[1] + 0.1


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((TABLE, "--start", "0", "0", "--goal", "1", "1", "1"), "--start must be x y z [yaw]"),
        ((*IN_ROOM, "--plot", "a.png"), "--plot, --rules and --parameter need a 2D map"),
        ((*IN_ROOM, "--planner", "navfn"), "unknown planner in space 'navfn'"),
        ((*IN_ROOM, "--depth", "17"), "from 1 to 16"),
        (("none.bt", *IN_ROOM[1:]), "cannot read none.bt"),
    ],
)
async def test_a_planning_error_in_space_is_reported(
    ppaas: CommandLine, arguments: tuple[str, ...], error: str
) -> None:
    ended = await ppaas("plan", *arguments, user=None)
    assert ended.status == 1
    assert error in ended.err


@pytest.mark.parametrize("option", [("--height", "1"), ("--step", "0.1"), ("--fly",), ("--depth", "15")])
@pytest.mark.parametrize("where", ["house", str(ROOT / "docs" / "examples" / "office.yaml")])
async def test_octomap_options_are_refused_for_a_2d_map(
    ppaas: CommandLine, where: str, option: tuple[str, ...]
) -> None:
    ended = await ppaas("plan", where, "--start", "0", "0", "--goal", "1", "1", *option)
    assert "need an octomap" in ended.err
    assert ppaas.cloud.asked == []
