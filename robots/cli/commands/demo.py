"""Command ``ppaas demo``: a cloud and simulated robots on this machine, scored by their true poses."""

import argparse
import contextlib
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.bounded import whole
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.log_lines import log_lines
from robots.cli import event_loop
from robots.cli.session import seconds

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator

    from rich.console import Console

    from robots.demo.options import CloudAccess, DemoOptions, Write
    from robots.demo.report import AnyReport

NAME = "demo"
HELP = "start a cloud on this machine and drive simulated robots in it"

ADMIN = "admin"

DRIVE, PEOPLE, FLEET, BUILDING = "drive", "people", "fleet", "building"
"""What the demo shows."""

ROBOTS, GOALS = 3, 2
"""Robots, and goals of each."""

FOR_PEOPLE = {"people": 5, "seconds": 60.0, "detectors": "robot", "sensor": "camera"}
"""Defaults of the options of the demo of people."""

DEVICES = ("--device-host", "127.0.0.1")
"""Arguments of a cloud that leads the lifts and doors of a simulated building."""

MOST_EXPLORERS = 4
"""Largest number of robots that explore at once."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "show",
        nargs="?",
        choices=(DRIVE, PEOPLE, FLEET, BUILDING),
        default=DRIVE,
        help="robots that drive to goals (the default), that find, count and follow people, that drive to goals by "
        "the traffic of the map, or that take lifts to goals on other floors",
    )
    parser.add_argument("--robots", type=whole(), default=ROBOTS, help="simulated robots (%(default)s)")
    parser.add_argument(
        "--goals", type=whole(), default=GOALS, help="goals for each robot, one after the other (%(default)s)"
    )
    parser.add_argument("--map", type=Path, metavar="FILE.yaml", help="map to drive in (a generated warehouse)")
    parser.add_argument(
        "--explore",
        action="store_true",
        help="a robot explores an unknown office and publishes its map, on which another one drives to six goals",
    )
    parser.add_argument(
        "--explorers", type=whole(), default=1, help="with --explore: robots that explore at once (%(default)s)"
    )
    _configure_people(parser)
    parser.add_argument("--seed", type=int, default=0, help="seed of the courses (%(default)s)")
    parser.add_argument("--planner", default="dijkstra", help="global planner (%(default)s)")
    parser.add_argument("--controller", default="dwa", help="local planner (%(default)s)")
    parser.add_argument("--headless", action="store_true", help="show no progress")
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")
    parser.add_argument("--cloud", metavar="URL", help="use this running cloud (start one)")
    parser.add_argument(
        "--admin-password-file", type=Path, metavar="FILE", help="password of the user 'admin' of that cloud"
    )
    parser.add_argument("--keep-going", action="store_true", help="repeat the courses until Ctrl-C; needs a terminal")


def _configure_people(parser: argparse.ArgumentParser) -> None:
    parser.set_defaults(**FOR_PEOPLE)
    parser.add_argument("--people", type=whole(), help="with people: number of people (%(default)s)")
    parser.add_argument("--seconds", type=seconds, help="with people: time that is scored (%(default)g s)")
    parser.add_argument(
        "--detectors",
        choices=("robot", "cloud"),
        help="with people: where the detectors of people run (on the robot)",
    )
    parser.add_argument(
        "--sensor",
        choices=("camera", "laser"),
        help="with people: robots detect them in depth images (the default) or in laser scans",
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the demo; return 0 only if every goal was reached, or somebody was followed, without a contact."""
    if arguments.keep_going and not sys.stdout.isatty():
        raise InvalidParameter("--keep-going needs a terminal, because only Ctrl-C ends it")
    if arguments.explore and (arguments.keep_going or (arguments.robots, arguments.goals) != (ROBOTS, GOALS)):
        raise InvalidParameter("--explore has its own robots and goals: leave out --robots, --goals and --keep-going")
    if arguments.show == FLEET and arguments.explore:
        raise InvalidParameter("the demo of a fleet has no explorers, whose map is new: leave out --explore")
    if arguments.show == BUILDING and (arguments.explore or arguments.map):
        raise InvalidParameter("the demo of a building makes its maps: leave out --explore and --map")
    if arguments.show == PEOPLE and (arguments.explore or arguments.goals != GOALS):
        raise InvalidParameter("the demo of people has no goals and no explorers: leave out --goals and --explore")
    if arguments.show != PEOPLE and any(getattr(arguments, name) != value for name, value in FOR_PEOPLE.items()):
        options = ", ".join(f"--{name}" for name in FOR_PEOPLE)
        raise InvalidParameter(f"{options} are of the demo of people: run 'ppaas demo people'")
    if not 1 <= arguments.explorers <= MOST_EXPLORERS or (arguments.explorers > 1 and not arguments.explore):
        raise InvalidParameter(f"--explorers goes with --explore, and must be 1 to {MOST_EXPLORERS}")
    if arguments.seed < 0:
        raise InvalidParameter(f"--seed must be 0 or more, not {arguments.seed}")
    log_lines("%(levelname)s %(message)s")
    if (arguments.cloud is None) != (arguments.admin_password_file is None):
        raise InvalidParameter("--cloud and --admin-password-file must be given together")
    return event_loop.run(_run(arguments))


async def _run(arguments: argparse.Namespace) -> int:
    from rich.console import Console  # noqa: PLC0415 - a robot's install lacks rich and the simulator

    # With --json, only the result goes to the standard output.
    console = Console(stderr=arguments.json)
    options = _options(arguments, console)
    async with contextlib.AsyncExitStack() as stack:
        devices = DEVICES if arguments.show == BUILDING else ()
        cloud = _access(arguments) or await _own_cloud(stack, options, devices)
        report = await _show(arguments, options, cloud)
    if arguments.json:
        sys.stdout.write(report.to_json() + "\n")
    else:
        for line in report.lines():
            _print(console, line)
    return 0 if report.passed else 1


def _options(arguments: argparse.Namespace, console: "Console") -> "DemoOptions":
    from robots.client.map_files import read_map_file  # noqa: PLC0415
    from robots.demo.options import DemoOptions, no_lines  # noqa: PLC0415

    path = arguments.map
    return DemoOptions(
        robots=arguments.robots,
        goals=arguments.goals,
        seed=arguments.seed,
        map=(path.stem, read_map_file(path)) if path else None,  # refused before a cloud is started
        keep_going=arguments.keep_going,
        write=no_lines if arguments.headless else partial(_print, console),
        console=console if console.is_terminal and not arguments.headless else None,
        planner=arguments.planner,
        controller=arguments.controller,
        explorers=arguments.explorers,
        people=arguments.people,
        seconds=arguments.seconds,
        on_robot=arguments.detectors == "robot",
        sensor=arguments.sensor,
        traffic=arguments.show == FLEET,
    )


def _print(console: "Console", line: str) -> None:
    console.print(line, highlight=False, markup=False, soft_wrap=True)


async def _own_cloud(stack: contextlib.AsyncExitStack, options: "DemoOptions", more: tuple[str, ...]) -> "CloudAccess":
    """Start a cloud with more arguments, which ends with the stack, and write the address of its dashboard."""
    from robots.demo.cloud_process import own_cloud  # noqa: PLC0415

    with _status(options) as write:
        cloud = await stack.enter_async_context(own_cloud(write, more))
    options.write(f"dashboard: {cloud.url}  (user {cloud.admin}, password {cloud.password})")
    return cloud


@contextlib.contextmanager
def _status(options: "DemoOptions") -> "Iterator[Write]":
    """Show one line that changes, on a terminal; else, texts are lines of their own."""
    if options.console is None:
        yield options.write
    else:
        with options.console.status("") as status:
            yield status.update


async def _show(arguments: argparse.Namespace, options: "DemoOptions", cloud: "CloudAccess") -> "AnyReport":
    """Show the demo. Modules of the simulation compile kernels, most of which a new cloud has compiled by now."""
    import asyncio  # noqa: PLC0415 - the help of all commands imports nothing heavy

    options.write("preparing the simulation")
    show = await asyncio.to_thread(_demo_of, arguments)
    return await show(options, cloud)


def _demo_of(arguments: argparse.Namespace) -> "Callable[[DemoOptions, CloudAccess], Awaitable[AnyReport]]":
    if arguments.show == PEOPLE:
        from robots.demo.people import follow_people  # noqa: PLC0415

        return follow_people
    if arguments.show == BUILDING:
        from robots.demo.building import send_between_floors  # noqa: PLC0415

        return send_between_floors
    if arguments.explore:
        from robots.demo.exploration import explore_and_drive  # noqa: PLC0415

        return explore_and_drive
    from robots.demo.demonstration import demonstrate  # noqa: PLC0415

    return demonstrate


def _access(arguments: argparse.Namespace) -> "CloudAccess | None":
    from robots.demo.options import CloudAccess  # noqa: PLC0415

    if arguments.cloud is None:
        return None
    try:
        return CloudAccess(arguments.cloud, ADMIN, arguments.admin_password_file.read_text().strip())
    except OSError as error:
        raise InvalidInput(f"cannot read the password file: {error}") from error
