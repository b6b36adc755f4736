"""``ppaas bench fleet``: plans of fleets, CPU time and cost."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.harness.figures import Figure

HELP = "plans of fleets: CPU time, cost beside the bound, turns, lifelong steps and waits; simulated robots in traffic"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--case",
        nargs=3,
        metavar=("MAP.map", "FILE.scen", "N"),
        action="append",
        help="map and scenario of MovingAI with a number of robots, again for more (three halls that are made up)",
    )
    parser.add_argument(
        "--traffic",
        nargs=4,
        metavar=("HALL", "ROBOTS", "MINUTES", "SEED"),
        action="append",
        help="instead of plans, simulated robots with real clones in a warehouse or an office, again for more",
    )
    parser.add_argument(
        "--stand-ins",
        nargs=4,
        metavar=("HALL", "ROBOTS", "MINUTES", "SEED"),
        action="append",
        help="instead of plans, hundreds of discs that stand in for robots and clones, with faults, again for more",
    )
    parser.add_argument(
        "--pictures",
        type=Path,
        metavar="FOLDER",
        help="instead of plans, draw robots in cases that users of other systems reported, into a PNG file",
    )
    parser.add_argument("--quick", action="store_true", help="little time: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the figures of all cases."""
    from benchmarks.fleet import cases, planning, traffic  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.fleet.stand_ins import strips  # noqa: PLC0415
    from benchmarks.harness.figures import measured  # noqa: PLC0415

    if arguments.traffic:
        runs = [traffic.case_of(words) for words in arguments.traffic]
        return measured(
            [each for case in progress.track(runs, description="traffic") for each in traffic.measure(case)]
        )
    if arguments.pictures:
        path = strips.write_strips(arguments.pictures)
        return Measured({"picture": str(path)}, text=f"{path} is drawn")
    if arguments.stand_ins:
        return measured([each for words in arguments.stand_ins for each in _stand_ins(words, progress)])
    chosen = [cases.case_of(words) for words in arguments.case] if arguments.case else cases.MADE
    parts = [
        (part, case)
        for case in chosen
        for part in (planning.measure_one_shot, planning.measure_turns, planning.measure_lifelong)
    ]
    return measured(
        [figure for part, case in progress.track(parts, description="fleet") for figure in part(case, arguments.quick)]
    )


def _stand_ins(words: list[str], progress: "Progress") -> "list[Figure]":
    from benchmarks.fleet.stand_ins import measure as stand_ins  # noqa: PLC0415

    case = stand_ins.case_of(words)
    task = progress.add_task("stand-ins", total=case.total)

    def tell(what: str, seconds: float) -> None:
        progress.update(task, advance=seconds, description=what)

    return list(stand_ins.measure(case, tell))
