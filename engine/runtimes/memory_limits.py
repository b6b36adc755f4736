"""How much memory a container may take, whatever holds it to that."""

from pathlib import Path

from engine.specs.containers import Launch
from engine.specs.cores import memory_limit
from engine.specs.layer_files import cells_in


def memory_of(launch: Launch) -> int:
    """Return how many bytes a container may take, by its size and its map."""
    return memory_limit(launch.spec.cores, cells_in(Path(launch.layers)))
