"""Process that grows a simulated cloud, or adopts one; each has its own memory.

``python -m benchmarks.placement.growth_process grow FILE MACHINES ENDPOINTS ROBOTS`` writes the registrations of its
machines to a file, which ``… adopt FILE`` reads. Both print lines of JSON: ``{"done": N}``, and ``{"result": …}`` at
the end.
"""

import gc
import os
import sys
from pathlib import Path
from typing import Any

from benchmarks.harness.json_lines import tell
from benchmarks.harness.process_usage import memory_of
from benchmarks.placement.arrivals import events, generated
from benchmarks.placement.rare_events import time_rare_events
from benchmarks.placement.simulated_cloud import SimulatedCloud, Sizes
from benchmarks.placement.takeover import adopt, write_registrations
from benchmarks.placement.timed_master import timed_collections

ROBOTS_PER_MAP = 50
"""Mean number of robots of a map."""

TOLD_EVERY = 2000
"""Number of robots between two lines of progress."""


def _grow(file: Path, sizes: Sizes) -> dict[str, Any]:
    """Let all robots come, some roam and half of them go; write the registrations, and time rare events."""
    cloud = SimulatedCloud(sizes)
    with timed_collections() as collections:
        for event in events(generated(sizes.robots, max(1, sizes.robots // ROBOTS_PER_MAP), seed=1)):
            cloud.take(event)
            if event.comes and event.number % TOLD_EVERY == 0:
                tell({"done": event.number})
    cloud.timed.costs["collection"] = collections
    write_registrations(cloud, file)
    places = len(cloud.timed.master.places)
    time_rare_events(cloud)
    return {"costs": cloud.timed.costs, "places": places, "rejected": cloud.rejected}


def _adopt(file: Path) -> dict[str, Any]:
    """Adopt all containers, and weigh the master that has them."""
    before = memory_of(os.getpid()).private
    with timed_collections() as collections:
        for number, timed in enumerate(adopt(file)):  # noqa: B007 - the last one is the result
            if number % 100 == 0:
                tell({"done": number})
    timed.costs["adoption, collection"] = collections
    gc.collect()
    memory = memory_of(os.getpid()).private - before
    return {"costs": timed.costs, "places": len(timed.master.places), "memory_mb": memory}


def main() -> int:
    """Run one of the two."""
    what, file, *numbers = sys.argv[1:]
    result = _adopt(Path(file)) if what == "adopt" else _grow(Path(file), Sizes(*map(int, numbers)))
    tell({"result": result})
    return 0


if __name__ == "__main__":
    sys.exit(main())
