"""What was measured of planners as a part of a page: tables and charts between two marks."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from ppaas.errors import InvalidInput
from robots.bench.planners import lengths, scaling, tables
from robots.bench.planners.chart import write_chart

BEGIN, END = "<!-- planners, written by ppaas bench report -->", "<!-- end of planners -->"
NOTHING = "Nothing was measured yet: `make performance` does, and writes it here."
IMAGES = "images"

_CHARTS = {"lengths": lengths.chart, "scaling": scaling.chart}

Measured = Mapping[str, list[dict[str, Any]]]
"""By part of the suite what was told."""


def read(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Return what was measured; nothing where there is no file yet.

    Raises
    ------
    InvalidInput
        It cannot be read, or is not what ``ppaas bench suite`` writes.
    """
    if not path.exists():
        return {}
    try:
        return msgspec.json.decode(path.read_bytes(), type=dict[str, list[dict[str, Any]]])
    except (OSError, msgspec.DecodeError) as error:
        raise InvalidInput(f"{path} is not what 'ppaas bench suite' writes: {error}") from error


def keep(path: Path, measured: Measured) -> None:
    """Write what was measured.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    _write(path, msgspec.json.format(msgspec.json.encode(measured), indent=1).decode() + "\n")


def render(measured: Measured) -> str:
    """Return the part of the page."""
    return "\n\n".join(_sections(measured)) or NOTHING


def write(page: Path, measured: Measured) -> None:
    """Put the part between the marks of a page, and its charts into ``images/`` beside it.

    Raises
    ------
    InvalidInput
        The page cannot be read or written, or has no marks.
    """
    try:
        text = page.read_text(encoding="utf-8")
    except OSError as error:
        raise InvalidInput(f"cannot read the page: {error}") from error
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise InvalidInput(f"{page} has no place for this: it goes between {BEGIN!r} and {END!r}")
    for part, chart in _CHARTS.items():
        for told in measured.get(part, ()):
            write_chart(page.parent / _image(part), *chart(told))
    _write(page, f"{before}{BEGIN}\n\n{render(measured)}\n\n{END}{after}")


def _sections(measured: Measured) -> Iterator[str]:
    if fields := measured.get("fields"):
        yield "### Full field of costs"
        yield _markdown([row for told in fields for row in tables.field_rows(told)])
    if comparisons := measured.get("comparisons"):
        yield "### Beside the peers on PyPI"
        for told in comparisons:
            yield f"{told['grid']}, {told['reached']:,} cells reached{_absent(told)}:"
            yield _markdown([_without(row, "solves") for row in tables.compare_rows(told)])
        yield "What each of them solves:"
        yield _markdown(_solved(comparisons))
    for told in measured.get("scaling", ()):
        yield "### Sizes and threads"
        yield f"![ns a cell over the size of the grid]({_image('scaling')})"
        yield "ns a cell, by edge of the grid:"
        yield _markdown(tables.scaling_rows(told))
    for told in measured.get("lengths", ()):
        yield "### Time over length of the path"
        yield f"![Time of a plan over the length of its path]({_image('lengths')})"
        yield _markdown(tables.length_rows(told))
    if scenarios := measured.get("scenarios"):
        yield "### MovingAI scenarios"
        yield _markdown([{"map": told["map"]} | row for told in scenarios for row in tables.scenario_rows(told)])


def _absent(told: dict[str, Any]) -> str:
    absent = [f"without {who}: {reason}" for who, reason in told["left_out"].items()]
    return f" ({'; '.join(absent)})" if absent else ""


def _solved(comparisons: Sequence[dict[str, Any]]) -> list[dict[str, str]]:
    """Return a row for each that was compared with, once."""
    rows = [row for told in comparisons for row in (*told["fields"], *told["paths"])]
    solved = {row["who"].partition(",")[0]: row["solves"] for row in rows}
    return [{"who": who, "solves": solves} for who, solves in solved.items()]


def _without(row: dict[str, str], column: str) -> dict[str, str]:
    return {name: text for name, text in row.items() if name != column}


def _markdown(rows: Sequence[dict[str, str]]) -> str:
    """Return a table; columns of numbers are flush right."""
    columns = list(rows[0])
    rule = ["---" if any(row[column][:1].isalpha() for row in rows) else "---:" for column in columns]
    lines = [columns, rule, *([row[column] for column in columns] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _image(part: str) -> str:
    return f"{IMAGES}/planners-{part}.png"


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InvalidInput(f"cannot write {path}: {error}") from error
