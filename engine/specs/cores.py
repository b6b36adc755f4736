"""Sizes in CPU cores: threads, CPUs and memory of a container, and the capacity of a machine.

Sizes are decimal numbers of CPU cores: 0.25, 1, 2.
"""

import math
from collections.abc import Iterable, Mapping

from ppaas.errors import InvalidParameter, QuotaExceeded

OVERSUBSCRIPTION = 4.0
"""Factor by which the cores given to containers may exceed the machine's cores: containers plan in bursts."""

MEMORY_PER_CORE = 128 << 20
"""Memory that counts for each core of a container's size [bytes]. A clone has 13 MB to itself, and shares its map."""

MEMORY_LIMIT = 512 << 20
"""Memory limit of a container of size 0 [bytes], where limits are enforced: its interpreter and planning."""

MEMORY_LIMIT_PER_CORE = 512 << 20
"""Additional limit for each core of its size [bytes]."""

MEMORY_LIMIT_PER_CELL = 64
"""Additional limit for each cell of its map [bytes]: twice the usage of our largest planner."""

MAPPING_MEMORY = 1 << 30
"""Additional limit for a robot that makes a new map, whose size is not known [bytes]: 4096 × 4096 cells."""


def check(size: float, machine_cores: int) -> None:
    """Check that a container of this size fits an empty machine.

    Raises
    ------
    InvalidParameter
        The size is not a positive, finite number.
    QuotaExceeded
        The size exceeds the cores of the machine.
    """
    if not (math.isfinite(size) and size > 0.0):
        raise InvalidParameter(f"the size of a container must be a positive number of cores, not {size}")
    if size > machine_cores:
        raise QuotaExceeded(f"a container of {size:g} cores does not fit a machine of {machine_cores} cores")


def threads(size: float) -> int:
    """Return the number of threads that the kernels of a container may use: ⌊size⌋, at least one."""
    return max(1, math.floor(size))


def width(size: float) -> int:
    """Return the number of CPUs that a container may run on: ⌈size⌉."""
    return math.ceil(size)


def memory(size: float) -> int:
    """Return the memory that a container counts for [bytes], in proportion to its size."""
    return math.ceil(size * MEMORY_PER_CORE)


def memory_limit(size: float, cells: int) -> int:
    """Return the memory limit of a container [bytes], by its size and the number of cells of its map."""
    return MEMORY_LIMIT + math.ceil(size * MEMORY_LIMIT_PER_CORE) + cells * MEMORY_LIMIT_PER_CELL


def capacity(machine_cores: int, machine_memory: int, oversubscription: float = OVERSUBSCRIPTION) -> float:
    """Return the capacity of a machine for containers [cores], by its CPUs and its memory [bytes]."""
    return min(machine_cores * oversubscription, machine_memory / MEMORY_PER_CORE)


def used(containers: Iterable[tuple[float, tuple[int, ...]]]) -> dict[int, float]:
    """Return the cores given to containers on each CPU, from the size and the CPUs of each container."""
    load: dict[int, float] = {}
    for size, cpus in containers:
        for cpu in cpus:
            load[cpu] = load.get(cpu, 0.0) + size / len(cpus)
    return load


def pick(size: float, cpus: Iterable[int], load: Mapping[int, float]) -> tuple[int, ...]:
    """Return the CPUs for a container: the least loaded ones, lower numbers first.

    Parameters
    ----------
    size : float
        Size of the container [cores].
    cpus : iterable of int
        All usable CPUs of the machine.
    load : mapping of int to float
        Cores given to containers on each CPU; a missing CPU has none.

    Raises
    ------
    InvalidParameter, QuotaExceeded
        From ``check``.
    """
    present = sorted(set(cpus))
    check(size, len(present))
    by_load = sorted(present, key=lambda cpu: (load.get(cpu, 0.0), cpu))
    return tuple(sorted(by_load[: width(size)]))
