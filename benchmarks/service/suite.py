"""Runs the parts of the service bench."""

import contextlib
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from rich.progress import Progress

from benchmarks.harness.cloud_under_test import CloudUnderTest, own_cloud, running_cloud
from benchmarks.harness.figures import Figure, PartSelection
from benchmarks.service import (
    dashboard,
    first_use,
    fleet,
    map_transfer,
    metrics,
    plan_load,
    plan_requests,
    startup,
    teleop,
    teleop_browser,
)

Measure = Callable[[CloudUnderTest, Progress, bool], Awaitable[list[Figure]]]

PARTS: dict[str, Measure] = {
    plan_requests.PART: plan_requests.measure,
    plan_load.PART: plan_load.measure,
    map_transfer.MAPS: map_transfer.measure_publishing,
    startup.CONTAINERS: startup.measure_containers,
    dashboard.PART: dashboard.measure,
    fleet.PART: fleet.measure,
    map_transfer.PUSH: map_transfer.measure_push,
    teleop.PART: teleop.measure,
    teleop_browser.PART: teleop_browser.measure,
}
"""Parts that need a running cloud; the parts of `STARTS` start their own."""

STARTS = {startup.PART: startup.measure, first_use.PART: first_use.measure, metrics.PART: metrics.measure}
"""Parts that start their own clouds: to measure the start, or the cost of metrics."""


@dataclass(frozen=True, slots=True)
class ServiceOptions(PartSelection):
    """Options of the service bench.

    Parameters
    ----------
    url, token : str, optional
        URL and token of a running cloud; without them, the bench starts one.
    """

    url: str | None = None
    token: str | None = None


async def measure(options: ServiceOptions, progress: Progress) -> list[Figure]:
    """Measure the parts one after the other.

    Raises
    ------
    PPaaSError
        The cloud does not start, or refuses something.
    """
    figures: list[Figure] = []
    for part, measure_start in STARTS.items():
        if options.wants(part):
            figures += await measure_start(progress, options.quick)
    wanted = [measure_part for part, measure_part in PARTS.items() if options.wants(part)]
    if wanted:
        async with _target(options) as target:
            for measure_part in wanted:
                figures += await measure_part(target, progress, options.quick)
    return figures


def _target(options: ServiceOptions) -> contextlib.AbstractAsyncContextManager[CloudUnderTest]:
    if options.url is None:
        return own_cloud()
    return running_cloud(options.url, options.token or "")
