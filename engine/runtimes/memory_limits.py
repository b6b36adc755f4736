"""Memory limit of a container, for all runtimes."""

from pathlib import Path

from engine.specs.containers import Launch
from engine.specs.cores import MAPPING_MEMORY, memory_limit
from engine.specs.layer_files import cells_in


def memory_of(launch: Launch) -> int:
    """Return the memory limit of a container [bytes], by its size and its map."""
    if launch.spec.maps:
        return memory_limit(launch.spec.cores, 0) + MAPPING_MEMORY
    return memory_limit(launch.spec.cores, cells_in(Path(launch.layers)))
