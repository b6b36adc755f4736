"""Command ``ppaas fleet``: plans for many robots that keep out of each other's way, and lanes of maps."""

import argparse
from pathlib import Path
from typing import Any

from ppaas.bounded import above_zero, whole
from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.progress import progress_bar

NAME = "fleet"
HELP = "plan paths for many robots that keep out of each other's way, and check lanes"

COLUMNS = ("agents", "cost", "bound", "makespan", "cpu_seconds")

LANE_COLUMNS = ("cells", "width", "length", "longest_move")

MOST_RADIUS = 10.0
"""Largest radius of robots [m]."""

MOST_SECONDS, MOST_THREADS, MOST_TURN = 86_400.0, 256, 20.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    _configure_lanes(verbs)
    plan = verbs.add_parser("plan", help="plan for the agents of a scenario of the MovingAI benchmarks")
    plan.epilog = (
        "Agents move to one of four neighbouring cells or wait in each step. No two are in one cell, none exchange "
        "their cells, and none turn in a closed ring. Cost is the sum of the last arrivals, bound that of the shortest "
        "paths."
    )
    plan.add_argument("map", type=Path, metavar="MAP.map", help="map of MovingAI")
    plan.add_argument("--scen", type=Path, required=True, metavar="FILE", help="scenario with starts and goals")
    plan.add_argument(
        "--agents", type=whole(), metavar="N", help="number of agents, from the first of the scenario on (all)"
    )
    plan.add_argument(
        "--seconds",
        type=above_zero(MOST_SECONDS),
        metavar="S",
        help="CPU time until the plan is printed: improve it meanwhile (print the first one)",
    )
    plan.add_argument(
        "--threads", type=whole(most=MOST_THREADS), default=1, metavar="N", help="threads that improve it (%(default)s)"
    )
    plan.add_argument(
        "--seed", type=whole(least=0), default=0, metavar="N", help="seed of the random numbers (%(default)s)"
    )
    plan.add_argument(
        "--turn",
        type=above_zero(MOST_TURN),
        metavar="STEPS",
        help="improve it as if a quarter turn took so many steps, and print the number of turns (turns cost nothing)",
    )
    plan.add_argument(
        "--json", action="store_true", help="print JSON, with the paths: a list of [row, column] an agent"
    )


def _configure_lanes(verbs: Any) -> None:
    lanes = verbs.add_parser("lanes", help="check the lanes of a map for robots of a radius, and draw their cells")
    lanes.epilog = "A map without room for the robots on its lanes, or with lanes too near to each other, is an error."
    lanes.add_argument("map", type=Path, metavar="MAP.yaml", help="map of map_server")
    lanes.add_argument("--zones", type=Path, required=True, metavar="FILE", help="GeoJSON with zones of the kind lane")
    lanes.add_argument(
        "--radius", type=above_zero(MOST_RADIUS), required=True, metavar="M", help="radius of the robots [m]"
    )
    lanes.add_argument("--picture", type=Path, metavar="FILE.png", help="draw the map with the cells along its lanes")
    lanes.add_argument("--json", action="store_true", help="print JSON")


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    if arguments.verb == "lanes":
        _check_lanes(arguments)
    else:
        _plan(arguments)
    return 0


def _check_lanes(arguments: argparse.Namespace) -> None:
    from robots.pictures.map_pictures import write_lanes  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from robots.plans import lanes  # noqa: PLC0415 - see above

    grid, cells = lanes.cells_on_lanes(arguments.map, arguments.zones, arguments.radius)
    if arguments.picture is not None:
        write_lanes(arguments.picture, grid, cells)
    show(lanes.facts_of(cells), LANE_COLUMNS, as_json=arguments.json)


def _plan(arguments: argparse.Namespace) -> None:
    from robots.plans import fleet  # noqa: PLC0415 - ``ppaas --help`` loads this module

    with event_loop.terminable(), progress_bar("fleet") as report:
        answer = fleet.answer_of(
            lambda: fleet.read_problem(arguments.map, arguments.scen, arguments.agents),
            arguments.seconds or 0.0,
            threads=arguments.threads,
            seed=arguments.seed,
            turn=arguments.turn,
            tell=report or (lambda _text, _done: None),
        )
    show(answer, COLUMNS, as_json=arguments.json)
