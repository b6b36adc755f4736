"""Lines of the log: each record begins one line, whatever text from outside it quotes (CWE-117)."""

import logging
import textwrap
from typing import TextIO


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


def log_lines(
    form: str, *, level: int | str = logging.WARNING, dates: str | None = None, stream: TextIO | None = None
) -> None:
    """Write the log of this process to standard error, or to another stream, unless it is written already.

    Parameters
    ----------
    form : str
        Format of a line, as of ``logging.Formatter``.
    level : int or str
        Least level.
    dates : str, optional
        Format of times.
    stream : TextIO, optional
    """
    handler = logging.StreamHandler(stream)
    handler.setFormatter(LineFormatter(form, dates))
    logging.basicConfig(level=level, handlers=[handler])
