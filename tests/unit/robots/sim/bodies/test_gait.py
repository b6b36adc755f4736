import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from robots.sim.bodies.body import BodyModel, leg_discs
from robots.sim.bodies.figure import Gait


def test_a_foot_on_the_floor_hardly_slides() -> None:
    body, x, tracks = BodyModel(1.75), 0.0, []
    gait = Gait(body, 0.0)
    for step in range(300):
        gait.move((1.2, 0.0), 0.02)
        x += 1.2 * 0.02
        if step > 100:
            tracks.append(leg_discs(body, gait.stance, Pose2D(x, 0.0, gait.heading), 0.07)[:, 0])
    speeds = np.diff(np.array(tracks), axis=0) / 0.02
    # At any time one foot is nearly at rest, and the other swings.
    assert np.abs(speeds).min(axis=1).mean() < 0.5
    assert speeds.max() > 2.0


def test_the_body_faces_where_it_walks_and_then_where_it_should() -> None:
    gait = Gait(BodyModel(), 0.0)
    for _ in range(50):
        gait.move((0.0, 1.0), 0.02)
    assert gait.heading == pytest.approx(0.5 * math.pi)
    assert gait.stance.stride > 0.2
    for _ in range(100):
        gait.move((0.0, 0.0), 0.02, facing=math.pi)
    assert abs(gait.heading) == pytest.approx(math.pi)
    assert gait.stance.stride < 0.01
