"""Command ``ppaas machine``: machines of the cloud and their limits, and the endpoints that run on them."""

import argparse
from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.plugins import installed
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

NAME = "machine"
HELP = "list, show, drain, label, limit, remove and admit machines; list endpoints; let this one join a cloud (admin)"

OTHERS = "ppaas.machine_verbs"
"""Group of verbs that other packages add: modules with HELP, configure(parser) and run(arguments)."""

LISTED = (
    "id", "state", "cores", "capacity", "given", "containers", "load", "memory_used", "memory", "labels", "kernels",
    "release",
)  # fmt: skip
MACHINES = Resource(
    "machines",
    (*LISTED, "network_used", "network", "round_trip"),
    "no machines are connected; see the log of the cloud",
    LISTED,
)
ENDPOINTS = Resource(
    "endpoints",
    ("id", "machine", "state", "sockets", "frames", "cpu", "memory", "release", "pid", "url"),
    "no endpoints are connected; see the log of the cloud",
)
LIMITS = ("id", "state", "max_containers", "oversubscription", "max_memory", "labels")

DEFAULT = "default"
POLL_PERIOD = 0.5
"""Polling period while a machine is drained [s]."""

_UNITS = {"K": 1 << 10, "M": 1 << 20, "G": 1 << 30, "T": 1 << 40}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list the machines")
    add_limit_argument(listing)
    serving = verbs.add_parser("endpoints", help="list the processes that serve robots, operators and REST")
    add_limit_argument(serving)
    one = verbs.add_parser("show", help="show one machine")
    drain = verbs.add_parser(
        "drain", help="start no new containers on a machine and move its containers; robots keep driving"
    )
    undrain = verbs.add_parser("undrain", help="let a drained machine take containers again")
    label = verbs.add_parser("label", help="set labels, which robots may require")
    limit = verbs.add_parser("limit", help="set limits for new containers")
    remove = verbs.add_parser("remove", help="remove a drained machine for good")
    admit = verbs.add_parser("admit", help="allow a removed machine to join again")
    named = (one, drain, undrain, label, limit, remove, admit)
    for verb in named:
        verb.add_argument("id")
    drain.add_argument("--wait", action="store_true", help="wait until it has no containers")
    label.add_argument("labels", nargs="+", type=_label_of, metavar="KEY=VALUE", help="KEY= removes a label")
    _add_limits(limit)
    remove.add_argument(
        "--force", action="store_true", help="even if it has containers; they are replaced on other machines"
    )
    for verb in (listing, serving, *named):
        add_session_arguments(verb)
    for name, module in installed(verbs, entry_points(group=OTHERS), getattr(parser, "words", None) or ()):
        other = verbs.add_parser(name, help=module.HELP, description=module.HELP)
        module.configure(other)
        other.set_defaults(run_verb=module.run)


def _add_limits(limit: argparse.ArgumentParser) -> None:
    limit.add_argument(
        "--max-containers", type=_or_default(int), metavar="N", help=f"maximum number of containers, or {DEFAULT!r}"
    )
    limit.add_argument(
        "--max-memory", type=_or_default(_bytes), metavar="SIZE", help="memory for containers, as 4G, or 'default'"
    )
    limit.add_argument(
        "--oversubscription",
        type=_or_default(float),
        metavar="X",
        help="cores of containers per core of the machine, or 'default'",
    )


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    if arguments.verb not in _VERBS:
        return int(arguments.run_verb(arguments))
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


async def _drain(arguments: argparse.Namespace) -> None:
    from asyncio import sleep  # noqa: PLC0415 - ``ppaas --help`` loads this module

    machine = await _change(arguments, {"draining": True})
    while arguments.wait and machine["state"] != "drained":
        await sleep(POLL_PERIOD)
        machine = await logged_in(arguments).get(path_of("machines", arguments.id))
    show(machine, MACHINES.columns, as_json=arguments.json)


async def _undrain(arguments: argparse.Namespace) -> None:
    show(await _change(arguments, {"draining": False}), MACHINES.columns, as_json=arguments.json)


async def _label(arguments: argparse.Namespace) -> None:
    labels = {key: value or None for key, value in arguments.labels}
    show(await _change(arguments, {"labels": labels}), LIMITS, as_json=arguments.json)


async def _limit(arguments: argparse.Namespace) -> None:
    given = {name: getattr(arguments, name) for name in ("max_containers", "max_memory", "oversubscription")}
    change = {name: None if value == DEFAULT else value for name, value in given.items() if value is not None}
    if not change:
        raise InvalidInput("nothing to change; give --max-containers, --max-memory or --oversubscription")
    show(await _change(arguments, change), LIMITS, as_json=arguments.json)


async def _remove(arguments: argparse.Namespace) -> None:
    query = "?force=true" if arguments.force else ""
    await logged_in(arguments).delete(path_of("machines", arguments.id) + query)


async def _admit(arguments: argparse.Namespace) -> None:
    admitted = await logged_in(arguments).post(path_of("machines", arguments.id, "admit"), {})
    show(admitted, ("id",), as_json=arguments.json)


async def _change(arguments: argparse.Namespace, change: dict[str, Any]) -> dict[str, Any]:
    machine: dict[str, Any] = await logged_in(arguments).patch(path_of("machines", arguments.id), change)
    return machine


def _label_of(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not (key and equals):
        raise argparse.ArgumentTypeError(f"must be KEY=VALUE, not {text!r}")
    return key, value


def _or_default(of: Callable[[str], float]) -> Callable[[str], float | str]:
    def number(text: str) -> float | str:  # argparse prints this function's name in its errors
        return DEFAULT if text == DEFAULT else of(text)

    return number


def _bytes(text: str) -> int:
    unit = _UNITS.get(text[-1:].upper(), 0)
    return int(float(text[:-1]) * unit) if unit else int(text)


_VERBS = {
    "list": MACHINES.list,
    "endpoints": ENDPOINTS.list,
    "show": MACHINES.show,
    "drain": _drain,
    "undrain": _undrain,
    "label": _label,
    "limit": _limit,
    "remove": _remove,
    "admit": _admit,
}
