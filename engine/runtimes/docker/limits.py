"""What a container of the Docker engine may use, in the engine's own terms.

Its size is a limit here, not a share: a container of 0.5 cores has half of a CPU's time, even if nobody else wants the
other half (``--cpus``, ``--cpuset-cpus``, ``--memory``). Spares, which only load, have all CPUs, behind all others.
"""

import math
from typing import Any

from engine.runtimes.memory_limits import memory_of
from engine.specs.containers import Launch
from engine.specs.cores import memory_limit

PERIOD = 100_000
"""Within which a container has its share of the CPUs [µs]."""

LEAST_QUOTA = 1_000
"""That the kernel takes [µs]."""

SHARES = 1024
"""Weight of a container of one core, where more is wanted than there is."""

SPARE_SHARES = 64

PROCESSES = 128
"""And threads."""


def of_spare() -> dict[str, Any]:
    """Return what a container may use until it is told what it is, as ``docker run`` takes it."""
    return {"cpu_shares": SPARE_SHARES, "pids_limit": PROCESSES, **_memory(memory_limit(0.0, 0))}


def of_launch(launch: Launch) -> dict[str, Any]:
    """Return what it may use from then on, as ``docker update`` takes it."""
    return {**cpus_of_launch(launch), **_memory(memory_of(launch))}


def cpus_of_launch(launch: Launch) -> dict[str, Any]:
    """Return what of that are CPUs."""
    size = launch.spec.cores
    return {
        "cpu_period": PERIOD,
        "cpu_quota": max(LEAST_QUOTA, math.ceil(size * PERIOD)),
        "cpu_shares": max(2, math.ceil(size * SHARES)),
        "cpuset_cpus": ",".join(map(str, launch.cpus)),
    }


def _memory(limit: int) -> dict[str, int]:
    return {"mem_limit": limit, "memswap_limit": limit}
