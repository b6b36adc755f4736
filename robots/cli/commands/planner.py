"""Command ``ppaas planner``: lists, shows and evaluates planners."""

import argparse
from pathlib import Path
from typing import Any
from urllib.parse import quote

from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

NAME = "planner"
HELP = "list and show planners, and their evaluation on a map"

PLANNERS = Resource(
    "planners",
    ("name", "aliases", "optimal", "weighted", "any_angle", "kinematic", "indexed", "incremental", "purpose"),
    "no planners are installed",
    list_columns=("name", "optimal", "purpose"),
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list the planners")
    one = verbs.add_parser("show", help="show one planner")
    _configure_evaluate(verbs.add_parser("evaluate", help="show the evaluation of the planners on a map of the cloud"))
    add_limit_argument(listing)
    one.add_argument("id", metavar="NAME", help="name of the planner")
    for verb in (listing, one):
        verb.add_argument(
            "--here", action="store_true", help="the planners installed on this computer, not the cloud's"
        )
        add_session_arguments(verb)


def _configure_evaluate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("map", help="id of the map")
    parser.add_argument("--version", metavar="SHA", help="only requests on this version of the map")
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="plot planning time over distance")
    add_session_arguments(parser)
    parser.set_defaults(here=False)


async def _evaluate(arguments: argparse.Namespace) -> None:
    if arguments.plot is not None:
        from robots.pictures.figure_file import check_figure  # noqa: PLC0415

        check_figure(arguments.plot)
    query = f"?version={quote(arguments.version, safe='')}" if arguments.version else ""
    found = await logged_in(arguments).get(path_of("maps", arguments.map, "evaluation") + query)
    if arguments.plot is not None:
        from robots.pictures.line_chart import write_evaluation  # noqa: PLC0415

        write_evaluation(arguments.plot, found)
    show(
        found if arguments.json else found["planners"],
        EVALUATED,
        as_json=arguments.json,
        if_none="no paths were requested on this map",
    )


EVALUATED = (
    "planner", "queries", "success", "over_cheapest", "typical_seconds", "seconds",
    "computed", "reused", "stitched", "reuse_rate",
)  # fmt: skip


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    if arguments.here:
        _show_installed(arguments)
    else:
        event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


def _show_installed(arguments: argparse.Namespace) -> None:
    from ppaas.planners.catalogue import as_json, catalogue, entry  # noqa: PLC0415 - ``ppaas --help`` loads this module

    found: Any = as_json(entry(arguments.id)) if arguments.verb == "show" else catalogue()[: arguments.limit]
    show(found, PLANNERS.columns if arguments.verb == "show" else PLANNERS.list_columns, as_json=arguments.json)


_VERBS = {"list": PLANNERS.list, "show": PLANNERS.show, "evaluate": _evaluate}
"""Verbs that query the cloud."""
