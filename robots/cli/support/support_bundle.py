"""Command ``ppaas support-bundle``: writes to one file what helpers need to know of a cloud, without secrets."""

import argparse
import os
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput, PPaaSError
from robots.cli import event_loop
from robots.cli.output import print_line, show
from robots.cli.output_files import check_folder, write_file
from robots.cli.session import add_session_arguments

if TYPE_CHECKING:
    from robots.cli.support.redaction import Redaction

NAME = "support-bundle"
HELP = "write versions, health, machines, options and log lines, without secrets, to a file for support"

RESOURCES = ("machines", "endpoints", "containers")
"""Lists of the cloud that are in a bundle, for administrators."""

TIMEOUT = 20.0
"""Time limit of a request [s]."""

LOG_LINES = 5000
"""Largest number of lines of a log in a bundle: the last ones."""

LOG_LINE = 4000
"""Longest line of a log in a bundle [characters]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "The cloud need not run: what cannot be read is named in the bundle, with the reason. Maps, scans, passwords, "
        "tokens and keys are not in it; look it through before you pass it on."
    )
    parser.add_argument("file", type=Path, metavar="FILE.tar.gz", help="file to write; one that is there is replaced")
    parser.add_argument(
        "--data", type=Path, metavar="FOLDER", help="data folder of the cloud on this computer: adds sizes of its files"
    )
    parser.add_argument(
        "--log",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help=f"log of the cloud, of which the last {LOG_LINES} lines are added; may be repeated",
    )
    add_session_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Write the bundle, and print what is in it."""
    from robots.cli.support.redaction import Redaction  # noqa: PLC0415 - ``ppaas --help`` loads this module

    check_folder(arguments.file)
    redaction = Redaction(known_secrets(os.environ, arguments.token))
    logs = {f"logs/{number}-{path.name}": _tail(path, redaction) for number, path in enumerate(arguments.log, 1)}
    found = event_loop.run(_collect(arguments))
    members = {f"{name}.json": _json(redaction.value(value)) for name, value in found.items()} | logs
    write_file(arguments.file, _archive(members))
    if arguments.json:
        show({"file": str(arguments.file), "members": sorted(members)}, (), as_json=True)
    else:
        print_line(f"{arguments.file}: {', '.join(sorted(members))}")
    return 0


def known_secrets(environment: Mapping[str, str], token: str | None) -> set[str]:
    """Return the token of the user, and the secrets in the environment, also passwords in URLs as ``PPAAS_STORE``."""
    from urllib.parse import unquote, urlsplit  # noqa: PLC0415 - ``ppaas --help`` loads this module

    from robots.cli.support.redaction import is_secret_name  # noqa: PLC0415

    found = {token or ""}
    for name, value in environment.items():
        if is_secret_name(name):
            found.add(value)
        if name.startswith("PPAAS_"):
            try:
                password = urlsplit(value).password or ""
            except ValueError:  # not a URL
                continue
            found |= {password, unquote(password)}
    return found


async def _collect(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the values of a bundle by the names of their files; a problem stands for what cannot be read."""
    from robots.cli.examination import Examination, with_packages  # noqa: PLC0415 - as above
    from robots.cli.support.host import host, sizes, versions  # noqa: PLC0415
    from robots.client.cloud_url import path_of  # noqa: PLC0415
    from robots.client.rest import RestClient  # noqa: PLC0415

    client = RestClient(arguments.url, arguments.token, TIMEOUT)
    examination = Examination(arguments.url, arguments.token, 0.0)
    found: dict[str, Any] = {
        "versions": versions(),
        "host": host(),
        "options": {"url": arguments.url, **{name: os.environ[name] for name in sorted(os.environ) if _is_ours(name)}},
        "health": await _or_problem(partial(client.get, path_of("health"))),
        "doctor": await _or_problem(examination.cloud, with_packages),
    }
    for name in RESOURCES:
        found[name] = await _or_problem(partial(client.items, path_of(name)))
    if arguments.data is not None:
        found["sizes"] = sizes(arguments.data)
    return found


def _is_ours(name: str) -> bool:
    return name.startswith(("PPAAS_", "NUMBA_")) or name in ("SSL_CERT_FILE", "HTTP_PROXY", "HTTPS_PROXY", "NO_PROXY")


async def _or_problem(ask: Callable[[], Awaitable[Any]], then: Callable[[Any], Any] = lambda answer: answer) -> Any:
    try:
        return then(await ask())
    except PPaaSError as error:
        return {"problem": f"{error.slug}: {error}"}


def _tail(path: Path, redaction: "Redaction") -> bytes:
    """Return the last lines of a log, without secrets."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            lines = deque((line.rstrip("\n")[:LOG_LINE] for line in file), LOG_LINES)
    except OSError as error:
        raise InvalidInput(f"cannot read {path}: {error}") from error
    return redaction.text("\n".join([*lines, ""])).encode()


def _json(value: Any) -> bytes:
    import json  # noqa: PLC0415 - as above

    return json.dumps(value, indent=2, default=str).encode() + b"\n"


def _archive(members: Mapping[str, bytes]) -> bytes:
    """Return an archive of files, all in one folder."""
    import io  # noqa: PLC0415 - as above
    import tarfile  # noqa: PLC0415

    from ppaas.clock import epoch  # noqa: PLC0415

    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz") as archive:
        for name, content in members.items():
            entry = tarfile.TarInfo(f"ppaas-support/{name}")
            entry.size, entry.mtime, entry.mode = len(content), int(epoch()), 0o600
            archive.addfile(entry, io.BytesIO(content))
    return buffer.getvalue()
