"""Command ``ppaas replay BAG``: feeds a clone with a recording, and compares what it says."""

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robots.cli import event_loop
from robots.cli.session import add_session_arguments, token_of

if TYPE_CHECKING:
    from robots.replay.replaying import ReplayReport

NAME = "replay"
HELP = "replay a recording or a bag of ROS to a clone, and say how it differs from what was recorded"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument(
        "file", type=Path, metavar="BAG", help="recording of a robot, or a bag of ROS: a file or a folder"
    )
    parser.add_argument("--speed", type=_speed, default=1.0, help="factor on the recorded speed (%(default)s)")
    parser.add_argument("--until", type=float, metavar="SECONDS", help="end there in the recording (its end)")
    parser.add_argument("--robot", default="replay", metavar="ID", help="id of the robot in the cloud (%(default)s)")
    parser.add_argument("--robot-file", type=Path, metavar="FILE", help="robot file in place of the recorded one")
    parser.add_argument("--map", default="", metavar="ID", help="map of the cloud in place of the recorded one")
    parser.add_argument(
        "--rename",
        type=_renaming,
        action="append",
        default=[],
        metavar="TOPIC=NAME",
        help="send a topic of the file under another name, such as front/scan=scan; may be repeated",
    )
    parser.add_argument("--join", action="store_true", help="replay in the cloud at --url, and not in one of its own")
    add_session_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Replay; return 0 if the clone does as recorded, and 1 if goals end otherwise or poses are far off."""
    return event_loop.run(_run(arguments))


async def _run(arguments: argparse.Namespace) -> int:
    from robots.client.robot_file import load_robot_file  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from robots.replay.replaying import ReplayOptions, replay  # noqa: PLC0415

    options = ReplayOptions(
        path=arguments.file,
        robot=arguments.robot,
        speed=arguments.speed,
        until=arguments.until,
        file=None if arguments.robot_file is None else load_robot_file(arguments.robot_file),
        map=arguments.map,
        renamed=dict(arguments.rename),
        cloud=(arguments.url, token_of(arguments)) if arguments.join else None,
    )
    report = await replay(options, _say)
    _print(report, as_json=arguments.json)
    return int(report.comparison.differs)


def _say(line: str) -> None:
    sys.stderr.write(f"{line}\n")


def _print(report: "ReplayReport", *, as_json: bool) -> None:
    if as_json:
        sys.stdout.write(json.dumps(_values(report)) + "\n")
        return
    lines = report.comparison.words()
    lines += [f"Not sent: {count} messages of {reason}" for reason, count in report.recorded.skipped.most_common()]
    sys.stdout.write("\n".join(lines) + "\n")


def _values(report: "ReplayReport") -> dict[str, Any]:
    from dataclasses import asdict  # noqa: PLC0415 - as above

    return asdict(report.comparison) | {
        "differs": report.comparison.differs,
        "sent": report.sent,
        "seconds": report.recorded.seconds,
        "skipped": dict(report.recorded.skipped),
    }


def _speed(text: str) -> float:
    speed = float(text)
    if not 0.0 < speed <= 100.0:
        raise argparse.ArgumentTypeError(f"must be above 0 and at most 100, not {text}")
    return speed


def _renaming(text: str) -> tuple[str, str]:
    topic, equals, name = text.partition("=")
    if not (topic and equals and name):
        raise argparse.ArgumentTypeError(f"must be TOPIC=NAME, not {text!r}")
    return topic.lstrip("/"), name.lstrip("/")
