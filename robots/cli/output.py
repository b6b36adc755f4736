"""Output of commands: JSON for programs, tables for people."""

import json
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

SHORT_HASH = 12
"""Characters of a version's hash in tables; ``--json`` prints all of them."""


def show(answer: Any, columns: Sequence[str], *, as_json: bool, if_none: str = "none") -> None:
    """Print one object or a list of objects.

    Parameters
    ----------
    answer : dict or list of dict
        Response of the cloud.
    columns : sequence of str
        Members that the table shows.
    as_json : bool
        Print the complete response as one line of JSON.
    if_none : str
        Text that replaces the table of an empty list.
    """
    if as_json:
        print_line(json.dumps(answer))
        return
    rows = answer if isinstance(answer, list) else [answer]
    if not rows:
        sys.stdout.write(if_none + "\n")
        return
    sys.stdout.writelines(line + "\n" for line in table(rows, columns))


def print_line(text: str) -> None:
    """Print a line."""
    sys.stdout.write(text + "\n")


def print_warnings(answer: dict[str, Any]) -> None:
    """Print the warnings of an answer of the cloud, each in a line."""
    for warning in answer.get("warnings", ()):
        print_line(f"warning: {printable(warning)}")


def table(rows: Sequence[dict[str, Any]], columns: Sequence[str]) -> list[str]:
    """Return the lines of a table, heading first; each column is as wide as its widest cell."""
    cells = [list(columns)] + [[cell(column, row.get(column)) for column in columns] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return ["  ".join(map(str.ljust, line, widths)).rstrip() for line in cells]


def cell(column: str, value: Any) -> str:
    """Return the text of a value in a column."""
    return "-" if value is None else _FORMATS.get(column, _text)(value)


def _text(value: Any) -> str:
    match value:
        case float():
            return f"{value:g}"
        case list():
            return ", ".join(map(_text, value)) or "-"
        case bool():
            return "yes" if value else "no"
        case {"id": name}:
            return _text(name)
        case dict():
            return ", ".join(f"{key}={_text(each)}" for key, each in sorted(value.items())) or "-"
        case _:
            return printable(str(value))


def printable(text: str) -> str:
    """Return a text with its control characters replaced, which a terminal would interpret."""
    return "".join(character if character.isprintable() else "\N{REPLACEMENT CHARACTER}" for character in text)


def printable_lines(text: str) -> str:
    """Return a text of several lines with its other control characters replaced."""
    return "\n".join(map(printable, text.split("\n")))


def _date(value: float) -> str:
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(value)) if value else "-"


def _moment(value: float) -> str:
    return time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(value))


def duration(seconds: float) -> str:
    """Return a duration [s] in its two largest units."""
    whole = int(seconds)
    for unit, size, part, step in (("d", 86400, "h", 3600), ("h", 3600, "m", 60), ("m", 60, "s", 1)):
        if whole >= size:
            return f"{whole // size}{unit} {whole % size // step}{part}"
    return f"{whole}s"


def percent(cores: float) -> str:
    """Return a load in cores as a percentage of one core."""
    return f"{cores * 100:.0f} %"


def size(value: float) -> str:
    """Return a number of bytes in MiB or GiB."""
    gib = value / 2**30
    return f"{gib:.1f} GiB" if gib >= 1.0 else f"{value / 2**20:.1f} MiB"


def _share(value: float) -> str:
    return f"{100 * value:.0f} %"


def _ago(seconds: float) -> str:
    return f"{duration(seconds)} ago" if seconds else "now"


def _milliseconds(seconds: float) -> str:
    return f"{seconds * 1e3:.1f} ms"


def _per_second(value: float) -> str:
    return f"{size(value)}/s"


def _kernels(value: dict[str, Any]) -> str:
    return f"{value['done']} of {value['total']}"


_FORMATS: dict[str, Callable[[Any], str]] = {
    "version": lambda value: str(value)[:SHORT_HASH],
    "memory": size,
    "max_memory": size,
    "memory_used": size,
    "pss": size,
    "created": _date,
    "expires": _date,
    "disconnected_since": _moment,
    "since": _moment,
    "last_run": _moment,
    "before": _moment,
    "time": _moment,
    "age": duration,
    "seen_ago": _ago,
    "battery": _share,
    "cpu": percent,
    "kernels": _kernels,
    "network": _per_second,
    "network_used": _per_second,
    "round_trip": _milliseconds,
}
