"""What the computer of a robot is worth: its cores, their clock, and how fast one is at a fixed kernel."""

import json
import logging
import os
import platform
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ppaas.clock import Clock, monotonic

logger = logging.getLogger(__name__)

REFERENCE_SECONDS = 0.028
"""What the kernel would take on a Raspberry Pi 4, by what such a core does beside others; not measured on one."""
REFERENCE_CLOCK = 1.5
"""Of a Raspberry Pi 4 [GHz], where a computer does not tell its own."""

ROUNDS = 7
CACHE = Path.home() / ".cache" / "ppaas" / "benchmark.json"

_CPU_FREQUENCY = Path("/sys/devices/system/cpu/cpu0/cpufreq/cpuinfo_max_freq")
_CPU_INFO = Path("/proc/cpuinfo")


@dataclass(frozen=True, slots=True)
class Computer:
    """What a robot has to run nodes on.

    Parameters
    ----------
    cores : int
        Of its processor.
    clock : float
        [GHz].
    benchmark : float
        How fast one core is, where a Raspberry Pi 4 is 1.
    """

    cores: int
    clock: float
    benchmark: float


def kernel(size: int = 65536, steps: int = 20000) -> tuple[float, int]:
    """Do what nodes do, always the same: numbers by the array, a sort, and a loop of Python's own."""
    values = np.sin(np.arange(size) * 12.9898) * 43758.5453
    values -= np.floor(values)
    state = 0
    for _ in range(steps):
        state = (state * 1103515245 + 12345) & 0x7FFFFFFF
    return float(np.cumsum(np.sort(values))[-1]), state


def measure(clock: Clock = monotonic) -> float:
    """Return how fast one core is; what else runs on the computer disturbs only the slower rounds."""
    best = float("inf")
    for _ in range(ROUNDS):
        began = clock()
        kernel()
        best = min(best, clock() - began)
    return REFERENCE_SECONDS / best


def clock_rate(frequency: Path = _CPU_FREQUENCY, info: Path = _CPU_INFO) -> float:
    """Return the clock of the processor [GHz], as Linux tells it; elsewhere that of a Raspberry Pi 4."""
    if frequency.exists():
        return int(frequency.read_text()) / 1e6
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("cpu MHz"):
                return float(line.partition(":")[2]) / 1e3
    return REFERENCE_CLOCK


def this_computer(cache: Path = CACHE) -> Computer:
    """Return what this computer is worth; the kernel is run once on it, and what came of it is kept in a file."""
    key = f"{platform.node()} {platform.machine()} {platform.python_version()} {np.__version__}"
    benchmark = _kept(cache, key)
    if benchmark is None:
        benchmark = measure()
        _keep(cache, key, benchmark)
    return Computer(os.cpu_count() or 1, clock_rate(), benchmark)


def _kept(cache: Path, key: str) -> float | None:
    try:
        kept = json.loads(cache.read_bytes())[key]
    except (OSError, ValueError, KeyError, TypeError):  # there is none yet, or it is not ours
        return None
    return float(kept) if isinstance(kept, int | float) and 0.0 < kept < 1e6 else None


def _keep(cache: Path, key: str, benchmark: float) -> None:
    try:
        cache.parent.mkdir(parents=True, exist_ok=True)
        cache.write_text(json.dumps({key: benchmark}))
    except OSError as error:
        logger.warning("the benchmark is measured again next time, since it cannot be kept: %s", error)
