"""``ppaas machine join``: make this host a machine of a cloud on another one."""

import argparse
import logging
import os
import socket
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from endpoints.cli import front_options
from ppaas.bounded import whole
from ppaas.distribution import BASE, check_versions
from ppaas.errors import InvalidInput, Unavailable
from ppaas.log_lines import AS_JSON

if TYPE_CHECKING:
    from engine.remote.endpoint_processes import EndpointProcesses

logger = logging.getLogger(__name__)

RETRY = 2.0
"""Time between two attempts to reach a master with a secret [s]."""

HELP = "make this host a machine of a cloud on another host, until SIGTERM or Ctrl-C"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "ticket", nargs="?", metavar="TICKET", help="output of 'ppaas machine ticket' (not needed after the first join)"
    )
    parser.add_argument(
        "--join-secret-file",
        type=Path,
        metavar="FILE",
        help="file of secrets, as the cloud has it: with one of them this machine joins at --master without a ticket",
    )
    front_options.add_masters(parser)
    parser.add_argument("--name", default=socket.gethostname(), help="name of the machine (%(default)s)")
    parser.add_argument("--cores", type=whole(), help="CPUs that containers may use (all)")
    parser.add_argument(
        "--label",
        type=_label,
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="label of the machine; may be repeated",
    )
    parser.add_argument(
        "--data", type=Path, default=Path("machine"), help="folder of its key and certificate (./%(default)s)"
    )
    parser.add_argument(
        "--endpoints",
        type=whole(),
        default=0,
        metavar="NUMBER",
        help="processes that serve robots, operators and REST on this host, as those of the cloud's own host; the "
        "options below are theirs (%(default)s)",
    )
    parser.add_argument(
        "--listen",
        default="",
        metavar="HOST",
        help="host or address at which containers of other machines reach these endpoints (the one that reaches the "
        "cloud)",
    )
    front_options.add(parser)


def run(arguments: argparse.Namespace) -> int:
    """Join the cloud, then replace this process by the machine's agent."""
    if arguments.log_format == AS_JSON:  # refusals of settings are JSON, too
        front_options.take_log_format(arguments)
    check_versions(BASE, "cloud")
    # Imported here: ``ppaas --help`` loads this module.
    import asyncio  # noqa: PLC0415

    from endpoints.cli.settings_tree import MACHINE, settled  # noqa: PLC0415 - it imports this module
    from engine.remote import agent  # noqa: PLC0415
    from engine.remote.membership import join, membership_in  # noqa: PLC0415

    arguments = settled(MACHINE, arguments)
    front_options.take_log_format(arguments)
    front_options.take_traces(arguments)
    folder = arguments.data.resolve()
    endpoints = _endpoints(arguments) if arguments.endpoints else None
    if arguments.ticket is not None:
        asyncio.run(join(folder, arguments.ticket, arguments.name))
    elif arguments.join_secret_file is not None:
        asyncio.run(_join_by_secret(folder, arguments))
    membership_in(folder)  # reports errors before the process is replaced
    options = agent.MachineOptions(arguments.cores, dict(arguments.label), endpoints=endpoints)
    _replace_process(agent.__name__, folder, options)
    return 0


async def _join_by_secret(folder: Path, arguments: argparse.Namespace) -> None:
    """Join with a secret; wait for a master, as it may start after this machine."""
    import asyncio  # noqa: PLC0415

    from engine.protocols.address import parse_host_port  # noqa: PLC0415
    from engine.remote.masters import KnownMasters  # noqa: PLC0415
    from engine.remote.membership import join_by_secret  # noqa: PLC0415

    if not arguments.master:
        raise InvalidInput("--join-secret-file needs --master HOST:PORT, where the cloud listens for machines")
    masters, said = tuple(map(parse_host_port, arguments.master)), ""
    while True:
        try:
            await join_by_secret(folder, arguments.join_secret_file, arguments.name, masters)
        except Unavailable as error:
            if str(error) != said:
                said = str(error)
                logger.warning("machine %s waits for its cloud: %s", arguments.name, said)
            await asyncio.sleep(RETRY)
        else:
            KnownMasters(folder).note(map(str, masters))
            return


def _endpoints(arguments: argparse.Namespace) -> "EndpointProcesses":
    """Return the endpoint processes of the machine.

    Raises
    ------
    InvalidInput
        Their options do not fit together.
    """
    from endpoints.cloud_processes.config import front_config  # noqa: PLC0415
    from endpoints.cloud_processes.keeper import joined_processes  # noqa: PLC0415
    from endpoints.http.tls import server_tls  # noqa: PLC0415

    server_tls(arguments.tls_cert, arguments.tls_key)
    return joined_processes(arguments.endpoints, front_config(arguments, port=arguments.port), arguments.listen)


def _replace_process(module: str, folder: Path, options: object) -> None:
    import msgspec  # noqa: PLC0415

    from engine.runtimes.memory_tuning import lean_python  # noqa: PLC0415

    with tempfile.TemporaryFile() as file:
        file.write(msgspec.json.encode(options))
        file.seek(0)
        os.dup2(file.fileno(), 0)
    os.execve(
        lean_python.PYTHON[0],
        [*lean_python.PYTHON, "-m", module, str(folder)],
        lean_python.environment(),
    )


def _label(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not (key and equals and value):
        raise argparse.ArgumentTypeError(f"a label must be KEY=VALUE, not {text!r}")
    return key, value
