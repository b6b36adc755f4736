"""What the page tells of what was measured: a section for each part of the suite."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from benchmarks.planners import peers, tables

IMAGES = "images"

IDLE = 0.5
"""CPUs that may have been busy in the minute before, on average."""

Measured = Mapping[str, list[dict[str, Any]]]
"""By part of the suite what was told."""


def sections(measured: Measured) -> Iterator[str]:
    """Return the paragraphs of the part, tables and images among them."""
    for told in measured.get("machine", ()):
        yield _machine(told)
    if fields := measured.get("fields"):
        yield from _fields(fields)
    if comparisons := measured.get("comparisons"):
        yield from _comparisons(comparisons)
    for told in measured.get("scaling", ()):
        yield "### Sizes and threads"
        yield _image("scaling", "ns a cell over the size of the grid")
        yield (
            "ns for each cell that is reached, by edge of the grid; *most / least* is of grids from 512² on, and is "
            f"meant to be at most {tables.SPREAD_AIM:g}:"
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
        text += f" **Other work kept {told['load']:.1f} of them busy when it began: not to compare by.**"
    return f"{text} **A quick run on small grids, not to compare by.**" if told["quick"] else text


def _fields(fields: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield "### Full field of costs"
    yield (
        "From one goal all over the map, from the bytes of a costmap that the planner has not seen before. *Again* is "
        "the same map once more, of which it kept what it had laid out."
    )
    yield _markdown([row for told in fields for row in tables.field_rows(told | {"beside": {}})])
    others = list(dict.fromkeys(name for told in fields for name in (*told["beside"], *told["left_out"])))
    if not others:
        return
    yield "### Times faster than others"
    yield (
        "The same fields in the same run, setting up included, how many times longer others took than ours on that "
        "many threads. *Aim* is what we want to reach. What the others solve:"
    )
    yield "\n".join(f"- {name}: {peers.BESIDE[name].solves}." for name in others)
    yield _markdown([row for told in fields for row in tables.beside_rows(told, others)])
    yield from _left_out(fields)


def _comparisons(comparisons: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield "### Beside the peers on PyPI"
    yield (
        "*× ours* is how many times longer than the fastest of ours with the right answer it took. *Off* is by how "
        "much the values of a field differ from the exact ones in the mean, or by how much a path is dearer than the "
        "cheapest; one that cuts corners may be cheaper. *Prepared* is what goes before and is not timed: an index, or "
        "what a library wants a map to be like."
    )
    for told in comparisons:
        yield f"{told['grid']}, {told['reached']:,} cells reached, and the longest path to the goal:"
        yield _markdown([_without(row, "solves") for row in tables.compare_rows(told)])
        yield from _left_out([told])
    yield "What each of them solves:"
    yield _markdown(_solved(comparisons))


def _lengths(told: dict[str, Any]) -> Iterator[str]:
    yield "### Time over length of the path"
    yield (
        "Fig. 3 of the paper: longer and longer paths to one goal, by one thread of this process, and by the container "
        "of a robot, from the request over its WebSocket to the answer; all are planned anew each time. Beside them "
        "the same threads without a container, and navfn."
    )
    yield _image("lengths", "Time of a plan over the length of its path")
    yield _markdown(tables.length_rows(told))


def _scenarios(scenarios: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield "### MovingAI scenarios"
    yield (
        "Each query by itself, its path of cells included. Planners that prepare the map answer all queries of a "
        "scenario, the others some from all over it."
    )
    yield from _answered(scenarios, _of_map, "map")


def _of_map(told: dict[str, Any]) -> list[dict[str, str]]:
    return [{"map": told["map"]} | row for row in tables.scenario_rows(told)]


def _indexes(indexes: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield "### Indexes"
    yield (
        "An index of a grid, made on one thread and on more, and queries between cells that are drawn at random. "
        "*Wrong* are those whose path is not as long as that of jps. An index of 1024² is meant to take at most 5 s on "
        "two threads, and 40 MB."
    )
    yield from _answered(indexes, tables.index_rows, "grid")


def _answered(
    told: Sequence[dict[str, Any]], rows_of: Callable[[dict[str, Any]], list[dict[str, str]]], where: str
) -> Iterator[str]:
    """Tell how queries were answered, and who was left out."""
    rows = [row for one in told if "mean_us" in one for row in rows_of(one)]
    if rows:
        yield _markdown(rows)
    yield from _left_out([one for one in told if "left_out" in one], where)


def _left_out(told: Sequence[dict[str, Any]], where: str = "grid") -> Iterator[str]:
    """Tell who was not measured on which grids, and why."""
    grids: dict[tuple[str, str], list[str]] = {}
    for one in told:
        for who, reason in one["left_out"].items():
            grids.setdefault((who, reason), []).append(one[where])
    lines = [f"- {who} on {', '.join(names)}: {reason}" for (who, reason), names in grids.items()]
    if lines:
        yield "Left out:"
        yield "\n".join(lines)


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


def _image(part: str, shows: str) -> str:
    return f"![{shows}]({image(part)})"


def image(part: str) -> str:
    """Return where the chart of a part of the suite is, seen from the page."""
    return f"{IMAGES}/planners-{part}.png"
