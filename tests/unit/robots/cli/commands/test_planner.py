import json
from pathlib import Path

from PIL import Image

from ppaas.planners import planner_names
from ppaas.planners.catalogue import as_json, entry
from ppaas.plans.history import computed_row, found_row
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import house, put_map


async def test_planners_of_the_cloud_are_listed_with_their_purpose(ppaas: CommandLine) -> None:
    ended = await ppaas("planner", "list")
    assert ended.rows[0] == ["name", "optimal", "purpose"]
    assert [row[0] for row in ended.rows[1:]] == list(planner_names())
    dijkstra = next(row for row in ended.rows if row[0] == "dijkstra")
    assert dijkstra[1:4] == ["always", "Cheapest", "path"]


async def test_locally_installed_planners_are_listed_without_a_cloud(ppaas: CommandLine) -> None:
    listed = await ppaas("planner", "list", "--here", "--json", user=None)
    assert [planner["name"] for planner in json.loads(listed.out)] == list(planner_names())
    shown = await ppaas("planner", "show", "navfn/NavfnROS", "--here", "--json", user=None)
    assert json.loads(shown.out) == as_json(entry("navfn"))


async def test_a_planner_is_shown_with_its_traits_and_parameters(ppaas: CommandLine) -> None:
    shown = await ppaas("planner", "show", "navfn")
    assert shown.out == (await ppaas("planner", "show", "navfn", "--here")).out
    assert "navfn/NavfnROS, nav2_navfn_planner/NavfnPlanner  never" in shown.out
    whole = json.loads((await ppaas("planner", "show", "navfn", "--json")).out)
    assert whole["parameters"] == {"allow_unknown": True, "use_astar": False}


async def test_an_unknown_planner_is_reported_with_the_known_ones(ppaas: CommandLine) -> None:
    for here in ((), ("--here",)):
        ended = await ppaas("planner", "show", "teleport", *here)
        assert (ended.status, ended.out) == (1, "")
        assert ended.err.startswith("ppaas: not-found: unknown planner 'teleport'; known: astar, dijkstra")


async def test_planner_evaluation_of_a_map_is_shown_and_drawn(ppaas: CommandLine, tmp_path: Path) -> None:
    put_map(ppaas.services.map_store, house())
    nothing = await ppaas("planner", "evaluate", "house")
    assert nothing.out == "no paths were requested on this map\n"
    for bucket in (6, 12):
        row = computed_row(("house", "v1", "navfn", bucket), 0.01 * bucket)
        ppaas.services.store.add_history([row, found_row(row.key, "reused")])
    ended = await ppaas("planner", "evaluate", "house", "--plot", str(tmp_path / "house.png"))
    assert ended.status == 0, ended.err
    assert [row[:3] for row in ended.rows] == [["planner", "queries", "success"], ["navfn", "4", "1"]]
    assert Image.open(tmp_path / "house.png").width > 300
    whole = json.loads((await ppaas("planner", "evaluate", "house", "--json")).out)
    assert [each["computed"] for each in whole["planners"][0]["complexities"]] == [1, 1]


async def test_an_impossible_evaluation_plot_is_reported(ppaas: CommandLine, tmp_path: Path) -> None:
    put_map(ppaas.services.map_store, house())
    for picture, why in (("house.jpg", "pictures are PNG files"), ("house.png", "no path was computed")):
        ended = await ppaas("planner", "evaluate", "house", "--plot", str(tmp_path / picture))
        assert ended.status == 1
        assert why in ended.err
