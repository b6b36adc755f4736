"""``ppaas bench field|scenario|index|compare|scaling|fig3``: how fast planners plan, and how right they are."""

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.cli.output import show

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.planners.grids import Grid

HELP = {
    "field": "the full field of costs from one goal",
    "scenario": "every query of a MovingAI scenario, and how many lengths are wrong",
    "index": "an index of one grid, by number of threads, and how right its queries are",
    "compare": "the same grid by the peers that are installed from PyPI",
    "scaling": "the field on grids from 256² up, by number of threads",
    "fig3": "time over length of the path: one thread here, a container of many cores, and navfn",
}

LONGEST_PAUSE = 60.0
"""Between two fields [s]."""

Tell = Callable[[argparse.Namespace, "Progress"], tuple[dict[str, Any], list[dict[str, str]]]]


def configure(kinds: Any) -> None:
    """Add the verbs and their arguments to the subparsers of ``ppaas bench``."""
    verbs = {name: kinds.add_parser(name, help=text, description=text) for name, text in HELP.items()}
    for name in ("field", "compare", "index"):
        _add_grid_arguments(verbs[name])
    for name in ("field", "compare"):
        verbs[name].add_argument("--goal", type=int, nargs=2, metavar=("R", "C"), help="row, column (near the middle)")
    for name in ("field", "compare", "scaling", "index"):
        verbs[name].add_argument("--threads", type=_numbers, metavar="1,2", help="(1 and as many as there are CPUs)")
    for name in ("field", "scaling", "fig3"):
        verbs[name].add_argument("--plot", type=Path, metavar="OUT.png", help=_PLOTS[name])
    _configure_scenario(verbs["scenario"])
    verbs["field"].add_argument("--beside", type=_names, default=[], metavar="A,B", help="navfn, or packages of peers")
    verbs["field"].add_argument(
        "--pause", type=_pause, metavar="S", help="tell what a field takes that long after another"
    )
    verbs["compare"].add_argument("--only", action="append", metavar="PACKAGE", help="a peer; all that are installed")
    verbs["index"].add_argument("--planner", default="hub_labels", help="one that prepares a map (%(default)s)")
    verbs["scaling"].add_argument("--kind", action="append", help="of grid (empty, random 20 %%, maze)")
    verbs["scaling"].add_argument("--largest", type=int, default=8192, metavar="N", help="edge in cells (%(default)s)")
    verbs["fig3"].add_argument("--map", type=Path, help="YAML file or MovingAI map (a warehouse of 120 by 80 m)")
    verbs["fig3"].add_argument("--cores", type=int, default=2, help="of the container (%(default)s)")
    for name, verb in verbs.items():
        verb.add_argument("--json", action="store_true", help="print the result as one JSON object")
        verb.set_defaults(what=name)


_PLOTS = {
    "field": "draw the time of a plan over the length of its path, by number of threads",
    "scaling": "draw ns a cell over the size",
    "fig3": "draw it",
}


def _add_grid_arguments(parser: argparse.ArgumentParser) -> None:
    grid = parser.add_mutually_exclusive_group(required=True)
    grid.add_argument("--map", type=Path, metavar="FILE", help="YAML file, MovingAI map, or PGM of a costmap")
    grid.add_argument("--empty", type=int, metavar="N", help="N×N free cells")
    grid.add_argument("--random", type=float, nargs=2, metavar=("N", "PERCENT"), help="so many percent blocked")
    grid.add_argument("--maze", type=int, nargs="+", metavar="N", help="N [WIDTH of its corridors, 1]")
    parser.add_argument("--tiles", type=int, default=1, metavar="N", help="N by N copies of it, side by side")


def _configure_scenario(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenario", type=Path, metavar="FILE.scen")
    parser.add_argument("--map", type=Path, metavar="FILE.map", help="(beside the scenario, of the same name)")
    parser.add_argument("--planner", default="dijkstra", help="any that is installed (%(default)s)")
    parser.add_argument("--limit", type=int, metavar="N", help="the first N queries (all)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Callable[[], None]:
    """Measure, and draw where that is asked for; return what prints the result."""
    if getattr(arguments, "plot", None) is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415 - so here and below: ``ppaas --help`` loads this

        check_picture(arguments.plot)
    told, rows = _VERBS[arguments.what](arguments, progress)
    if arguments.json:
        return lambda: show(told, (), as_json=True)
    return lambda: show(rows, tuple(rows[0]), as_json=False)


def _field(arguments: argparse.Namespace, progress: "Progress") -> tuple[dict[str, Any], list[dict[str, str]]]:
    import asyncio  # noqa: PLC0415

    from benchmarks.planners import field, path_lengths, tables  # noqa: PLC0415
    from benchmarks.planners.peers import beside  # noqa: PLC0415

    grid, threads = _grid(arguments), _threads(arguments)
    others = beside(arguments.beside)
    told = field.measure(grid, _goal(arguments), threads, progress, others=others)
    _tell_left_out(told, progress)
    if arguments.pause is not None:
        told["paused_seconds"] = field.now_and_then(grid, tuple(told["goal"]), threads, arguments.pause, progress)
    if arguments.plot is not None:
        _plot(
            arguments.plot,
            path_lengths.chart(asyncio.run(path_lengths.measure_locally(grid.costmap, threads, progress))),
        )
    return told, tables.field_rows(told)


def _scenario(arguments: argparse.Namespace, progress: "Progress") -> tuple[dict[str, Any], list[dict[str, str]]]:
    from benchmarks.planners import scenario, tables  # noqa: PLC0415

    told = scenario.measure(arguments.scenario, arguments.map, arguments.planner, arguments.limit, progress)
    return told, tables.scenario_rows(told)


def _index(arguments: argparse.Namespace, progress: "Progress") -> tuple[dict[str, Any], list[dict[str, str]]]:
    from benchmarks.planners import index, tables  # noqa: PLC0415

    told = index.measure(_grid(arguments), arguments.planner, _threads(arguments), progress)
    return told, tables.index_rows(told)


def _compare(arguments: argparse.Namespace, progress: "Progress") -> tuple[dict[str, Any], list[dict[str, str]]]:
    from benchmarks.planners import compare, tables  # noqa: PLC0415

    only = tuple(arguments.only or ())
    told = compare.measure(_grid(arguments), _goal(arguments), _threads(arguments), only, progress)
    _tell_left_out(told, progress)
    return told, tables.compare_rows(told)


def _scaling(arguments: argparse.Namespace, progress: "Progress") -> tuple[dict[str, Any], list[dict[str, str]]]:
    from benchmarks.planners import scaling, tables  # noqa: PLC0415

    kinds = arguments.kind or scaling.KINDS_SHOWN
    told = scaling.measure(kinds, scaling.sizes_up_to(arguments.largest), _threads(arguments), progress)
    if arguments.plot is not None:
        _plot(arguments.plot, scaling.chart(told))
    return told, tables.scaling_rows(told)


def _fig3(arguments: argparse.Namespace, progress: "Progress") -> tuple[dict[str, Any], list[dict[str, str]]]:
    import uvloop  # noqa: PLC0415

    from benchmarks.planners import grids, path_lengths, tables  # noqa: PLC0415

    map_ = path_lengths.default_map() if arguments.map is None else grids.map_from_file(arguments.map)
    told = uvloop.run(path_lengths.measure(map_, arguments.cores, progress))
    if arguments.plot is not None:
        _plot(arguments.plot, path_lengths.chart(told))
    return told, tables.length_rows(told)


def _tell_left_out(told: dict[str, Any], progress: "Progress") -> None:
    for who, reason in told["left_out"].items():
        progress.console.print(f"{who} is left out: {reason}", markup=False, highlight=False, soft_wrap=True)


def _plot(path: Path, chart: Any) -> None:
    from robots.pictures.line_chart import write_chart  # noqa: PLC0415

    write_chart(path, *chart)


def _grid(arguments: argparse.Namespace) -> "Grid":
    from benchmarks.planners import grids  # noqa: PLC0415

    return grids.tiled(_single(arguments), arguments.tiles)


def _single(arguments: argparse.Namespace) -> "Grid":
    from benchmarks.planners import grids  # noqa: PLC0415

    if arguments.map is not None:
        return grids.from_file(arguments.map)
    if arguments.empty is not None:
        return grids.empty(arguments.empty)
    if arguments.random is not None:
        size, percent = arguments.random
        if size != int(size):
            raise InvalidInput(f"--random takes a whole number of cells and then the percent, not {size:g}")
        return grids.random(int(size), percent)
    if len(arguments.maze) > 2:
        raise InvalidInput(f"--maze takes one number or two, not {len(arguments.maze)}")
    return grids.maze(*arguments.maze)


def _goal(arguments: argparse.Namespace) -> tuple[int, int] | None:
    return None if arguments.goal is None else (arguments.goal[0], arguments.goal[1])


def _threads(arguments: argparse.Namespace) -> list[int]:
    from benchmarks.planners.timing import cpus  # noqa: PLC0415

    return arguments.threads or sorted({1, cpus()})


def _numbers(text: str) -> list[int]:
    numbers = [int(number) if number.isdecimal() else 0 for number in text.split(",")]
    if min(numbers) < 1:
        raise argparse.ArgumentTypeError(f"numbers of threads are whole numbers from 1 up, not {text!r}")
    return list(dict.fromkeys(numbers))


def _pause(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 <= seconds <= LONGEST_PAUSE:
        raise argparse.ArgumentTypeError(f"a pause is 0 to {LONGEST_PAUSE:g} s long, not {text!r}")
    return seconds


def _names(text: str) -> list[str]:
    return list(dict.fromkeys(text.split(",")))


_VERBS: dict[str, Tell] = {
    "field": _field, "scenario": _scenario, "index": _index, "compare": _compare, "scaling": _scaling, "fig3": _fig3,
}  # fmt: skip
