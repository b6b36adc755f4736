"""Memory limit of a container, for all runtimes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from engine.specs.containers import Launch
from engine.specs.cores import MAPPING_MEMORY, memory_limit
from engine.specs.layer_files import cells_in
from ppaas.nodes.octomap_server.parameters import BLOCKS, MOST_BLOCKS

BLOCK_BYTES = 2048
"""Size of a block of voxels of a 3D map."""


def memory_of(launch: Launch) -> int:
    """Return the memory limit of a container [bytes], by its size and its map."""
    robot = launch.spec.robot
    volume = _volume(robot.parameters, maps=launch.spec.maps) if robot is not None else 0
    if launch.spec.maps:
        return memory_limit(launch.spec.cores, 0) + MAPPING_MEMORY + volume
    return memory_limit(launch.spec.cores, cells_in(Path(launch.layers))) + volume


def _volume(parameters: Mapping[str, Any], *, maps: bool) -> int:
    """Return the additional limit for a robot that makes a 3D map [bytes]: twice its blocks, which are copied."""
    given = parameters.get("octomap_server")
    if given is None and not (maps and "depthimage_to_laserscan" in parameters):
        return 0
    blocks = given.get("max_blocks", BLOCKS) if isinstance(given, dict) else BLOCKS
    valid = isinstance(blocks, int) and 0 < blocks <= MOST_BLOCKS  # a clone with other parameters does not start
    return 2 * BLOCK_BYTES * (blocks if valid else BLOCKS)
