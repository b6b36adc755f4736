"""``ppaas``: finds commands by entry point, so that a robot's install has the robot's commands and no more."""

import os
import sys
from collections.abc import Iterable
from importlib.metadata import EntryPoint, entry_points

from ppaas import __version__
from ppaas.errors import PPaaSError
from robots.cli.command_parser import CommandParser
from robots.cli.event_loop import TERMINATED, Terminated
from robots.cli.plugins import add_missing, loaded

GROUP = "ppaas.commands"

EXTRAS = {
    "fastapi": "cloud", "uvicorn": "cloud", "uvloop": "cloud", "zenoh": "cloud", "argon2": "cloud", "psutil": "cloud",
    "rich": "cloud", "pymunk": "sim", "numba": "plan", "yaml": "plan", "PIL": "plan", "defusedxml": "plan",
    "scipy": "bench", "matplotlib": "plot", "cryptography": "cloud",
}  # fmt: skip
"""Which extra brings a package that a command may miss."""


def main(argv: list[str] | None = None) -> int:
    """Run one command; return its exit status."""
    arguments = sys.argv[1:] if argv is None else argv
    try:
        parsed = _parser(entry_points(group=GROUP), arguments).parse_args(arguments)
        status: int = parsed.run(parsed)
        sys.stdout.flush()
    except PPaaSError as error:
        sys.stderr.write(f"ppaas: {error.slug}: {error}\n")
        return 1
    except ModuleNotFoundError as error:
        extra = EXTRAS.get((error.name or "").partition(".")[0])
        if extra is None:
            raise
        sys.stderr.write(f"ppaas: this command needs more: pip install 'ppaas[{extra}]' ({error.name} is missing)\n")
        return 1
    except Terminated:
        return TERMINATED
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # who read what was printed, as `head`, has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return status


def _parser(entries: Iterable[EntryPoint], arguments: list[str]) -> CommandParser:
    parser = CommandParser("ppaas", description="Path Planning as a Service: the cloud that plans and drives.")
    parser.add_argument("--version", action="version", version=f"ppaas {__version__}")
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    # Only the command that is asked for is imported; all of them are for ``--help``.
    for name, module in loaded(entries, arguments):
        if isinstance(module, ModuleNotFoundError):
            add_missing(subparsers, name, module)
            continue
        command = subparsers.add_parser(module.NAME, help=module.HELP, description=module.HELP)
        command.words = arguments[1:] if name in arguments[:1] else None
        module.configure(command)
        command.default_verb = getattr(module, "DEFAULT_VERB", None)
        command.set_defaults(run=module.run)
    return parser
