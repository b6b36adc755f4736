"""Progress display of a demo on a terminal."""

import asyncio

from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from robots.demo.mission import Mission
from robots.demo.report import DemoReport, ExplorationReport, RobotReport
from robots.demo.scorer import Scorer

PERIOD = 0.25
"""Time between two updates of the display [s]."""


def progress_table(missions: list[Mission]) -> Table:
    """Return a table with a row per robot: its goal, the distance to it, and its contacts."""
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
    """Show a live table on the terminal until cancelled."""
    with Live(progress_table(missions), console=console, auto_refresh=False) as live:
        try:
            while True:
                live.update(progress_table(missions), refresh=True)
                await asyncio.sleep(PERIOD)
        finally:
            live.update(progress_table(missions), refresh=True)


def summary(report: DemoReport | ExplorationReport, console: Console) -> None:
    """Print the report."""
    lines = exploration_lines(report) if isinstance(report, ExplorationReport) else []
    lines += [robot_line(robot) for robot in report.robots]
    lines.append(f"{'passed' if report.passed else 'failed'} in {report.seconds:.0f} s on map {report.map!r}")
    for line in lines:
        console.print(line, highlight=False, markup=False)


def robot_line(robot: RobotReport) -> str:
    """Return the line of a robot."""
    worst = f", at most {max(robot.final_errors_m):.2f} m off" if robot.final_errors_m else ""
    goals = f"{robot.goals_reached} of {robot.goals_asked} goals reached{worst}, " if robot.goals_asked else ""
    return f"{robot.id}: {goals}{robot.distance_m:.1f} m travelled, {robot.collisions} contacts"


def exploration_lines(report: ExplorationReport) -> list[str]:
    """Return the lines of an exploration and of its map."""
    joined = [] if report.joined_seconds is None else [f"the maps were joined after {report.joined_seconds:.0f} s"]
    share = 100.0 * report.wrong_cells / max(report.known_cells, 1)
    return [
        *joined,
        f"exploring {report.explored} after {report.explored_seconds:.0f} s: {report.frontiers} frontiers left, "
        f"{report.unreachable} given up",
        f"map: {report.area_m2:.1f} m² known, {report.wrong_cells} of {report.known_cells} cells wrong ({share:.2f} %)",
    ]
