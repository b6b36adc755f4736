"""Two endpoints on two cores beside one on one core: the frames that they carry, by the CPU time that each takes.

An endpoint carries as many frames a second as its core has time for. So two carry what the busier one has time for, and
all that robots' sockets are not spread evenly over them counts against them. The load for each endpoint is the same in
both runs, since a frame takes more CPU time of a process that is idle more often.
"""

from rich.progress import Progress

from benchmarks.harness.figures import Figure
from benchmarks.harness.process_usage import cpu_of
from benchmarks.wire.load import FrameCosts, frame_costs
from benchmarks.wire.site import Endpoints, echo_cloud, opened, robots, scan_frame

PART = "endpoints"
ROBOTS, QUICK_ROBOTS = 40, 4
"""Robots for each endpoint."""

SECONDS, QUICK_SECONDS = 10.0, 1.0
GAIN_LIMIT = 1.8
"""Smallest acceptable number of frames beside those of one endpoint."""


async def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Put a load on one endpoint, and twice that load on two."""
    task = progress.add_task("two endpoints", total=2)
    one = await _loaded(1, quick)
    progress.advance(task)
    two = await _loaded(2, quick)
    progress.remove_task(task)
    return figures(one, two)


async def _loaded(endpoints: int, quick: bool) -> tuple[FrameCosts, float]:
    """Return the CPU times of endpoints, with a load for each, and that of all other processes of the cloud [s]."""
    each, seconds = (QUICK_ROBOTS, QUICK_SECONDS) if quick else (ROBOTS, SECONDS)
    count = each * endpoints
    async with (
        echo_cloud(count, "--endpoints", str(endpoints)) as site,
        opened(*await robots(site, 0, count)) as sockets,
    ):
        found = Endpoints(site)
        costs = await frame_costs(
            lambda: [*found.cpu(), sum(map(cpu_of, found.others))], sockets, scan_frame(), seconds
        )
    *own, others = costs.seconds
    return FrameCosts(own, costs.frames), others


def carried(costs: FrameCosts) -> float:
    """Return the number of frames a second at which the busiest endpoint has used all of its core."""
    return costs.frames / max(costs.seconds)


def figures(one: tuple[FrameCosts, float], two: tuple[FrameCosts, float]) -> list[Figure]:
    """Return the figures, from the CPU times of endpoints, and of all other processes of the cloud [s]."""
    (alone, _), (both, others) = one, two
    shares = ", ".join(f"{seconds / sum(both.seconds):.0%}" for seconds in both.seconds)
    rest = 1e6 * others / both.frames
    return [
        Figure(PART, "one endpoint", round(carried(alone)), "frames/s", yardstick=True, note="scans, one core in use"),
        Figure(PART, "two endpoints", round(carried(both)), "frames/s",
               note=f"their shares of the CPU time: {shares}; other processes take {rest:.0f} µs a scan"),
        Figure(PART, "two endpoints beside one", round(carried(both) / carried(alone), 2), "x", limit=GAIN_LIMIT,
               floor=True, note=_stopped_by(both, alone)),
    ]  # fmt: skip


def _stopped_by(both: FrameCosts, alone: FrameCosts) -> str:
    """Return what keeps two endpoints from twice the frames of one: dearer frames, or sockets spread unevenly."""
    dearer, uneven = both.each / alone.each - 1.0, max(both.seconds) / sum(both.seconds) * len(both.seconds) - 1.0
    return f"a frame takes {dearer:+.0%} CPU time, and the busier endpoint has {uneven:+.0%} of an even share"
