"""Lines of the log: each record begins one line, whatever text from outside it quotes (CWE-117).

The environment variable ``PPAAS_LOG_FORMAT`` selects lines for people or, as ``json``, one JSON object a line. It is
inherited with the environment, so all processes of a cloud agree.
"""

import datetime
import json
import logging
import os
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from types import TracebackType
from typing import TextIO

VARIABLE, AS_JSON = "PPAAS_LOG_FORMAT", "json"

FIELDS = ("robot", "goal", "request")
"""Members of a JSON line that say whom or what a record is about, where it is known; also names for ``extra``."""

_known: ContextVar[dict[str, str]] = ContextVar("fields of the log", default={})  # noqa: B039 - never changed


@contextmanager
def log_fields(**fields: str) -> Iterator[None]:
    """Add `FIELDS` to the JSON lines of this task, and of those that it starts, until the end of the block."""
    token = _known.set(_known.get() | fields)
    try:
        yield
    finally:
        _known.reset(token)


def known_fields() -> dict[str, str]:
    """Return the `FIELDS` of this task."""
    return _known.get()


_more: Callable[[], dict[str, str]] = dict


def log_also(members: Callable[[], dict[str, str]]) -> None:
    """Add to the JSON lines the members that a function returns for the task that writes one."""
    global _more  # noqa: PLW0603 - as the logging of a process, there is one
    _more = members


def escaped(text: str) -> str:
    """Return a text with escapes for line ends, control codes of terminals, and all else that cannot be printed."""
    if text.isprintable():
        return text
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in text)


class LineFormatter(logging.Formatter):
    """Formats a record as one line; a traceback follows in lines that are indented, as no record is."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - of logging
        """Return the line of a record."""
        return escaped(super().formatMessage(record))

    def formatException(self, ei: "logging._SysExcInfoType") -> str:  # noqa: N802 - of logging
        """Return the lines of a traceback."""
        return _indented(super().formatException(ei))

    def formatStack(self, stack_info: str) -> str:  # noqa: N802 - of logging
        """Return the lines of a stack."""
        return _indented(super().formatStack(stack_info))


def _indented(lines: str) -> str:
    return textwrap.indent("\n".join(map(escaped, lines.split("\n"))), "  ", lambda _: True)


class JsonFormatter(logging.Formatter):
    """Formats a record as one JSON object.

    Its members are ``time`` (RFC 3339, UTC), ``level``, ``logger``, ``process``, ``message``, those of `FIELDS` that
    are known, ``trace_id`` and ``span_id`` of a trace, and ``exception`` and ``stack`` with line ends where there are
    some.

    Parameters
    ----------
    process : str
        Name of this process.
    """

    def __init__(self, process: str) -> None:
        super().__init__()
        self._process = process

    def format(self, record: logging.LogRecord) -> str:
        """Return the line of a record."""
        given = {name: str(getattr(record, name)) for name in FIELDS if hasattr(record, name)}
        moment = datetime.datetime.fromtimestamp(record.created, datetime.UTC)
        entry = {
            "time": moment.isoformat(timespec="milliseconds").replace("+00:00", "Z"),
            "level": record.levelname,
            "logger": record.name,
            "process": self._process,
            "message": record.getMessage(),
            **_known.get(),
            **given,
            **_more(),
        }
        if record.exc_info:
            entry["exception"] = self.formatException(record.exc_info)
        if record.stack_info:
            entry["stack"] = self.formatStack(record.stack_info)
        return json.dumps(entry)


def is_json() -> bool:
    """Return whether this process writes its log as JSON."""
    return os.environ.get(VARIABLE) == AS_JSON


def log_lines(
    form: str,
    *,
    process: str = "ppaas",
    level: int | str = logging.WARNING,
    dates: str | None = None,
    stream: TextIO | None = None,
) -> None:
    """Write the log of this process to standard error, or to another stream, unless it is written already.

    As JSON, warnings of Python and the exception that ends this process are records as well.

    Parameters
    ----------
    form : str
        Format of a line for people, as of ``logging.Formatter``.
    process : str
        Name of this process in JSON.
    level : int or str
        Least level.
    dates : str, optional
        Format of times for people.
    stream : TextIO, optional
    """
    handler = logging.StreamHandler(stream)
    handler.setFormatter(JsonFormatter(process) if is_json() else LineFormatter(form, dates))
    logging.basicConfig(level=level, handlers=[handler])
    if is_json():
        logging.captureWarnings(True)
        sys.excepthook = _log_the_end


def _log_the_end(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    logging.getLogger(__name__).critical("this process ends by %s", kind.__name__, exc_info=(kind, error, trace))


def refusal(slug: str, text: str) -> str:
    """Return the line by which a command reports why it ends."""
    if is_json():
        record = logging.LogRecord("ppaas", logging.ERROR, "", 0, "%s: %s", (slug, text), None)
        return f"{JsonFormatter('ppaas').format(record)}\n"
    return f"ppaas: {slug}: {text}\n"
