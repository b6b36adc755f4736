"""``ppaas up``: start the cloud on this machine."""

import argparse
import math
import os
from functools import partial
from pathlib import Path

from endpoints.cli import front_options
from endpoints.store_options import add_stores
from ppaas.bounded import above_zero, whole
from ppaas.distribution import BASE, check_versions
from ppaas.errors import InvalidInput
from ppaas.log_lines import AS_JSON

NAME = "up"
HELP = "start the cloud on this machine"

RETENTIONS = ("recordings", "audit", "people", "plans", "tasks", "webhooks")
"""Kinds of data in ``endpoints.retention.kinds``, which the command line does not import."""

RETENTION_SIZES = ("recordings",)
"""Kinds of data whose size can be limited, as ``endpoints.retention.kinds`` has them."""

MOST_GIGABYTES = 1e6
"""Limit of the size of the data that are kept [GB]."""

MOST_DAYS = 36500.0
"""Limit of the days for which data are kept."""

QUOTAS = ("containers", "cores", "robots", "maps", "plans_per_minute", "stored_bytes", "versions_per_map")
"""Names of the quotas in ``engine.master.quotas``, which the command line does not import."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    front_options.add(parser)
    add_stores(parser)
    _add_versions(parser)
    _add_other_protocols(parser)
    _add_machines(parser)
    _add_devices(parser)
    _add_endpoints(parser)
    _add_standby(parser)
    _add_metrics(parser)
    _add_limits(parser)
    _add_retention(parser)
    _add_webhooks(parser)
    parser.add_argument(
        "--admin-password-file",
        type=Path,
        help="file with the password of user 'admin'; created if missing (admin-password in the data folder)",
    )
    parser.add_argument(
        "--ready-file", type=Path, help="write {url, pid, admin_user} to this file as JSON when the cloud is ready"
    )


def _add_other_protocols(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--rapyuta",
        type=whole(1, front_options.MAX_PORT),
        metavar="PORT",
        help="also serve robots that speak the protocol of Rapyuta (RoboEarth Cloud Engine), on this port (off)",
    )
    parser.add_argument(
        "--foxglove",
        type=whole(1, front_options.MAX_PORT),
        metavar="PORT",
        help="also serve viewers of Foxglove, on this port; 8765 is the one that Foxglove expects (off)",
    )


def _add_versions(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--keep-versions",
        type=whole(),
        metavar="NUMBER",
        help="versions of each map to keep: a publication removes the oldest beyond, unless robots use them (all)",
    )


def _add_machines(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--listen-machines", metavar="HOST:PORT", help="listen for machines of other hosts here and on the next port"
    )
    parser.add_argument(
        "--join-secret-file",
        type=Path,
        metavar="FILE",
        help="file of secrets with which machines of other hosts may join without a ticket; read whenever one asks",
    )
    front_options.add_masters(parser)
    parser.add_argument("--cores", type=whole(), help="CPUs that containers may use (all)")
    parser.add_argument(
        "--balancer",
        default="ppaas",
        metavar="NAME",
        help="load balancer, which chooses machines for containers (%(default)s)",
    )
    parser.add_argument(
        "--runtime",
        default="process",
        metavar="NAME",
        help="runtime of containers: process, docker, or ray, for processes on a Ray cluster (%(default)s)",
    )
    parser.add_argument(
        "--ray-address",
        metavar="HOST:PORT",
        help="head of the Ray cluster for --runtime ray (auto: the cluster started on this host)",
    )
    parser.add_argument(
        "--allow",
        action="append",
        default=[],
        metavar="GROUP:NAME",
        help="permit a third-party plug-in by its entry point, such as ppaas.planners:mine; may be repeated",
    )
    parser.add_argument(
        "--image", default="ppaas-engine", metavar="NAME", help="image of Docker containers (%(default)s)"
    )


def _add_devices(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--device-host",
        type=_device_host,
        action="append",
        default=[],
        metavar="HOST",
        help="let lifts and doors of buildings be at this host: a name, an address or a network, with a port if only "
        "that one is meant, such as lifts.example:8080 or 10.0.0.0/24; may be repeated",
    )


def _device_host(text: str) -> str:
    from engine.devices.hosts import DeviceHosts  # noqa: PLC0415 - ``ppaas --help`` loads this module

    try:
        DeviceHosts([text])
    except InvalidInput as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


def _add_endpoints(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--endpoints",
        type=whole(1),
        default=1,
        metavar="NUMBER",
        help="processes that serve robots, operators and REST on this host; the system gives each connection to one of "
        "them (%(default)s)",
    )

    parser.add_argument(
        "--ray-endpoints",
        type=whole(0),
        default=0,
        metavar="NUMBER",
        help="endpoints on each node of the Ray cluster, at the node's address and --port (%(default)s)",
    )


def _add_standby(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--standby",
        nargs="?",
        const="",
        metavar="TICKET",
        help="wait while another process leads the cloud of this store, and take over when it dies; the "
        "output of 'ppaas machine ticket --standby' is needed once if machines of other hosts have joined",
    )
    parser.add_argument(
        "--standby-secret-file",
        type=Path,
        metavar="FILE",
        help="file of secrets with which standbys may join without a ticket, and this one at --master; they get the "
        "key of the cloud's certificate authority",
    )


def _add_metrics(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--metrics",
        type=metrics_address,
        metavar="[HOST:]PORT",
        help="serve metrics for Prometheus on this port, at /metrics; without HOST at 127.0.0.1 (off)",
    )
    parser.add_argument(
        "--metrics-robots",
        action="store_true",
        help="list robots by user and name in the metrics: a series for each (off)",
    )


def metrics_address(text: str) -> tuple[str, int]:
    """Return the address for metrics: a port of 127.0.0.1, or ``host:port``; the type of an argument."""
    from engine.protocols.address import parse_host_port  # noqa: PLC0415 - ``ppaas --help`` loads this module

    try:
        host, port = parse_host_port(text if ":" in text else f"127.0.0.1:{text}")
    except InvalidInput as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return host, port


def _add_limits(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--quota",
        type=_quota,
        action="append",
        default=[],
        metavar="NAME=NUMBER",
        help=f"quota of every user: {', '.join(QUOTAS)}; may be repeated",
    )
    parser.add_argument(
        "--node-priorities",
        default="",
        metavar="CRITERION,...",
        help="criteria that decide which nodes run on robots, most important first (computation_power, "
        "node_properties, network_bandwidth)",
    )
    parser.add_argument(
        "--linger",
        type=front_options.seconds,
        default=30.0,
        help="seconds for which a clone waits for its disconnected robot (%(default)s)",
    )
    parser.add_argument(
        "--adopt-within",
        type=front_options.seconds,
        default=30.0,
        help="seconds for which clones survive this process if it is killed, to be adopted by the next one; "
        "0: they end with it (%(default)s)",
    )
    parser.add_argument(
        "--idle",
        type=front_options.seconds,
        default=600.0,
        help="seconds after which a robot that has no goal and sends nothing is disconnected; 0: never (%(default)s)",
    )


def _add_retention(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--retention",
        type=_retention,
        action="append",
        default=[],
        metavar="KIND=DAYS",
        help=f"days after which data are removed: {', '.join(RETENTIONS)}; may be repeated (tasks=7, webhooks=30)",
    )
    parser.add_argument(
        "--retention-size",
        type=_retention_size,
        action="append",
        default=[],
        metavar="KIND=GB",
        help=f"GB beyond which the oldest data are removed: {', '.join(RETENTION_SIZES)} (not limited)",
    )


def _add_webhooks(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--webhook-allow-private",
        action="store_true",
        help="let webhooks of users post to addresses that are not public, such as those of this network (off)",
    )
    parser.add_argument(
        "--webhook-allow-http", action="store_true", help="let webhooks of users post without TLS (off)"
    )


def _retention(text: str) -> tuple[str, float]:
    return _of_kind(text, RETENTIONS, "DAYS", MOST_DAYS)


def _retention_size(text: str) -> tuple[str, float]:
    return _of_kind(text, RETENTION_SIZES, "GB", MOST_GIGABYTES)


def _of_kind(text: str, kinds: tuple[str, ...], unit: str, most: float) -> tuple[str, float]:
    kind, _, number = text.partition("=")
    if kind not in kinds:
        raise argparse.ArgumentTypeError(f"unknown kind {kind!r}; known: {', '.join(kinds)}")
    try:
        return kind, above_zero(most)(number)
    except InvalidInput as error:
        raise argparse.ArgumentTypeError(f"give {kind}={unit}: {error}") from error


def _quota(text: str) -> tuple[str, float]:
    name, _, number = text.partition("=")
    if name not in QUOTAS:
        raise argparse.ArgumentTypeError(f"unknown quota {name!r}; known: {', '.join(QUOTAS)}")
    try:
        limit = float(number) if name == "cores" else int(number)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"give {name}=NUMBER, not {text!r}") from error
    if not (math.isfinite(limit) and limit >= 0):
        raise argparse.ArgumentTypeError(f"{name} must be at least 0, not {number}")
    return name, limit


def run(arguments: argparse.Namespace) -> int:
    """Serve until SIGINT or SIGTERM; return the exit status.

    Raises
    ------
    InvalidInput
        A setting is misspelt or wrong.
    Unavailable
        A package of the cloud is older or newer than tried.
    """
    environment = dict(os.environ)  # a reload reads the settings as this start does
    if arguments.log_format == AS_JSON:  # refusals of settings are JSON, too
        front_options.take_log_format(arguments)
    check_versions(BASE, "cloud")
    # Imported here, because the command line does not import the server; and the settings import this module.
    from endpoints.cli.settings_tree import TABLES, UP, settled  # noqa: PLC0415
    from endpoints.settings.reload import RunningSettings  # noqa: PLC0415
    from endpoints.settings.setting import settings_of  # noqa: PLC0415

    running = RunningSettings(settings_of({UP: TABLES[UP]}), partial(settled, UP, arguments, environment))
    front_options.take_log_format(running.arguments)
    front_options.take_traces(running.arguments)
    from engine.processes.imports import without_collection  # noqa: PLC0415

    with without_collection():
        from endpoints.cloud_processes.server import run_server  # noqa: PLC0415
    return run_server(running)
