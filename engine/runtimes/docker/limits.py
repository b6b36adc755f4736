"""Resource limits of Docker containers, in the terms of the Docker Engine.

A size is a hard limit here, not a share: a container of 0.5 cores gets half of a CPU's time, even if the other half is
idle (``--cpus``, ``--cpuset-cpus``, ``--memory``). Spares, which only import modules, may use all CPUs at low weight.
"""

import math
from typing import Any

from engine.runtimes.memory_limits import memory_of
from engine.specs.containers import Launch
from engine.specs.cores import memory_limit

PERIOD = 100_000
"""Period of the CPU quota [µs]."""

LEAST_QUOTA = 1_000
"""Smallest quota that the kernel accepts [µs]."""

SHARES = 1024
"""CPU weight of a container of one core, which counts when the CPUs are overloaded."""

SPARE_SHARES = 64
"""CPU weight of a spare."""

PROCESSES = 128
"""Most processes and threads of a container."""


def spare_limits() -> dict[str, Any]:
    """Return the limits of a spare, as options of ``docker run``."""
    return {"cpu_shares": SPARE_SHARES, "pids_limit": PROCESSES, **_memory(memory_limit(0.0, 0))}


def launch_limits(launch: Launch) -> dict[str, Any]:
    """Return the limits of a launched container, as options of ``docker update``."""
    return {**cpu_limits(launch), **_memory(memory_of(launch))}


def cpu_limits(launch: Launch) -> dict[str, Any]:
    """Return only the CPU limits of a launched container."""
    size = launch.spec.cores
    return {
        "cpu_period": PERIOD,
        "cpu_quota": max(LEAST_QUOTA, math.ceil(size * PERIOD)),
        "cpu_shares": max(2, math.ceil(size * SHARES)),
        "cpuset_cpus": ",".join(map(str, launch.cpus)),
    }


def _memory(limit: int) -> dict[str, int]:
    return {"mem_limit": limit, "memswap_limit": limit}
