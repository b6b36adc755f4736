"""Command ``ppaas bridge vda5050 [ROBOT …]``: presents robots as AGVs of VDA 5050 to a master control."""

import argparse
import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.log_lines import log_lines
from robots.cli import event_loop
from robots.cli.session import add_cloud_arguments, rest_client, token_of

if TYPE_CHECKING:
    from asyncio import AbstractEventLoop
    from collections.abc import Callable, Coroutine

    from robots.bridges.vda5050.broker import Broker

HELP = "present robots as AGVs of VDA 5050 to a master control, over MQTT"

VERSIONS = ("2.0", "2.1", "3.0")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help="ids of the robots (all of the user)")
    add_cloud_arguments(parser)
    add_broker_arguments(parser)
    parser.add_argument("--vda", choices=VERSIONS, default="2.1", help="version of VDA 5050 (%(default)s)")
    parser.add_argument(
        "--manufacturer",
        default="ppaas",
        help="manufacturer, a level of topics (%(default)s); the id is the serial number",
    )
    parser.add_argument(
        "--state-interval",
        type=_state_interval,
        default=30.0,
        metavar="S",
        help="longest time between states (%(default)g)",
    )
    parser.add_argument(
        "--visualization",
        type=_visualization,
        default=1.0,
        metavar="S",
        help="time between visualizations (%(default)g s); 0 for none",
    )
    parser.add_argument(
        "--action",
        action="append",
        type=_action,
        default=[],
        metavar="TYPE=SERVICE",
        help="let orders call a service of the robot (std_srvs/Trigger) as an action; may be repeated",
    )
    parser.add_argument(
        "--zones", action="store_true", help="3.0: zones of the master control become masks of the robot's file"
    )


def add_broker_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the broker."""
    parser.add_argument(
        "--broker", required=True, metavar="URL", help="MQTT broker: mqtt://user@host:port, or mqtts:// with TLS"
    )
    parser.add_argument(
        "--password-file", type=Path, metavar="FILE", help="file with the password at the broker (PPAAS_MQTT_PASSWORD)"
    )
    parser.add_argument(
        "--broker-ca-file",
        type=Path,
        metavar="FILE",
        help="certificates in PEM to trust for mqtts (the system's)",
    )
    parser.add_argument("--interface", default="", help="first level of topics (uagv; vda5050 in 3.0)")


def broker_of(arguments: argparse.Namespace) -> "Broker":
    """Return the broker of the options; raises ``InvalidInput`` as `Broker.parse` and `password_of` do."""
    from robots.bridges.vda5050.broker import Broker, password_of  # noqa: PLC0415 - ``ppaas --help`` loads this module

    return Broker.parse(arguments.broker, password_of(arguments.password_file), arguments.broker_ca_file)


def run(arguments: argparse.Namespace) -> int:
    """Present the robots until interrupted; return the exit status."""
    return run_logged(_run(arguments))


def run_logged(bridge: "Coroutine[Any, Any, None]") -> int:
    """Run a bridge of many AGVs until interrupted, with its log on standard error; return the exit status."""
    log_lines("%(levelname)s %(message)s", level=logging.INFO)
    event_loop.run(bridge, _loop_factory())
    return 0


def _loop_factory() -> "Callable[[], AbstractEventLoop] | None":
    """Return the loop of uvloop, which halves the cost of many AGVs; it is not there on Windows."""
    try:
        from uvloop import new_event_loop  # noqa: PLC0415 - ``ppaas --help`` loads this module
    except ModuleNotFoundError:
        return None
    return new_event_loop


async def _run(arguments: argparse.Namespace) -> None:
    # Imported here because ``ppaas --help`` loads this module.
    from ppaas.wire.vda5050.topics import version_of  # noqa: PLC0415
    from robots.bridges.vda5050.agv_bridge import present  # noqa: PLC0415
    from robots.bridges.vda5050.agv_options import AgvOptions  # noqa: PLC0415

    broker = broker_of(arguments)
    options = AgvOptions(
        version=version_of(arguments.vda),
        manufacturer=arguments.manufacturer,
        interface=arguments.interface,
        state_interval=arguments.state_interval,
        visualization_interval=arguments.visualization,
        zones=arguments.zones,
        services=dict(arguments.action),
    )
    token = token_of(arguments)
    robots = arguments.robots or [one["id"] for one in await rest_client(arguments.url, token).items("/v1/robots")]
    await present(arguments.url, token, robots, broker, options)


def _state_interval(text: str) -> float:
    value = float(text)
    if not 0.2 <= value <= 30.0:
        raise argparse.ArgumentTypeError(f"must be 0.2 to 30 s, not {text}")
    return value


def _visualization(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= 3600.0:
        raise argparse.ArgumentTypeError(f"must be 0 to 3600 s, not {text}")
    return value


def _action(text: str) -> tuple[str, str]:
    name, _, service = text.partition("=")
    if not (name and service):
        raise argparse.ArgumentTypeError(f"name the type of the action and the service, as pick=/pick, not {text!r}")
    return name, service
