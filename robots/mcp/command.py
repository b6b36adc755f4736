"""Command ``ppaas mcp``: serves the Model Context Protocol on standard input and output."""

import argparse
import logging

from ppaas.errors import InvalidInput
from ppaas.log_lines import log_lines
from robots.cli import event_loop
from robots.cli.session import add_cloud_arguments, token_of

NAME = "mcp"
HELP = "serve robots to programs with a language model, by the Model Context Protocol on standard input and output"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "A client of MCP starts this command. The server may do what the token may do, and the cloud decides: give it "
        "a token for some robots ('ppaas token create --robot ... --role ...') in PPAAS_TOKEN."
    )
    add_cloud_arguments(parser)
    parser.add_argument(
        "--read-only", action="store_true", help="offer tools that look, and none that changes anything"
    )
    parser.add_argument(
        "--robots",
        type=_robots,
        metavar="ROBOT,ROBOT",
        help="serve these robots alone, of those that the token permits; OWNER:ID for one of another user (all)",
    )
    parser.add_argument(
        "--allow-release", action="store_true", help="offer a tool that releases stopped robots, too (none does)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Serve until the client closes standard input; return the exit status."""
    if arguments.read_only and arguments.allow_release:
        raise InvalidInput("--allow-release offers a tool that changes robots: leave out --read-only")
    # Imported here because ``ppaas --help`` loads this module.
    from robots.mcp.narrowed_cloud import NarrowedCloud  # noqa: PLC0415
    from robots.mcp.server import serve, tools_of  # noqa: PLC0415

    log_lines("%(levelname)s %(message)s", level=logging.INFO)
    logging.getLogger("mcp").setLevel(logging.WARNING)
    tools = tools_of(read_only=arguments.read_only, may_release=arguments.allow_release)
    event_loop.run(serve(NarrowedCloud(arguments.url, token_of(arguments), arguments.robots), tools))
    return 0


def _robots(text: str) -> frozenset[str]:
    robots = frozenset(map(str.strip, text.split(",")))
    if "" in robots:
        raise argparse.ArgumentTypeError(f"name robots, as tb1,tb2, not {text!r}")
    return robots
