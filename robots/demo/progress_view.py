"""Shows on a terminal how simulated robots are getting on."""

import asyncio

from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from robots.demo.mission import Mission
from robots.demo.report import DemoReport
from robots.demo.scorer import Scorer

PERIOD = 0.25


def progress_table(missions: list[Mission]) -> Table:
    """Return a row for each robot: its goal, how far it is from it, and what it touched."""
    table = Table(title="PPaaS demo", title_justify="left")
    for heading in ("robot", "goal", "to go (m)", "travelled (m)", "contacts", "state"):
        table.add_column(heading, justify="left" if heading in ("robot", "state") else "right")
    for mission in missions:
        scorer, progress = Scorer(mission.world), mission.progress
        left = f"{scorer.error(mission.index, progress.target):.2f}" if progress.target else "-"
        table.add_row(
            mission.robot,
            f"{progress.goal}/{progress.goals}" if progress.goal <= progress.goals else str(progress.goal),
            left,
            f"{scorer.distance(mission.index):.1f}",
            str(scorer.collisions(mission.index)),
            escape(progress.state),
        )
    return table


async def show(missions: list[Mission], console: Console) -> None:
    """Keep a live table on the terminal until cancelled."""
    with Live(progress_table(missions), console=console, auto_refresh=False) as live:
        try:
            while True:
                live.update(progress_table(missions), refresh=True)
                await asyncio.sleep(PERIOD)
        finally:
            live.update(progress_table(missions), refresh=True)


def summary(report: DemoReport, console: Console) -> None:
    """Print what came of it."""
    for robot in report.robots:
        worst = f", at most {max(robot.final_errors_m):.2f} m off" if robot.final_errors_m else ""
        console.print(
            f"{robot.id}: {robot.goals_reached} of {robot.goals_asked} goals reached{worst}, "
            f"{robot.distance_m:.1f} m travelled, {robot.collisions} contacts",
            highlight=False,
            markup=False,
        )
    outcome = "passed" if report.passed else "failed"
    console.print(f"{outcome} in {report.seconds:.0f} s on map {report.map!r}", highlight=False, markup=False)
