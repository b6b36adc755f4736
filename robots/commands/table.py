"""How an answer of the cloud is shown: as JSON for programs, as columns of text for people."""

import json
import sys
from collections.abc import Callable, Sequence
from typing import Any

SHORT_HASH = 12
"""Characters of a hash that tell one version from another; ``--json`` has all of them."""


def show(answer: Any, columns: Sequence[str], *, as_json: bool, if_none: str = "none") -> None:
    """Print one answer or a list of them.

    Parameters
    ----------
    answer : dict or list of dict
        From the cloud.
    columns : sequence of str
        Which of its members people see.
    as_json : bool
        Print all of it, as JSON in one line.
    if_none : str
        What people are told where the list is empty.
    """
    if as_json:
        sys.stdout.write(json.dumps(answer) + "\n")
        return
    rows = answer if isinstance(answer, list) else [answer]
    if not rows:
        sys.stdout.write(if_none + "\n")
        return
    cells = [list(columns)] + [[_cell(column, row.get(column)) for column in columns] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for line in cells:
        padded = "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        sys.stdout.write(padded.rstrip() + "\n")


def _cell(column: str, value: Any) -> str:
    return "-" if value is None else _FORMATS.get(column, _text)(value)


def _text(value: Any) -> str:
    match value:
        case float():
            return f"{value:g}"
        case list():
            return ", ".join(map(_text, value)) or "-"
        case {"id": name}:
            return str(name)
        case _:
            return str(value)


def _bytes(value: float) -> str:
    gib = value / 2**30
    return f"{gib:.1f} GiB" if gib >= 1.0 else f"{value / 2**20:.1f} MiB"


_FORMATS: dict[str, Callable[[Any], str]] = {
    "version": lambda value: str(value)[:SHORT_HASH],
    "memory": _bytes,
    "memory_used": _bytes,
    "pss": _bytes,
}
