"""Memory limit of a container, by its size and its map."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
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


@pytest.mark.parametrize(
    ("parameters", "more"),
    [
        ({"octomap_server": {}}, 512),
        ({"octomap_server": {"max_blocks": 1024}}, 4),
        ({"octomap_server": {"max_blocks": 1 << 60}}, 512),
        ({"depthimage_to_laserscan": {}}, 512),
        ({}, 0),
    ],
)
def test_memory_limit_has_space_for_the_blocks_of_a_3d_map(
    parameters: dict[str, Any], more: int, tmp_path: Path
) -> None:
    spec = mapping_spec()
    assert spec.robot is not None
    launch = replace(Reports(tmp_path).launch(cpus=(0, 1), layers=""), spec=spec)
    wider = replace(spec, robot=replace(spec.robot, parameters=parameters))
    assert memory_of(replace(launch, spec=wider)) - memory_of(launch) == more * MIB
