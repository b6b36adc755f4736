"""Run of a bridge of ``ppaas bridge``."""

import argparse
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ppaas.log_lines import log_lines
from robots.cli import event_loop
from robots.cli.session import token_of

if TYPE_CHECKING:
    from robots.bridges.core.transport import Transport

Opened = Callable[[], "tuple[Transport, dict[str, Any]]"]
"""Returns a transport, and further arguments of the bridge."""


def run_bridge(arguments: argparse.Namespace, opened: Opened) -> int:
    """Carry messages between a robot and its clone until interrupted; return the exit status.

    Parameters
    ----------
    arguments : argparse.Namespace
        Arguments of the command: the robot, the cloud, and ``namespace``.
    opened : callable
        Called once the log is there.
    """
    log_lines("%(levelname)s %(message)s", level=logging.INFO)
    event_loop.run(_run(arguments, opened))
    return 0


async def _run(arguments: argparse.Namespace, opened: Opened) -> None:
    # Imported here because ``ppaas --help`` loads this module.
    from robots.bridges.core.bridge import Bridge  # noqa: PLC0415

    transport, options = opened()
    bridge = Bridge(
        transport,
        url=arguments.url,
        robot=arguments.robot,
        token=token_of(arguments),
        namespace=arguments.namespace,
        **options,
    )
    await bridge.run()
