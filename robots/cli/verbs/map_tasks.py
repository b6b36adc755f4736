"""Verbs ``ppaas map task add``, ``list``, ``show``, ``confirm`` and ``cancel``: tasks for any robot of a map."""

import argparse
import time
from typing import Any

from ppaas.errors import InvalidInput, Unavailable
from robots.cli.output import show
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.cli.tasks.floors import places_on_floors
from robots.cli.verbs.task_options import add_options, options_of
from robots.client.cloud_url import path_of

COLUMNS = ("id", "kind", "priority", "state", "robot", "visited", "reason")
ADDED_COLUMNS = (*COLUMNS, "estimate")
ALL_COLUMNS = (
    *COLUMNS, "places", "floors", "rounds", "deadline", "labels", "failures", "created", "assigned", "begun", "ended",
    "holds", "holding", "named_robot", "weight", "not_before", "after", "preempts", "repeat", "run", "series",
)  # fmt: skip
KINDS = ("go_to", "pick_drop", "patrol")
OPEN = ("queued", "assigned", "active")
STATES = ("open", *OPEN, "done", "failed", "cancelled")
POLL = 0.5
"""Interval of queries while a command waits for the end of a task [s]."""


def configure(verbs: Any) -> None:
    """Add the verb ``task`` to ``ppaas map``."""
    task = verbs.add_parser(
        "task", help="add, list, show, confirm and cancel tasks, which any of your robots on a map may do"
    )
    inner = task.add_subparsers(dest="task_verb", required=True, metavar="VERB")
    added = inner.add_parser("add", help="add a task")
    listed = inner.add_parser("list", help="list your tasks on a map, oldest first")
    shown = inner.add_parser("show", help="show a task")
    confirmed = inner.add_parser("confirm", help="confirm a task whose robot holds at a place: it goes on")
    cancelled = inner.add_parser("cancel", help="cancel a task; its robot stops")
    for verb in (added, listed, shown, confirmed, cancelled):
        verb.add_argument("id", metavar="MAP", help="id of the map")
    for verb in (shown, confirmed, cancelled):
        verb.add_argument("task", help="id of the task")
    listed.add_argument("--state", choices=STATES, help="only tasks in this state; open: all that have not ended")
    add_limit_argument(listed)
    _add_task_arguments(added)
    for verb in (added, listed, shown, confirmed, cancelled):
        add_session_arguments(verb)


def _add_task_arguments(added: argparse.ArgumentParser) -> None:
    added.add_argument("kind", choices=KINDS)
    added.add_argument(
        "--at",
        nargs="+",
        action="append",
        required=True,
        metavar="PLACE",
        help="a place: x, y [m] and, optionally, yaw [rad], or the name of a station of the map; on another floor of "
        "its building FLOOR:X,Y[,YAW] or FLOOR:STATION; once for go_to, twice for pick_drop, again for a patrol",
    )
    added.add_argument("--rounds", type=int, help="rounds of a patrol (1)")
    added.add_argument("--priority", type=int, help="tasks of a higher one go first (0)")
    added.add_argument("--within", type=float, metavar="SECONDS", help="it fails if it has no robot by then")
    added.add_argument("--label", action="append", metavar="NAME=VALUE", help="property that its robot must have")
    add_options(added)
    added.add_argument("--wait", action="store_true", help="wait for its end; exit with 1 unless it is done")


async def task(arguments: argparse.Namespace) -> None:
    """Execute a verb of ``ppaas map task``."""
    await _VERBS[arguments.task_verb](arguments)


async def _add(arguments: argparse.Namespace) -> None:
    from asyncio import sleep  # noqa: PLC0415 - ``ppaas --help`` loads this module

    client = logged_in(arguments)
    places, floors = await places_on_floors(client, arguments.id, arguments.at)
    body = _body(arguments, places) | ({} if floors is None else {"floors": floors})
    found = await client.post(path_of("maps", arguments.id, "tasks"), body)
    while arguments.wait and found["state"] in OPEN:
        await sleep(POLL)
        found = await client.get(path_of("maps", arguments.id, "tasks", found["id"]))
    show(found, ADDED_COLUMNS, as_json=arguments.json)
    if arguments.wait and found["state"] != "done":
        raise Unavailable(f"the task is not done: {found['state']}: {found['reason'] or 'no reason was given'}")


def _body(arguments: argparse.Namespace, places: list[list[float]]) -> dict[str, Any]:
    fields = {"kind": arguments.kind, "places": places, "rounds": arguments.rounds}
    fields |= {"priority": arguments.priority}
    if arguments.within is not None:
        fields["deadline"] = time.time() + arguments.within
    if arguments.label:
        fields["labels"] = dict(map(_label, arguments.label))
    fields |= options_of(arguments, len(places))
    return {name: value for name, value in fields.items() if value is not None}


def _label(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise InvalidInput(f"--label needs NAME=VALUE, not {text!r}")
    return name, value


async def _list(arguments: argparse.Namespace) -> None:
    filters = {} if arguments.state is None else {"state": arguments.state}
    found = await logged_in(arguments).items(path_of("maps", arguments.id, "tasks"), arguments.limit, **filters)
    none = "no such tasks; add one: ppaas map task add MAP go_to --at X Y"
    show(found, COLUMNS, as_json=arguments.json, if_none=none)


async def _show(arguments: argparse.Namespace) -> None:
    found = await logged_in(arguments).get(path_of("maps", arguments.id, "tasks", arguments.task))
    show(found, ALL_COLUMNS, as_json=arguments.json)


async def _confirm(arguments: argparse.Namespace) -> None:
    path = path_of("maps", arguments.id, "tasks", arguments.task, "confirm")
    show(await logged_in(arguments).post(path, {}), COLUMNS, as_json=arguments.json)


async def _cancel(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).delete(path_of("maps", arguments.id, "tasks", arguments.task))


_VERBS = {"add": _add, "list": _list, "show": _show, "confirm": _confirm, "cancel": _cancel}
