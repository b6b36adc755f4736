"""``ppaas bench``: what a user waits for, and how fast planners plan, measured."""

import argparse
from collections.abc import Callable
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from benchmarks.commands import chaos, engine, goals, planners, report
from robots.cli.output import print_line
from robots.cli.output import show as show_rows
from robots.cli.session import add_cloud_arguments, token_of

if TYPE_CHECKING:
    from rich.progress import Progress

NAME = "bench"
HELP = "measure planners, or a cloud on this machine, beside yardsticks"

OTHERS = "ppaas.benchmarks"
"""Entry points of what packages that robots do not know can measure."""

PARTS = ("startup", "plans", "maps", "containers", "fleet", "dashboard")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    kinds = parser.add_subparsers(title="what", metavar="WHAT", required=True)
    service = kinds.add_parser("service", help="what a user waits for, from the start of a cloud to a driving robot")
    add_cloud_arguments(service)
    service.set_defaults(url=None, what="service")
    service.add_argument("--only", choices=PARTS, metavar="NAME", action="append", help=f"of {', '.join(PARTS)}")
    planning = kinds.add_parser(
        "planning", help="preparing maps, making scans of depth images, and planning paths, without a cloud"
    )
    planning.set_defaults(what="planning")
    reuse = kinds.add_parser("reuse", help="how much sooner a kept path arrives than a computed one")
    reuse.set_defaults(what="reuse")
    for kind in (service, planning, reuse):
        kind.add_argument("--quick", action="store_true", help="few samples: to see that it runs, not to compare")
        kind.add_argument("--json", action="store_true", help="print the result as one JSON object")
    planners.configure(kinds)
    report.configure(kinds)
    chaos.configure(kinds)
    engine.configure(kinds)
    _configure_kind(kinds, "goals", goals)
    for entry in entry_points(group=OTHERS):
        _configure_kind(kinds, entry.name, entry.load())


def run(arguments: argparse.Namespace) -> int:
    """Measure and print; the exit status is 0 whatever the figures are, but 1 where a cloud did not stand the chaos."""
    from rich.console import Console  # noqa: PLC0415 - a robot's install has neither rich nor the simulation
    from rich.progress import Progress  # noqa: PLC0415

    verbs = {name: module.measure for module in (planners, report, chaos) for name in module.HELP}
    measure = getattr(arguments, "measure", None) or verbs.get(arguments.what, _measure_figures)
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        print_told = measure(arguments, progress)
    # Not before the progress is gone: while it is shown, whatever is printed goes where it goes.
    return print_told() or 0


def _configure_kind(kinds: Any, name: str, module: Any) -> None:
    """Add a bench that is a module with HELP, configure(parser) and measure(arguments, progress)."""
    parser = kinds.add_parser(name, help=module.HELP, description=module.HELP)
    module.configure(parser)
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")

    def measure(arguments: argparse.Namespace, progress: "Progress") -> Callable[[], None]:
        told, rows = module.measure(arguments, progress)
        if arguments.json:
            return lambda: show_rows(told, (), as_json=True)
        return lambda: show_rows(rows, tuple(rows[0]), as_json=False)

    parser.set_defaults(what=name, measure=measure)


def _measure_figures(arguments: argparse.Namespace, progress: "Progress") -> Callable[[], None]:
    import uvloop  # noqa: PLC0415 - what is measured is the cloud, not our own loop
    from rich.console import Console  # noqa: PLC0415

    from benchmarks.harness.figures import show, to_json  # noqa: PLC0415
    from benchmarks.planners import planning, preparation
    from benchmarks.service import plan_reuse as reuse  # noqa: PLC0415
    from benchmarks.service import suite as service

    if arguments.what == "planning":
        figures = planning.measure(progress, arguments.quick) + preparation.measure(progress, arguments.quick)
    elif arguments.what == "reuse":
        figures = uvloop.run(reuse.measure(progress, arguments.quick))
    else:
        token = token_of(arguments) if arguments.url else None
        only = tuple(arguments.only or ())
        options = service.Options(only, arguments.quick, arguments.url, token)
        figures = uvloop.run(service.measure(options, progress))
    if arguments.json:
        return lambda: print_line(to_json(figures))
    return lambda: show(figures, Console())
