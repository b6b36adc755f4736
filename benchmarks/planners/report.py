"""Planner report: tables and charts of each part of the suite, written into a page between two marks."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from benchmarks.planners import path_lengths, peers, scaling, tables
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from robots.pictures.line_chart import write_chart

IMAGES = "images"

IDLE = 0.5
"""Largest load average of the last minute at which a measurement counts as undisturbed [CPUs]."""

Measured = Mapping[str, list[dict[str, Any]]]
"""Results by part of the suite."""


def sections(measured: Measured) -> Iterator[str]:
    """Return the paragraphs of the report, including tables and images."""
    for told in measured.get("machine", ()):
        yield _machine(told)
    if fields := measured.get("fields"):
        yield from _fields(fields)
    if comparisons := measured.get("comparisons"):
        yield from _comparisons(comparisons)
    for told in measured.get("scaling", ()):
        yield "### Sizes and threads"
        yield _image("scaling", "ns per reached cell over the size of the grid")
        yield (
            "ns per reached cell, by edge length of the grid. *Max / min* is the ratio of the largest to the smallest "
            f"value from 512² on; the aim is at most {tables.SPREAD_AIM:g}:"
        )
        yield _markdown(tables.scaling_rows(told))
    for told in measured.get("lengths", ()):
        yield from _lengths(told)
    if scenarios := measured.get("scenarios"):
        yield from _scenarios(scenarios)
    if indexes := measured.get("indexes"):
        yield from _indexes(indexes)


def _machine(told: dict[str, Any]) -> str:
    vectors = "with" if told["avx512"] else "without"
    text = (
        f"Measured on {told['cpus']} CPUs, {told['processor']} {vectors} AVX-512, under {told['system']}, by ppaas "
        f"{told['ppaas']} on Python {told['python']}, numba {told['numba']} and numpy {told['numpy']}."
    )
    if told["load"] > IDLE:
        text += f" **Other processes kept {told['load']:.1f} CPUs busy at the start: not suitable for comparison.**"
    return f"{text} **A quick run on small grids: not suitable for comparison.**" if told["quick"] else text


def _fields(fields: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield "### Full cost field"
    yield (
        "The cost from every reachable cell of the map to one goal. The planner starts from the bytes of a costmap "
        "that it has not seen before. *Repeat* is a second field on the same map, whose tile tables it has cached."
    )
    yield _markdown([row for told in fields for row in tables.field_rows(told | {"beside": {}})])
    others = list(dict.fromkeys(name for told in fields for name in (*told["beside"], *told["left_out"])))
    if not others:
        return
    yield "### Speed-up over other implementations"
    yield (
        "The same fields in the same run, setup included: the time of each other implementation, divided by ours on "
        "that number of threads. *Aim* is the ratio that we want to reach. The others solve:"
    )
    yield "\n".join(f"- {name}: {peers.BESIDE[name].solves}." for name in others)
    yield _markdown([row for told in fields for row in tables.beside_rows(told, others)])
    yield from _left_out(fields)


def _comparisons(comparisons: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield "### Comparison with packages from PyPI"
    yield (
        "*× ours* is the time, divided by the time of our fastest planner with the right answer. *Error* is the mean "
        "relative error of the values of a field, or the relative excess cost of a path over the cheapest; it is "
        "negative for some paths that cut corners. *Preparation* is not part of the time: it builds an index, or "
        "converts the map to the input of a library. *Drivable* is a field that reaches the same cells as ours, or a "
        "path that cuts no corner."
    )
    for told in comparisons:
        yield f"{told['grid']}, {told['reached']:,} cells reached, and the longest path to the goal:"
        yield _markdown([_without(row, "solves") for row in tables.compare_rows(told)])
        yield from _left_out([told])
    yield "The problems that they solve:"
    yield _markdown(_solved(comparisons))


def _lengths(told: dict[str, Any]) -> Iterator[str]:
    yield "### Planning time over path length"
    yield (
        "Fig. 3 of the paper: paths of increasing length to one goal. They are planned by one thread of the bench's "
        "own process, by as many threads as the container has, by navfn, and by the container of a robot, timed from "
        "the request over its WebSocket to the answer. Every path is planned from scratch."
    )
    yield _image("lengths", "Planning time over path length")
    yield _markdown(tables.length_rows(told))


def _scenarios(scenarios: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield "### MovingAI scenarios"
    yield (
        "Each query is timed alone, including its path of cells. Planners that prepare the map answer all queries of "
        "a scenario; the others answer a sample that covers the whole scenario."
    )
    yield from _answered(scenarios, _of_map, "map")


def _of_map(told: dict[str, Any]) -> list[dict[str, str]]:
    return [{"map": told["map"]} | row for row in tables.scenario_rows(told)]


def _indexes(indexes: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield "### Indexes"
    yield (
        "The index of a grid, built on one thread and on several, and queries between random cells. *Wrong* counts "
        "the queries whose path is not as long as jps's. The aim for an index of 1024² is at most 5 s on two "
        "threads, and 40 MB."
    )
    yield from _answered(indexes, tables.index_rows, "grid")


def _answered(
    told: Sequence[dict[str, Any]], rows_of: Callable[[dict[str, Any]], list[dict[str, str]]], where: str
) -> Iterator[str]:
    """Return the table of answered queries, and the list of what was left out."""
    rows = [row for one in told if "mean_us" in one for row in rows_of(one)]
    if rows:
        yield _markdown(rows)
    yield from _left_out([one for one in told if "left_out" in one], where)


def _left_out(told: Sequence[dict[str, Any]], where: str = "grid") -> Iterator[str]:
    """Return the list of what was not measured on which grids, with the reasons."""
    grids: dict[tuple[str, str], list[str]] = {}
    for one in told:
        for who, reason in one["left_out"].items():
            grids.setdefault((who, reason), []).append(one[where])
    lines = [f"- {who} on {', '.join(names)}: {reason}" for (who, reason), names in grids.items()]
    if lines:
        yield "Left out:"
        yield "\n".join(lines)


def _solved(comparisons: Sequence[dict[str, Any]]) -> list[dict[str, str]]:
    """Return one row for each implementation in the comparisons."""
    rows = [row for told in comparisons for row in (*told["fields"], *told["paths"])]
    solved = {row["who"].partition(",")[0]: row["solves"] for row in rows}
    return [{"implementation": name, "solves": problem} for name, problem in solved.items()]


def _without(row: dict[str, str], column: str) -> dict[str, str]:
    return {name: text for name, text in row.items() if name != column}


def _markdown(rows: Sequence[dict[str, str]]) -> str:
    """Return a Markdown table; columns of numbers are aligned right."""
    columns = list(rows[0])
    rule = ["---" if any(row[column][:1].isalpha() for row in rows) else "---:" for column in columns]
    lines = [columns, rule, *([row[column] for column in columns] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _image(part: str, shows: str) -> str:
    return f"![{shows}]({image(part)})"


def image(part: str) -> str:
    """Return the path of the chart for a part of the suite, relative to the page."""
    return f"{IMAGES}/planners-{part}.png"


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
