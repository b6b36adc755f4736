"""``ppaas up``: start the cloud on this machine."""

import argparse
import math
from pathlib import Path

from ppaas.bounded_numbers import whole

NAME = "up"
HELP = "start the cloud on this machine"

DEFAULT_PORT = 8500
QUOTAS = ("containers", "cores", "robots", "maps", "plans_per_minute")
"""As ``engine.master.quotas`` has them, which the command line does not load."""
MAX_PORT = 65535


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (%(default)s)")
    parser.add_argument(
        "--port", type=whole(0, MAX_PORT), default=DEFAULT_PORT, help="port; 0 takes a free one (%(default)s)"
    )
    parser.add_argument("--data", type=Path, default=Path("var"), help="folder of the embedded stores (./%(default)s)")
    parser.add_argument("--store", help="URL of the store for all but maps (sqlite in the data folder)")
    parser.add_argument("--map-store", help="URL of the store for maps (files in the data folder)")
    _add_machines(parser)
    _add_limits(parser)
    parser.add_argument(
        "--admin-password-file",
        type=Path,
        help="password of user 'admin'; made if it is not there (admin-password in the data folder)",
    )
    parser.add_argument("--ready-file", type=Path, help="write {url, pid, admin_user} here as JSON once all is up")
    parser.add_argument("--log-level", default="info", choices=["debug", "info", "warning", "error"])


def _add_machines(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--listen-machines", metavar="HOST:PORT", help="take machines of other hosts here; uses the next port as well"
    )
    parser.add_argument("--cores", type=whole(), help="CPUs that containers may use (all)")
    parser.add_argument(
        "--balancer", default="ppaas", metavar="NAME", help="chooses machines for containers (%(default)s)"
    )
    parser.add_argument(
        "--runtime",
        default="process",
        metavar="NAME",
        help="starts containers: process, docker; ray: processes on the nodes of a Ray cluster (%(default)s)",
    )
    parser.add_argument(
        "--ray-address",
        metavar="HOST:PORT",
        help="head of the Ray cluster for --runtime ray (auto: the one that was started on this host)",
    )
    parser.add_argument(
        "--allow",
        action="append",
        default=[],
        metavar="GROUP:NAME",
        help="let a plug-in of others run, by its entry point, as ppaas.planners:mine; may be given again",
    )
    parser.add_argument(
        "--image", default="ppaas-engine", metavar="NAME", help="what containers of docker run from (%(default)s)"
    )


def _add_limits(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--quota",
        type=_quota,
        action="append",
        default=[],
        metavar="NAME=NUMBER",
        help=f"what every user may have: {', '.join(QUOTAS)}; may be given for each",
    )
    parser.add_argument(
        "--node-priorities",
        default="",
        metavar="CRITERION,...",
        help="what says which nodes robots run themselves, the weightiest first (computation_power, node_properties, "
        "network_bandwidth)",
    )
    parser.add_argument(
        "--linger", type=_seconds, default=30.0, help="seconds that a clone waits for its robot (%(default)s)"
    )
    parser.add_argument(
        "--adopt-within",
        type=_seconds,
        default=30.0,
        help="seconds for which clones outlive this process, should it be killed, to be adopted by the next; "
        "0: they end with it (%(default)s)",
    )
    parser.add_argument(
        "--idle",
        type=_seconds,
        default=600.0,
        help="seconds after which a robot without a goal that says nothing is let go; 0: never (%(default)s)",
    )
    parser.add_argument(
        "--dead", type=_dead, default=15.0, help="seconds after which a silent connection counts as dead (%(default)s)"
    )


def _quota(text: str) -> tuple[str, float]:
    name, _, number = text.partition("=")
    if name not in QUOTAS:
        raise argparse.ArgumentTypeError(f"there is no quota {name!r}; known: {', '.join(QUOTAS)}")
    try:
        limit = float(number) if name == "cores" else int(number)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"give {name}=NUMBER, not {text!r}") from error
    if not (math.isfinite(limit) and limit >= 0):
        raise argparse.ArgumentTypeError(f"give {name} from 0 up, not {number}")
    return name, limit


def _seconds(text: str) -> float:
    seconds = float(text)
    if not (math.isfinite(seconds) and seconds >= 0.0):
        raise argparse.ArgumentTypeError(f"give seconds from 0 up, not {text}")
    return seconds


def _dead(text: str) -> float:
    seconds = _seconds(text)
    if seconds < 1.0:
        raise argparse.ArgumentTypeError(f"a living connection may be silent for 1 s or more, not {text}")
    return seconds


def run(arguments: argparse.Namespace) -> int:
    """Serve until a signal says stop; return the exit status."""
    from endpoints.server import run_server  # noqa: PLC0415 - the command line starts without the server's packages

    return run_server(arguments)
