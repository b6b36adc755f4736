"""Planner report: writes measurements as tables and charts into a page, between two marks."""

from pathlib import Path
from typing import Any

import msgspec

from benchmarks.planners import path_lengths, scaling
from benchmarks.planners.report_sections import Measured, image, sections
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from robots.pictures.line_chart import write_chart

BEGIN, END = "<!-- planners, written by ppaas bench report -->", "<!-- end of planners -->"
NOTHING = "Nothing has been measured yet; `make performance` measures and writes this part."

_CHARTS = {"lengths": path_lengths.chart, "scaling": scaling.chart}


def read(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the measurements of a file; empty if the file does not exist.

    Raises
    ------
    InvalidInput
        The file cannot be read, or ``ppaas bench suite`` did not write it.
    """
    if not path.exists():
        return {}
    try:
        return from_json(path.read_bytes(), dict[str, list[dict[str, Any]]])
    except (OSError, msgspec.DecodeError) as error:
        raise InvalidInput(f"{path} is not a file of 'ppaas bench suite': {error}") from error


def keep(path: Path, measured: Measured) -> None:
    """Write measurements to a file.

    Raises
    ------
    InvalidInput
        The file cannot be written.
    """
    _write(path, msgspec.json.format(msgspec.json.encode(measured), indent=1).decode() + "\n")


def render(measured: Measured) -> str:
    """Return the generated part of the page."""
    return "\n\n".join(sections(measured)) or NOTHING


def write(page: Path, measured: Measured) -> None:
    """Write the part between the marks of a page, and its charts into ``images/`` beside the page.

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
        raise InvalidInput(f"{page} has no place for the report: add the lines {BEGIN!r} and {END!r}")
    for part, chart in _CHARTS.items():
        for told in measured.get(part, ()):
            write_chart(page.parent / image(part), *chart(told))
    _write(page, f"{before}{BEGIN}\n\n{render(measured)}\n\n{END}{after}")


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InvalidInput(f"cannot write {path}: {error}") from error
