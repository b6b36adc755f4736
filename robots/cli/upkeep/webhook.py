"""Command ``ppaas webhook``: webhooks, to which the cloud sends events, and their deliveries."""

import argparse
from typing import Any

from robots.cli import event_loop
from robots.cli.output import print_line, show
from robots.cli.resource import Resource, merge_patch
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

NAME = "webhook"
HELP = "create, list, change, try and delete webhooks; list and replay deliveries that were given up"

ROOT = "webhooks"
WEBHOOKS = Resource(
    ROOT,
    ("id", "url", "events", "robots", "maps", "state", "reason", "description", "former_until", "created"),
    "no webhooks; create one: ppaas webhook create URL --event 'goal.*'",
    ("id", "url", "events", "state", "reason", "description"),
)
SECRET_COLUMNS = ("id", "secret")
DELIVERY_COLUMNS = ("id", "event", "state", "attempts", "due", "reason")
STATES = ("waiting", "dead")
CHANGE_HELP = 'state=paused, url=https://…, events=["goal.*"], robots=[], description=…'


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    create = verbs.add_parser("create", help="create a webhook; print its secret, which is shown only here")
    listing = verbs.add_parser("list", help="list your webhooks")
    named = {
        "show": "show a webhook",
        "change": "change a webhook",
        "pause": "let deliveries wait",
        "resume": "send what waits and what comes",
        "rotate": "renew the secret; print it. The former one stays valid for a day",
        "test": "send the event webhook.test",
        "delete": "delete a webhook with its deliveries",
        "deliveries": "list the deliveries that wait or were given up, oldest first",
        "replay": "send a delivery that was given up again, or all of them",
        "discard": "delete a delivery that was given up",
    }
    each = {name: verbs.add_parser(name, help=text) for name, text in named.items()}
    for verb in each.values():
        verb.add_argument("id", help="id of the webhook")
    _add_create_arguments(create)
    each["change"].add_argument("changes", nargs="+", metavar="NAME=VALUE", help=CHANGE_HELP)
    each["deliveries"].add_argument("--state", choices=STATES, help="only those in this state; dead: given up")
    each["replay"].add_argument("delivery", nargs="?", help="id of the delivery (all)")
    each["discard"].add_argument("delivery", help="id of the delivery")
    for verb in (listing, each["deliveries"]):
        add_limit_argument(verb)
    for verb in (create, listing, *each.values()):
        add_session_arguments(verb)


def _add_create_arguments(create: argparse.ArgumentParser) -> None:
    create.add_argument("target", metavar="URL", help="target, https://…")
    create.add_argument(
        "--event", action="append", required=True, dest="events", metavar="GLOB",
        help="type of events to send, as robot.lost, or a glob, as 'goal.*'; may be repeated",
    )  # fmt: skip
    create.add_argument(
        "--robot", action="append", default=[], dest="robots", metavar="GLOB",
        help="only events of these robots; may be repeated (all)",
    )  # fmt: skip
    create.add_argument(
        "--map", action="append", default=[], dest="maps", metavar="GLOB",
        help="only events on these maps; may be repeated (all)",
    )  # fmt: skip
    create.add_argument("--description", default="", help="what it is for, shown in lists")
    create.add_argument("--paused", action="store_true", help="let deliveries wait until 'ppaas webhook resume'")


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


async def _create(arguments: argparse.Namespace) -> None:
    fields: dict[str, Any] = {name: getattr(arguments, name) for name in ("events", "robots", "maps", "description")}
    fields["url"] = arguments.target
    fields["state"] = "paused" if arguments.paused else "enabled"
    created = await logged_in(arguments).post(path_of(ROOT), fields)
    show(created, SECRET_COLUMNS, as_json=arguments.json)


async def _change(arguments: argparse.Namespace) -> None:
    await _patch(arguments, merge_patch(arguments.changes))


async def _pause(arguments: argparse.Namespace) -> None:
    await _patch(arguments, {"state": "paused"})


async def _resume(arguments: argparse.Namespace) -> None:
    await _patch(arguments, {"state": "enabled"})


async def _patch(arguments: argparse.Namespace, change: dict[str, Any]) -> None:
    changed = await logged_in(arguments).patch(path_of(ROOT, arguments.id), change)
    show(changed, WEBHOOKS.columns, as_json=arguments.json)


async def _rotate(arguments: argparse.Namespace) -> None:
    renewed = await logged_in(arguments).post(path_of(ROOT, arguments.id, "secret"), {})
    show(renewed, SECRET_COLUMNS, as_json=arguments.json)


async def _test(arguments: argparse.Namespace) -> None:
    sent = await logged_in(arguments).post(path_of(ROOT, arguments.id, "test"), {})
    show(sent, ("id",), as_json=arguments.json)


async def _deliveries(arguments: argparse.Namespace) -> None:
    filters = {} if arguments.state is None else {"state": arguments.state}
    path = path_of(ROOT, arguments.id, "deliveries")
    found = await logged_in(arguments).items(path, arguments.limit, **filters)
    show(found, DELIVERY_COLUMNS, as_json=arguments.json, if_none="no such deliveries")


async def _replay(arguments: argparse.Namespace) -> None:
    one = () if arguments.delivery is None else ("deliveries", arguments.delivery)
    answer = await logged_in(arguments).post(path_of(ROOT, arguments.id, *one, "replay"), {})
    if one or arguments.json:
        show(answer, DELIVERY_COLUMNS, as_json=arguments.json)
    else:
        print_line(f"{answer['replayed']} deliveries are sent again")


async def _discard(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).delete(path_of(ROOT, arguments.id, "deliveries", arguments.delivery))


_VERBS = {
    "create": _create,
    "list": WEBHOOKS.list,
    "show": WEBHOOKS.show,
    "change": _change,
    "pause": _pause,
    "resume": _resume,
    "rotate": _rotate,
    "test": _test,
    "delete": WEBHOOKS.delete,
    "deliveries": _deliveries,
    "replay": _replay,
    "discard": _discard,
}
