import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from robots.sim.bodies.furniture import chair, coat_stand, column, furnished, mirror, poster, table
from tests.support.world.rooms import room


def test_footprints_of_furniture_are_occupied_on_the_map_of_people() -> None:
    grid = room(6.0, 5.0)
    pieces = [table(Pose2D(2.0, 2.0, 0.5 * math.pi), 1.6, 0.8), column(Pose2D(4.0, 3.0)), poster(Pose2D(0.1, 2.0))]
    changed = furnished(grid, pieces).data != grid.data
    assert changed[40, 40]
    assert changed[grid.info.cell_of(2.0, 2.7)]
    assert not changed[grid.info.cell_of(2.7, 2.0)]
    assert changed[grid.info.cell_of(4.0, 3.0)]
    assert np.count_nonzero(changed) * 0.05**2 == pytest.approx(1.6 * 0.8 + 0.4**2, rel=0.1)


def test_legs_of_furniture_turn_with_it() -> None:
    legs = np.array(chair(Pose2D(1.0, 1.0, 0.3)).discs)
    assert legs[:, :2].mean(axis=0) == pytest.approx((1.0, 1.0))
    assert np.hypot(*(legs[:, :2] - (1.0, 1.0)).T) == pytest.approx(math.hypot(0.202, 0.202))
    assert len(coat_stand(Pose2D(0.0, 0.0)).discs) == 1


def test_a_mirror_has_no_body() -> None:
    piece = mirror(Pose2D(3.0, 2.0, math.pi), 1.0)
    assert not len(piece.shapes.solids)
    assert piece.mirror is not None
    assert (piece.mirror.x1, piece.mirror.y1, piece.mirror.y2) == pytest.approx((3.0, 2.5, 1.5))
    # Its normal points to the room ahead or to the wall behind; both sides reflect.
    assert abs(piece.mirror.normal[0]) == pytest.approx(1.0)
