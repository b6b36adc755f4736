"""What was measured of planners as a part of a page: tables and charts between two marks."""

from pathlib import Path
from typing import Any

import msgspec

from benchmarks.planners import path_lengths, scaling
from benchmarks.planners.report_sections import Measured, image, sections
from ppaas.errors import InvalidInput
from robots.pictures.line_chart import write_chart

BEGIN, END = "<!-- planners, written by ppaas bench report -->", "<!-- end of planners -->"
NOTHING = "Nothing was measured yet: `make performance` does, and writes it here."

_CHARTS = {"lengths": path_lengths.chart, "scaling": scaling.chart}


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
    return "\n\n".join(sections(measured)) or NOTHING


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
            write_chart(page.parent / image(part), *chart(told))
    _write(page, f"{before}{BEGIN}\n\n{render(measured)}\n\n{END}{after}")


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InvalidInput(f"cannot write {path}: {error}") from error
