"""``ppaas``: commands found by entry point, so that a robot's install has the robot's commands and no more."""

import os
import sys
from importlib.metadata import EntryPoint, entry_points
from types import ModuleType

from ppaas import __version__
from ppaas.errors import PPaaSError
from robots.cli.command_parser import CommandParser

GROUP = "ppaas.commands"

EXTRAS = {
    "fastapi": "cloud", "uvicorn": "cloud", "uvloop": "cloud", "zenoh": "cloud", "argon2": "cloud", "psutil": "cloud",
    "rich": "cloud", "pymunk": "sim", "numba": "plan", "yaml": "plan", "PIL": "plan", "defusedxml": "plan",
    "scipy": "bench", "cryptography": "cloud",
}  # fmt: skip
"""Which extra brings a package that a command may miss."""


def main(argv: list[str] | None = None) -> int:
    """Run one command; return its exit status."""
    arguments = sys.argv[1:] if argv is None else argv
    entries = {entry.name: entry for entry in entry_points(group=GROUP)}
    try:
        parsed = _parser(entries, arguments).parse_args(arguments)
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
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # who read what was printed, as `head`, has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return status


def _parser(entries: dict[str, EntryPoint], arguments: list[str]) -> CommandParser:
    parser = CommandParser("ppaas", description="Path Planning as a Service: the cloud that plans and drives.")
    parser.add_argument("--version", action="version", version=f"ppaas {__version__}")
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    # Only the command that is asked for is imported; all of them are for ``--help``.
    asked = [name for name in entries if name in arguments[:1]] or sorted(entries)
    for name in asked:
        try:
            module: ModuleType = entries[name].load()
        except ModuleNotFoundError as error:
            if name in arguments[:1]:
                raise
            subparsers.add_parser(name, help=f"needs {error.name}, which is not installed")
            continue
        command = subparsers.add_parser(module.NAME, help=module.HELP, description=module.HELP)
        module.configure(command)
        command.default_verb = getattr(module, "DEFAULT_VERB", None)
        command.set_defaults(run=module.run)
    return parser


if __name__ == "__main__":
    sys.exit(main())
