"""Computing power of the robot's computer: number of cores, clock rate, and speed of one core in a benchmark."""

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
"""Time of the benchmark on a Raspberry Pi 4 [s]; estimated from its core's relative speed, not measured."""
REFERENCE_CLOCK = 1.5
"""Clock rate of a Raspberry Pi 4 [GHz]: the default if a computer does not report its own."""

ROUNDS = 7
"""Number of runs of the benchmark; the fastest counts."""
CACHE = Path.home() / ".cache" / "ppaas" / "benchmark.json"
"""File with the result of an earlier benchmark."""

_CPU_FREQUENCY = Path("/sys/devices/system/cpu/cpu0/cpufreq/cpuinfo_max_freq")
_CPU_INFO = Path("/proc/cpuinfo")


@dataclass(frozen=True, slots=True)
class Computer:
    """Computer of a robot.

    Parameters
    ----------
    cores : int
        Number of CPU cores.
    clock : float
        Clock rate [GHz].
    benchmark : float
        Speed of one core, relative to a Raspberry Pi 4.
    """

    cores: int
    clock: float
    benchmark: float


def kernel(size: int = 65536, steps: int = 20000) -> tuple[float, int]:
    """Run a fixed workload like the workload of nodes: array arithmetic, a sort, and a loop in pure Python."""
    values = np.sin(np.arange(size) * 12.9898) * 43758.5453
    values -= np.floor(values)
    state = 0
    for _ in range(steps):
        state = (state * 1103515245 + 12345) & 0x7FFFFFFF
    return float(np.cumsum(np.sort(values))[-1]), state


def measure(clock: Clock = monotonic) -> float:
    """Return the speed of one core, relative to a Raspberry Pi 4; other load affects only the slower runs."""
    best = float("inf")
    for _ in range(ROUNDS):
        began = clock()
        kernel()
        best = min(best, clock() - began)
    return REFERENCE_SECONDS / best


def clock_rate(frequency: Path = _CPU_FREQUENCY, info: Path = _CPU_INFO) -> float:
    """Return the clock rate of the processor as Linux reports it [GHz]; elsewhere the rate of a Raspberry Pi 4."""
    if frequency.exists():
        return int(frequency.read_text()) / 1e6
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("cpu MHz"):
                return float(line.partition(":")[2]) / 1e3
    return REFERENCE_CLOCK


def this_computer(cache: Path = CACHE) -> Computer:
    """Return the computing power of this computer; the benchmark runs once, and its result is cached in a file."""
    key = f"{platform.node()} {platform.machine()} {platform.python_version()} {np.__version__}"
    benchmark = _cached(cache, key)
    if benchmark is None:
        benchmark = measure()
        _store(cache, key, benchmark)
    return Computer(os.cpu_count() or 1, clock_rate(), benchmark)


def _cached(cache: Path, key: str) -> float | None:
    try:
        value = json.loads(cache.read_bytes())[key]
    except (OSError, ValueError, KeyError, TypeError):  # no file yet, or of another computer
        return None
    return float(value) if isinstance(value, int | float) and 0.0 < value < 1e6 else None


def _store(cache: Path, key: str, benchmark: float) -> None:
    try:
        cache.parent.mkdir(parents=True, exist_ok=True)
        cache.write_text(json.dumps({key: benchmark}))
    except OSError as error:
        logger.warning("cannot cache the benchmark, so it will run again next time: %s", error)
