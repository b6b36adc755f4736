"""Memory limit of a container, by its size and its map."""

from pathlib import Path

import numpy as np
from msgspec.structs import replace

from engine.runtimes.memory_limits import memory_of
from engine.specs.layer_files import write_layers
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from tests.support.engine.launches import Reports
from tests.support.engine.specs import mapping_spec

MIB = 1 << 20


def test_memory_limit_grows_with_size_and_map(tmp_path: Path) -> None:
    grid = GridMap(np.zeros((256, 512), np.int8), GridInfo(0.05, 512, 256, Pose2D(0.0, 0.0, 0.0)))
    write_layers(tmp_path, build_layers(grid), created=0.0)
    of_map = Reports(tmp_path).launch(cpus=(0, 1), layers=str(tmp_path))
    assert memory_of(of_map) == (512 + 2 * 512 + 8) * MIB
    new = replace(of_map, spec=mapping_spec(), layers="")
    assert memory_of(new) == (512 + 512 + 1024) * MIB
    assert memory_of(replace(of_map, layers=str(tmp_path / "gone"))) == (512 + 2 * 512) * MIB
