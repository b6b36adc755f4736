"""``ppaas machine join``: make this host a machine of a cloud on another one."""

import argparse
import os
import socket
import tempfile
from pathlib import Path

from ppaas.bounded_numbers import whole

HELP = "make this host a machine of a cloud on another host, until SIGTERM or Ctrl-C"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "ticket", nargs="?", metavar="TICKET", help="output of 'ppaas machine ticket' (not needed after the first join)"
    )
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


def run(arguments: argparse.Namespace) -> int:
    """Join the cloud, then replace this process by the machine's agent."""
    # Imported here: ``ppaas --help`` loads this module.
    import asyncio  # noqa: PLC0415

    from engine.remote import agent  # noqa: PLC0415
    from engine.remote.membership import join, membership_in  # noqa: PLC0415

    folder = arguments.data.resolve()
    if arguments.ticket is not None:
        asyncio.run(join(folder, arguments.ticket, arguments.name))
    membership_in(folder)  # reports errors before the process is replaced
    _replace_process(agent.__name__, folder, agent.MachineOptions(arguments.cores, dict(arguments.label)))
    return 0


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
