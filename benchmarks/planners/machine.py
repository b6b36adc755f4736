"""Description of the machine and the software on which planners are measured."""

import os
import platform
from importlib.metadata import version
from typing import Any

from benchmarks.planners.timing import cpus
from ppaas import __version__


def describe() -> dict[str, Any]:
    """Return the kind of processor, the number of usable CPUs, the load by other processes, and versions."""
    from llvmlite import binding  # noqa: PLC0415 - only here, and not at the start of every command

    features = binding.get_host_cpu_features()
    return {
        "processor": f"{platform.machine()} ({binding.get_host_cpu_name()})",
        "avx512": bool(features.get("avx512f")),
        "cpus": cpus(),
        "load": os.getloadavg()[0],
        "system": platform.system(),
        "python": platform.python_version(),
        "numba": version("numba"),
        "numpy": version("numpy"),
        "ppaas": __version__,
    }
