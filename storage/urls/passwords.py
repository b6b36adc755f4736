"""Passwords of stores from files and the environment, so that they need not be in the arguments of a process.

Every user of a computer can read the arguments of all processes (proc(5)); the shell keeps them in its history, and
``docker inspect`` shows them.
"""

import logging
import os
import stat
from collections.abc import MutableMapping
from pathlib import Path
from urllib.parse import parse_qsl, quote, urlencode, urlsplit, urlunsplit

from ppaas.errors import InvalidInput
from storage.urls.registry import MAP_STORES, STORES

logger = logging.getLogger(__name__)

PASSWORD_FILE = "password_file"
"""Setting of a URL: path of the file with the password."""

MAX_SECRET = 65536
"""Largest size of a file with a password or a URL [bytes]."""


def with_password(url: str) -> str:
    """Return a URL with the password of its ``password_file`` in the place of that setting; others unchanged.

    Raises
    ------
    InvalidInput
        The file cannot be read, the URL names no user or has a password already, or its store takes none. The text
        contains no password.
    """
    if PASSWORD_FILE not in url:
        return url
    try:
        parts = urlsplit(url)
        settings = parse_qsl(parts.query, keep_blank_values=True)
    except ValueError:
        return url  # the store reports what is wrong with it
    files = [value for name, value in settings if name == PASSWORD_FILE]
    if not files:
        return url
    login, at, hosts = parts.netloc.rpartition("@")
    if not any(parts.scheme in kind and kind.load(parts.scheme).takes_password for kind in (STORES, MAP_STORES)):
        raise InvalidInput(f"{parts.scheme}: stores take no password: remove {PASSWORD_FILE}")
    if len(files) > 1 or not at or not login or ":" in login:
        raise InvalidInput(f"{PASSWORD_FILE} needs a user without a password: write {parts.scheme}://user@host/…")
    password = quote(read_secret(Path(files[0])), safe="")
    rest = urlencode([(name, value) for name, value in settings if name != PASSWORD_FILE])
    return urlunsplit(parts._replace(netloc=f"{login}:{password}@{hosts}", query=rest))


def read_secret(file: Path) -> str:
    """Return the content of a file without white space around it; warn if other users may read the file.

    Raises
    ------
    InvalidInput
        The file cannot be read, is empty, or is too large.
    """
    try:
        with file.open("rb") as opened:
            mode, content = os.fstat(opened.fileno()).st_mode, opened.read(MAX_SECRET + 1)
        text = content.decode().strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read {file}: {error}") from error
    if not text or len(content) > MAX_SECRET:
        raise InvalidInput(f"{file} must contain one line of text")
    if stat.S_IMODE(mode) & 0o077 and not stat.S_ISFIFO(mode):
        logger.warning("other users of this computer may read %s: run 'chmod go= %s'", file, file)
    return text


def chosen_url(
    option: str, url: str | None, file: Path | None, variable: str, environment: MutableMapping[str, str]
) -> str | None:
    """Return the URL of a store from an argument, a file or the environment, in this order; None if there is none.

    The variable is removed from the environment, so that child processes, which may run plug-ins, do not inherit it.

    Parameters
    ----------
    option : str
        Name of the option, such as ``--store``; the one for a file is ``--store-file``.
    url : str or None
        Value of the option.
    file : Path or None
        Value of the option for a file.
    variable : str
        Name of the environment variable.
    environment : mapping
        The environment.

    Raises
    ------
    InvalidInput
        Both options are given, or a file cannot be read.
    """
    inherited = environment.pop(variable, None) or None
    if url is not None and file is not None:
        raise InvalidInput(f"give either {option} or {option}-file")
    if url is not None:
        warn_if_visible(url, option, f"{option}-file FILE, the variable {variable}, or {PASSWORD_FILE}=FILE in the URL")
    found = read_secret(file) if file is not None else url or inherited
    return None if found is None else with_password(found)


def warn_if_visible(url: str, argument: str, instead: str = f"{PASSWORD_FILE}=FILE in the URL") -> None:
    """Log a warning if the URL in an argument has a password, with what to use instead; the text has no password."""
    try:
        has_password = bool(urlsplit(url).password)
    except ValueError:
        return  # the store reports what is wrong with it
    if has_password:
        logger.warning("the password in %s is visible to every user of this computer: use %s", argument, instead)
