import pytest

from ppaas.recoveries import create
from tests.support.world.recovering import MIDDLE, Run


@pytest.mark.parametrize(
    ("parameters", "area"),
    [
        ({}, (MIDDLE, 3.0, "both")),
        ({"reset_distance": 0.0}, (MIDDLE, 0.0, "both")),
        ({"affected_maps": "local", "layer_names": ["obstacle_layer"]}, (MIDDLE, 3.0, "local")),
    ],
)
def test_distant_obstacles_are_cleared_once_at_rest(parameters, area):
    run = Run(create("clear_costmap_recovery", **parameters))
    assert run.to_the_end() == 0.0
    assert run.cleared == [area]
    assert not run.velocities


def test_nothing_is_cleared_without_layers():
    run = Run(create("clear_costmap_recovery", layer_names=[]))
    run.to_the_end()
    assert not run.cleared
