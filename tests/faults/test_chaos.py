"""Random faults of all kinds while robots drive, for a few seconds; ``make chaos`` runs ten minutes."""

from collections.abc import Callable

import pytest
from rich.console import Console
from rich.progress import Progress

from benchmarks.chaos.run import ChaosOptions, run

pytestmark = pytest.mark.journey


async def test_nothing_is_lost_duplicated_or_left_behind_under_random_faults(
    record_property: Callable[[str, object], None],
) -> None:
    options = ChaosOptions(
        seconds=6.0, robots=2, operators=1, machines=1, standby=False, every=1.5, seed=3, sides=(9.0, 10.0), throttled=3
    )
    report = await run(options, Progress(console=Console(stderr=True), disable=True))
    record_property("longest_gap_s", report.longest_gap_s)
    assert report.wrong == [], report
    assert sum(report.faults.values()) >= 3
    goals = report.goals
    assert goals["sent"] == goals["result"] + goals["status"] + goals["lost"] >= 2
    assert report.commands > 20
    assert report.throttled_messages > 20
