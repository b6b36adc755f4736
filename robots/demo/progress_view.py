"""Progress display of a demo on a terminal."""

import asyncio

from rich.console import Console
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from robots.demo.mission import Mission
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
