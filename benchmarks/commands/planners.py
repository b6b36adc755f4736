"""Benches of planners, without a cloud: ``ppaas bench compare``, ``field``, ``fig3``, ``index``, ``planning`` and more.

Each class is one bench; its entry point names it. Modules that measure are imported only when a bench runs, since
``ppaas bench --help`` loads all benches.
"""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.planners.grid_arguments import (
    add_goal_argument,
    add_grid_arguments,
    add_threads_argument,
    check_plot,
    draw,
    goal_of,
    grid_of,
    tell_left_out,
    threads_of,
)
from ppaas.errors import InvalidParameter
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

LONGEST_PAUSE = 60.0
"""Longest pause between two fields [s]."""


class CompareBench:
    """``ppaas bench compare``: compares our planners with packages from PyPI on the same grid."""

    HELP = "our planners and installed packages from PyPI on the same grid"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        add_grid_arguments(parser)
        add_goal_argument(parser)
        add_threads_argument(parser)
        parser.add_argument(
            "--only", action="append", metavar="PACKAGE", help="package to compare with (all that are installed)"
        )

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Measure our planners and the peers."""
        from benchmarks.planners import compare, tables  # noqa: PLC0415

        only = tuple(arguments.only or ())
        told = compare.measure(grid_of(arguments), goal_of(arguments), threads_of(arguments), only, progress)
        tell_left_out(told, progress)
        return Measured(told, tables.compare_rows(told))


class FieldBench:
    """``ppaas bench field``: time of the full cost field of a goal on one grid."""

    HELP = "the full cost field of one goal"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        add_grid_arguments(parser)
        add_goal_argument(parser)
        add_threads_argument(parser)
        parser.add_argument("--plot", type=Path, metavar="OUT.png",
                            help="draw the planning time over the path length, by number of threads")  # fmt: skip
        parser.add_argument(
            "--beside",
            type=_names,
            default=[],
            metavar="A,B",
            help="implementations to compare with: navfn, or packages from PyPI",
        )
        parser.add_argument(
            "--pause", type=_pause, metavar="S", help="also measure fields with this pause [s] between them"
        )

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Measure, and draw the chart if it is requested."""
        from benchmarks.planners import field, path_lengths, tables  # noqa: PLC0415
        from benchmarks.planners.peers import beside  # noqa: PLC0415

        check_plot(arguments)
        grid, threads = grid_of(arguments), threads_of(arguments)
        others = beside(arguments.beside)
        told = field.measure(grid, goal_of(arguments), threads, progress, others=others)
        tell_left_out(told, progress)
        if arguments.pause is not None:
            told["paused_seconds"] = field.with_pauses(grid, tuple(told["goal"]), threads, arguments.pause, progress)
        if arguments.plot is not None:
            lengths = event_loop.run(path_lengths.measure_locally(grid.costmap, threads, progress))
            draw(arguments.plot, path_lengths.chart(lengths))
        return Measured(told, tables.field_rows(told))


class Fig3Bench:
    """``ppaas bench fig3``: planning time over path length, as in Fig. 3 of the paper."""

    HELP = "planning time over path length: threads of this process, a container of several cores, and navfn"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the planning time over the path length")
        parser.add_argument("--map", type=Path, help="YAML file or MovingAI map (a generated warehouse of 120 by 80 m)")
        parser.add_argument("--cores", type=int, default=2, help="cores of the container (%(default)s)")

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Measure paths of all lengths, and draw the chart if it is requested."""
        import uvloop  # noqa: PLC0415

        from benchmarks.planners import path_lengths, tables  # noqa: PLC0415
        from robots.client.map_files import read_map_file  # noqa: PLC0415

        check_plot(arguments)
        map_ = path_lengths.default_map() if arguments.map is None else read_map_file(arguments.map)
        told = event_loop.run(path_lengths.measure(map_, arguments.cores, progress), uvloop.new_event_loop)
        if arguments.plot is not None:
            draw(arguments.plot, path_lengths.chart(told))
        return Measured(told, tables.length_rows(told))


class IndexBench:
    """``ppaas bench index``: time to prepare a grid for a planner, and correctness of its answers."""

    HELP = "the index of a grid: time to build it by number of threads, and correctness of queries"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        add_grid_arguments(parser)
        add_threads_argument(parser)
        parser.add_argument("--planner", default="hub_labels", help="planner that prepares a map (%(default)s)")

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Prepare the grid with each number of threads, and query it."""
        from benchmarks.planners import index, tables  # noqa: PLC0415

        told = index.measure(grid_of(arguments), arguments.planner, threads_of(arguments), progress)
        return Measured(told, tables.index_rows(told))


class PlanningBench:
    """``ppaas bench planning``: time to prepare maps, to convert depth images to scans, and to plan paths."""

    HELP = "preparation of maps, scans from depth images, and planning, without a cloud"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        parser.add_argument(
            "--quick", action="store_true", help="few samples: a check that it runs, not for comparison"
        )

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Return all figures."""
        from benchmarks.harness.figures import measured  # noqa: PLC0415
        from benchmarks.planners import planning  # noqa: PLC0415

        prepared = planning.measure_preparation(progress, arguments.quick)
        return measured(planning.measure(progress, arguments.quick) + prepared)


class ScalingBench:
    """``ppaas bench scaling``: time of the full cost field, or of plans, by size of the grid."""

    HELP = "the full cost field, or plans, on grids from 256² up"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        add_threads_argument(parser)
        parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the time per cell over the grid size")
        parser.add_argument("--kind", action="append", help="kind of grid, again for more (empty, random 20 %%, maze)")
        parser.add_argument(
            "--planner",
            action="append",
            metavar="NAME",
            help="measure plans of a planner beside dijkstra, again for more",
        )
        parser.add_argument(
            "--largest", type=int, default=8192, metavar="N", help="largest edge in cells (%(default)s)"
        )

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Measure grids of all sizes, and draw the chart if it is requested."""
        from benchmarks.planners import scaling, tables  # noqa: PLC0415

        check_plot(arguments)
        kinds = arguments.kind or scaling.KINDS_SHOWN
        sizes = scaling.sizes_up_to(arguments.largest)
        if arguments.planner:
            told = scaling.measure_growth(kinds, sizes, arguments.planner, progress)
            return Measured(told, tables.growth_rows(told))
        told = scaling.measure(kinds, sizes, threads_of(arguments), progress)
        if arguments.plot is not None:
            draw(arguments.plot, scaling.chart(told))
        return Measured(told, tables.scaling_rows(told))


class ScenarioBench:
    """``ppaas bench scenario``: runs the queries of a MovingAI scenario, and checks the lengths of the paths."""

    HELP = "every query of a MovingAI scenario: times, and number of wrong lengths"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        parser.add_argument("scenario", type=Path, metavar="FILE.scen")
        parser.add_argument("--map", type=Path, metavar="FILE.map", help="map (beside the scenario, of the same name)")
        parser.add_argument("--planner", default="dijkstra", help="name of an installed planner (%(default)s)")
        parser.add_argument("--limit", type=int, metavar="N", help="only the first N queries (all)")

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Run the queries."""
        from benchmarks.planners import scenario, tables  # noqa: PLC0415

        told = scenario.measure(arguments.scenario, arguments.map, arguments.planner, arguments.limit, progress)
        return Measured(told, tables.scenario_rows(told))


class SuiteBench:
    """``ppaas bench suite``: measures all figures of planners in ``docs/performance.md``, and stores them in a file."""

    HELP = "all figures of a planner report, stored in a JSON file"

    PARTS = ("fields", "comparisons", "scaling", "lengths", "scenarios", "indexes")

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        parser.add_argument("--data", type=Path, metavar="FOLDER", help="folder with real maps in ros/ and movingai/")
        parser.add_argument(
            "--only",
            choices=SuiteBench.PARTS,
            metavar="PART",
            action="append",
            help=f"part to measure, again for more: {', '.join(SuiteBench.PARTS)} (all)",
        )
        parser.add_argument(
            "--quick", action="store_true", help="small grids: a check that it runs, not for comparison"
        )
        parser.add_argument("file", type=Path, metavar="FILE.json")

    @staticmethod
    def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
        """Measure the parts one after the other, and keep each in the file."""
        from benchmarks.planners import report, suite  # noqa: PLC0415

        measured = report.read(arguments.file)
        options = suite.PlannerSuiteOptions(arguments.data, tuple(arguments.only or ()), arguments.quick)
        for part, told in suite.measure(options, progress):
            measured[part] = told
            report.keep(arguments.file, measured)  # at once, as later parts may take long or fail
        return Measured(measured)


class ReportBench:
    """``ppaas bench report``: writes the results of a suite as Markdown."""

    HELP = "the results of a suite, as Markdown"

    @staticmethod
    def configure(parser: argparse.ArgumentParser) -> None:
        """Add the arguments."""
        parser.add_argument(
            "--write", type=Path, metavar="PAGE.md", help="write the report into a page, between its marks"
        )
        parser.add_argument("file", type=Path, metavar="FILE.json")

    @staticmethod
    def measure(arguments: argparse.Namespace, _: "Progress") -> Measured:
        """Return the text, or write it into the page."""
        from benchmarks.planners import report  # noqa: PLC0415

        measured = report.read(arguments.file)
        if arguments.write is None:
            return Measured(measured, text=report.render(measured))
        report.write(arguments.write, measured)
        return Measured(measured)


def _pause(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 <= seconds <= LONGEST_PAUSE:
        raise InvalidParameter(f"--pause must be 0 to {LONGEST_PAUSE:g} seconds, not {text!r}")
    return seconds


def _names(text: str) -> list[str]:
    return list(dict.fromkeys(text.split(",")))
