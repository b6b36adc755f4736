import json

from ppaas.planners import planner_names
from ppaas.planners.catalogue import entry, told
from tests.support.command_line import CommandLine


async def test_the_planners_of_the_cloud_are_listed_with_what_they_are_for(ppaas: CommandLine) -> None:
    ended = await ppaas("planner", "list")
    assert ended.rows[0] == ["name", "optimal", "purpose"]
    assert [row[0] for row in ended.rows[1:]] == list(planner_names())
    dijkstra = next(row for row in ended.rows if row[0] == "dijkstra")
    assert dijkstra[1:4] == ["always", "Cheapest", "path"]


async def test_those_installed_here_are_told_of_without_a_cloud(ppaas: CommandLine) -> None:
    listed = await ppaas("planner", "list", "--here", "--json", user=None)
    assert [planner["name"] for planner in json.loads(listed.out)] == list(planner_names())
    shown = await ppaas("planner", "show", "navfn/NavfnROS", "--here", "--json", user=None)
    assert json.loads(shown.out) == told(entry("navfn"))


async def test_one_is_shown_with_its_traits_and_as_json_with_its_parameters(ppaas: CommandLine) -> None:
    shown = await ppaas("planner", "show", "navfn")
    assert shown.out == (await ppaas("planner", "show", "navfn", "--here")).out
    assert "navfn/NavfnROS, nav2_navfn_planner/NavfnPlanner  never" in shown.out
    whole = json.loads((await ppaas("planner", "show", "navfn", "--json")).out)
    assert whole["parameters"] == {"allow_unknown": True, "use_astar": False}


async def test_one_that_is_not_there_is_told_with_those_there_are(ppaas: CommandLine) -> None:
    for here in ((), ("--here",)):
        ended = await ppaas("planner", "show", "teleport", *here)
        assert (ended.status, ended.out) == (1, "")
        assert ended.err.startswith("ppaas: not-found: unknown planner 'teleport'; known: astar, dijkstra")
