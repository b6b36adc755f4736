"""Breaks a cloud, waits until the alerts fire, mends it, and waits until they resolve."""

import asyncio
import tempfile
from dataclasses import dataclass
from pathlib import Path

from rich.progress import Progress

from benchmarks.alerts.faults import BESIDE, LAST, MAP, CloudFault, Site
from benchmarks.alerts.monitoring import Notifications, monitoring
from benchmarks.harness.cloud_under_test import logged_in
from benchmarks.harness.free_ports import free_ports
from ppaas.clock import monotonic
from ppaas.errors import InvalidInput
from ppaas.maps.generate import warehouse
from robots.demo.cloud_process import CloudProcess

SLACK = 60.0
"""Time that an alert may take to fire or to resolve in addition to the time of its rule [s]."""

LONGEST = 3600.0
"""Longest time of a rule, without hurry [s]."""

SIDES = 16.0, 9.0
"""Sides of the map [m]."""


@dataclass(frozen=True, slots=True)
class SeenAlert:
    """An alert that fired and resolved.

    Parameters
    ----------
    alert, broken, mended : str
        Name of the alert, the fault, and the action that mended it.
    fired, resolved : float, optional
        Time from that until Alertmanager notified of it [s]; None if it did not in time.
    """

    alert: str
    broken: str
    fired: float | None
    mended: str
    resolved: float | None

    def row(self) -> dict[str, str]:
        """Return the row of a table."""
        return {
            "alert": self.alert,
            "broken": self.broken,
            "fires after": _seconds(self.fired),
            "mended": self.mended,
            "resolves after": _seconds(self.resolved),
        }


def _seconds(time: float | None) -> str:
    return "never" if time is None else f"{time:.1f} s"


@dataclass(frozen=True, slots=True)
class _Watch:
    """Sees alerts at a site; ``limit`` is the time for one to fire or to resolve [s]."""

    site: Site
    heard: Notifications
    limit: float
    progress: Progress

    async def see(self, kind: type[CloudFault]) -> SeenAlert:
        """Break something, and mend it when the alert has fired."""
        fault = kind(self.site)
        await fault.prepare()
        try:
            began = monotonic()
            await fault.break_it()
            fired = await self.heard.when(fault.alert, "firing", began, self.limit)
            self.progress.console.print(f"  {fault.alert}: {fault.broken}; it fires: {fired is not None}")
            mended = monotonic()
            await fault.mend()
            resolved = None if fired is None else await self.heard.when(fault.alert, "resolved", mended, self.limit)
            self.progress.console.print(f"  {fault.alert}: {fault.mended}; it resolves: {resolved is not None}")
        finally:
            await fault.close()
        return SeenAlert(
            fault.alert, fault.broken, None if fired is None else fired - began, fault.mended,
            None if resolved is None else resolved - mended,
        )  # fmt: skip


async def run(faster: float, only: tuple[str, ...], progress: Progress) -> list[SeenAlert]:
    """Start a cloud with its monitoring, and see the alerts.

    Raises
    ------
    InvalidInput
        An alert is not among the ones that the bench can provoke.
    Unavailable
        A program is missing, or the cloud does not start.
    """
    known = [fault.alert for fault in BESIDE + LAST]
    if unknown := set(only) - set(known):
        raise InvalidInput(f"the bench cannot provoke {', '.join(sorted(unknown))}, but {', '.join(known)}")
    beside, last = ([fault for fault in faults if fault.alert in (only or known)] for faults in (BESIDE, LAST))
    metrics, machines, _ = free_ports(3)
    arguments = (
        "--metrics", str(metrics), "--listen-machines", f"127.0.0.1:{machines}", "--webhook-allow-http",
        "--webhook-allow-private", "--linger", "0.5",
    )  # fmt: skip
    with tempfile.TemporaryDirectory(prefix="a-") as folder:
        async with CloudProcess(arguments=arguments) as cloud, monitoring(Path(folder), metrics, faster) as heard:
            await (await logged_in(cloud)).publish(MAP, warehouse(1, *SIDES))
            (Path(folder) / "m").mkdir()
            watch = _Watch(Site(cloud, Path(folder) / "m"), heard, LONGEST / faster + SLACK, progress)
            seen = list(await asyncio.gather(*map(watch.see, beside)))
            return seen + [await watch.see(fault) for fault in last]
