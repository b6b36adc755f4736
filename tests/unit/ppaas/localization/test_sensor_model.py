"""Beams and hits that a sensor model chooses from one scan."""

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.sensor_model import sensor_model
from ppaas.thread_budget import one_thread
from tests.support.world.planar_world import World, walled_map

LAYERS = build_layers(walled_map(6, 4, [(3.0, 1.0, 3.4, 2.0)]))
LASER = Pose2D(0.1, 0.0, 0.3)


@pytest.mark.parametrize("most", [5, 60, 1000])
@pytest.mark.parametrize("kind", ["likelihood_field", "likelihood_field_prob", "beam"])
def test_beams_and_hits_are_those_that_are_chosen_one_by_one(kind: str, most: int) -> None:
    model = sensor_model(LAYERS, AmclParameters(laser_model_type=kind, laser_max_range=3.0), one_thread)
    scan = World(LAYERS.grid, Pose2D(1.5, 2.0, 0.2)).scan(0.0)
    beams, hits = model.beams_and_hits(scan, LASER, most)
    np.testing.assert_array_equal(beams, model.beams(scan, LASER))
    np.testing.assert_array_equal(hits, model.hits(scan, LASER, most))
    assert 0 < len(hits) <= most
