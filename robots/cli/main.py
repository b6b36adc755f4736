"""Command line ``ppaas``: finds the commands by their entry points and runs one."""

import os
import sys
from importlib.metadata import entry_points

from ppaas import __version__
from ppaas.distribution import BASE, install_hint, misfits, pip_command
from ppaas.errors import PPaaSError
from robots.cli.command_parser import CommandParser
from robots.cli.event_loop import TERMINATED, Terminated
from robots.cli.output import printable_lines
from robots.cli.plugins import installed

GROUP = "ppaas.commands"
"""Group of the commands' entry points."""

EXTRAS = {
    "fastapi": "cloud", "uvicorn": "cloud", "uvloop": "cloud", "zenoh": "cloud", "argon2": "cloud", "psutil": "cloud",
    "rich": "cloud", "pymunk": "sim", "numba": "plan", "yaml": "plan", "PIL": "plan", "defusedxml": "plan",
    "scipy": "bench", "matplotlib": "plot", "cryptography": "cloud", "endpoints": "cloud", "engine": "cloud",
    "storage": "cloud", "aiomqtt": "vda5050", "shtab": "completion",
    "luaparser": "imports", "xacro": "imports", "authlib": "oidc", "joserfc": "oidc", "httpx2": "oidc",
    "mcp": "mcp", "mcp_types": "mcp",
}  # fmt: skip
"""Extra that installs a package, for the packages that a command may miss."""

OWN_PACKAGES = frozenset({"endpoints", "engine", "storage"})
"""Packages of the cloud in this repository; the robot's commands work without them."""


def main(argv: list[str] | None = None) -> int:
    """Run one command; return its exit status."""
    arguments = sys.argv[1:] if argv is None else argv
    try:
        parsed = parser_of(arguments).parse_args(arguments)
        if argv is None and parsed.niceness:  # a caller in the same process keeps its priority
            os.nice(parsed.niceness)
        status: int = parsed.run(parsed)
        sys.stdout.flush()
    except PPaaSError as error:
        from ppaas.log_lines import refusal  # noqa: PLC0415 - loads logging, which most commands need not

        sys.stderr.write(refusal(error.slug, printable_lines(str(error))))
        return 1
    except ImportError as error:
        words = _words_on(error)
        if words is None:
            raise
        sys.stderr.write(f"ppaas: {words}\n")
        return 1
    except Terminated:
        return TERMINATED
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # the reader of the output, such as `head`, has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return status


def _words_on(error: ImportError) -> str | None:
    """Return why a package could not be imported and what to do; None if the error is a fault of ours."""
    package = (error.name or "").partition(".")[0]
    for unfit in misfits(BASE, *filter(None, [EXTRAS.get(package)])):  # an old version may lack what is imported
        if unfit.requirement.package == package:
            return f"this command does not work with {unfit}; run: {pip_command([unfit])}"
    extra = _extra_of(error.name or "") if isinstance(error, ModuleNotFoundError) else None
    if extra is None:
        return None
    return f"this command needs the extra {extra!r} ({error.name} is not installed): {install_hint(extra)}"


def _extra_of(module: str) -> str | None:
    """Return the extra that installs a missing module; None if the error is a fault of ours."""
    package = module.partition(".")[0]
    # A module missing inside one of our packages is a fault, but a package missing as a whole is not installed.
    return None if package in OWN_PACKAGES and package != module else EXTRAS.get(package)


def parser_of(arguments: list[str]) -> CommandParser:
    """Return the parser of the command that some arguments name, or of all commands if they name none."""
    parser = CommandParser("ppaas", description="Path Planning as a Service: the cloud that plans and drives.")
    parser.add_argument("--version", action="version", version=f"ppaas {__version__}")
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    listed = arguments[:1] in (["-h"], ["--help"])  # shows names and helps alone; all options would take half its time
    # Import only the command that is called; ``--help`` imports all.
    for name, module in installed(subparsers, entry_points(group=GROUP), arguments):
        command = subparsers.add_parser(module.NAME, help=module.HELP, description=module.HELP)
        command.words = arguments[1:] if name in arguments[:1] else None
        if not listed:
            module.configure(command)
        command.default_verb = getattr(module, "DEFAULT_VERB", None)
        command.set_defaults(run=module.run, niceness=getattr(module, "NICENESS", 0))
    return parser
