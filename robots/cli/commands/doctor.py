"""Command ``ppaas doctor``: what a robot sends and what is missing, or what is wrong with the cloud, in words."""

import argparse
import json
import sys
from typing import Any

from robots.cli import event_loop
from robots.cli.session import add_session_arguments

NAME = "doctor"
HELP = "say what is wrong with a robot, or with the cloud, and what to do"

INTERVAL = 2.0
"""Time between two looks with ``--watch`` [s]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("robot", nargs="?", metavar="ROBOT", help="id of a robot; without it, the cloud is examined")
    parser.add_argument(
        "--seconds", type=_seconds, default=3.0, help="time for which the robot is watched, 0 to 8 (%(default)s)"
    )
    parser.add_argument("--watch", action="store_true", help="look again and again, until Ctrl-C")
    add_session_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Execute the command; return 0 if all is well, and 1 if there is a warning or an error."""
    return event_loop.run(_run(arguments))


async def _run(arguments: argparse.Namespace) -> int:
    from asyncio import sleep  # noqa: PLC0415 - ``ppaas --help`` loads this module

    while True:
        report = await _examine(arguments)
        _print(report, arguments)
        if not arguments.watch:
            return int(report["level"] != "ok")
        await sleep(INTERVAL)


async def _examine(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the diagnosis of the robot; the cloud's if there is no robot, or the cloud is the trouble."""
    from robots.cli.examination import Examination, with_packages  # noqa: PLC0415 - as above

    examination = Examination(arguments.url, arguments.token, arguments.seconds)
    if arguments.robot is None:
        return with_packages(await examination.cloud())
    return with_packages(await examination.robot(arguments.robot))


def _print(report: dict[str, Any], arguments: argparse.Namespace) -> None:
    from robots.cli.examination import as_text  # noqa: PLC0415 - as above

    if arguments.json:
        sys.stdout.write(json.dumps(report) + "\n")
    else:
        if arguments.watch and sys.stdout.isatty():
            sys.stdout.write("\x1b[2J\x1b[H")  # clears the terminal (ECMA-48)
        sys.stdout.write(as_text(report))
    sys.stdout.flush()


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0.0 <= seconds <= 8.0:
        raise argparse.ArgumentTypeError(f"must be from 0 to 8 seconds, not {text}")
    return seconds
