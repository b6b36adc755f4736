"""Cores: how many threads a container of some size gets, on which CPUs, and how many containers a machine takes.

All sizes are decimal CPU cores: 0.25, 1, 2.
"""

import math
from collections.abc import Iterable, Mapping

from ppaas.errors import InvalidParameter, QuotaExceeded

OVERSUBSCRIPTION = 4.0
"""Cores that a machine gives away for each that it has: containers plan in bursts and idle between them."""

MEMORY_PER_CORE = 128 << 20
"""Bytes that a container counts for with each core of its size. A clone has 13 MB of its own, and shares its map."""

MEMORY_LIMIT = 512 << 20
"""Bytes that a container of any size may take, where it is held to some: its interpreter, and what planning takes."""

MEMORY_LIMIT_PER_CORE = 512 << 20

MEMORY_LIMIT_PER_CELL = 64
"""Bytes more for each cell of its map: twice what the hungriest of our planners takes."""


def check(size: float, machine_cores: int) -> None:
    """Make sure that a machine can hold a container at all.

    Raises
    ------
    InvalidParameter
        Not a positive, finite number.
    QuotaExceeded
        More than the machine has.
    """
    if not (math.isfinite(size) and size > 0.0):
        raise InvalidParameter(f"the size of a container is a positive number of cores, not {size}")
    if size > machine_cores:
        raise QuotaExceeded(f"a container of {size:g} cores does not fit a machine of {machine_cores}")


def threads(size: float) -> int:
    """Return how many threads the kernels of a container may use: ⌊size⌋, at least one."""
    return max(1, math.floor(size))


def width(size: float) -> int:
    """Return on how many CPUs a container runs: ⌈size⌉."""
    return math.ceil(size)


def memory(size: float) -> int:
    """Return how many bytes a container counts for: memory goes with size."""
    return math.ceil(size * MEMORY_PER_CORE)


def memory_limit(size: float, cells: int) -> int:
    """Return how many bytes a container may take on a map of so many cells, where it is held to some."""
    return MEMORY_LIMIT + math.ceil(size * MEMORY_LIMIT_PER_CORE) + cells * MEMORY_LIMIT_PER_CELL


def capacity(machine_cores: int, machine_memory: int, oversubscription: float = OVERSUBSCRIPTION) -> float:
    """Return the sum of the sizes that a machine takes, by its CPUs and its memory [bytes]."""
    return min(machine_cores * oversubscription, machine_memory / MEMORY_PER_CORE)


def used(containers: Iterable[tuple[float, tuple[int, ...]]]) -> dict[int, float]:
    """Return the cores given away on each CPU, from the size and the CPUs of each container."""
    load: dict[int, float] = {}
    for size, cpus in containers:
        for cpu in cpus:
            load[cpu] = load.get(cpu, 0.0) + size / len(cpus)
    return load


def pick(size: float, cpus: Iterable[int], load: Mapping[int, float]) -> tuple[int, ...]:
    """Return the CPUs for a container: those of which least was given away, the lower number first.

    Parameters
    ----------
    size : float
        Of the container [cores].
    cpus : iterable of int
        All CPUs of the machine that may be used.
    load : mapping of int to float
        Cores given away on each CPU; a CPU that is missing is idle.

    Raises
    ------
    InvalidParameter, QuotaExceeded
        As ``check`` says.
    """
    present = sorted(set(cpus))
    check(size, len(present))
    by_load = sorted(present, key=lambda cpu: (load.get(cpu, 0.0), cpu))
    return tuple(sorted(by_load[: width(size)]))
