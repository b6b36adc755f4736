import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from robots.sim.bodies.body import SEAT, BodyModel, Stance, body_shapes, head_height, leg_discs
from robots.sim.bodies.figure import Gait
from robots.sim.bodies.furniture import chair, coat_stand, column, furnished, mirror, poster, table
from robots.sim.depth.shapes import Shapes
from tests.support.world.rooms import room

HERE = Pose2D(2.0, 1.0, 0.7)


def top(shapes: Shapes) -> float:
    """Return the height of the highest point of a body."""
    axes = np.linalg.inv(shapes.solids[:, 4:].reshape(-1, 3, 3))
    solids = shapes.solids[:, 3] + np.sqrt((axes[:, 2] ** 2).sum(axis=1))
    capsules = np.maximum(shapes.capsules[:, 2], shapes.capsules[:, 5]) + shapes.capsules[:, 6]
    return float(max(solids.max(), capsules.max()))


def soles(shapes: Shapes) -> float:
    """Return the height of the lowest point of a body."""
    return float((np.minimum(shapes.capsules[:, 2], shapes.capsules[:, 5]) - shapes.capsules[:, 6]).min())


@given(st.floats(1.5, 1.95), st.floats(0.0, 0.45), st.floats(0.0, 6.28))
def test_a_body_stands_on_the_floor_and_is_as_tall_as_its_model(height: float, stride: float, phase: float) -> None:
    body, stance = BodyModel(height), Stance(stride, phase)
    shapes = body_shapes(body, stance, HERE)
    assert soles(shapes) == pytest.approx(0.0, abs=0.01)
    assert top(shapes) == pytest.approx(head_height(body, stance), abs=0.01)
    # The hips sink while the legs are apart.
    assert 0.93 * height <= head_height(body, stance) <= height + 1e-9


@given(st.floats(1.5, 1.95))
def test_who_sits_has_hips_on_the_seat_and_feet_on_the_floor(height: float) -> None:
    shapes = body_shapes(BodyModel(height), Stance(sitting=True), HERE)
    assert 0.0 <= soles(shapes) < 0.06
    assert 1.15 < top(shapes) < 1.50
    assert min(shapes.capsules[:, 2].min(), shapes.solids[:, 3].min()) < SEAT


def test_legs_swing_along_the_heading_in_turn() -> None:
    body, quarter = BodyModel(1.75), 0.5 * math.pi
    there, back = (leg_discs(body, Stance(0.4, phase), HERE, 0.2) for phase in (quarter, -quarter))
    apart = (there[0, :2] - there[1, :2]) @ (math.cos(HERE.theta), math.sin(HERE.theta))
    assert apart > 0.4
    assert (back[0, :2] - back[1, :2]) @ (math.cos(HERE.theta), math.sin(HERE.theta)) == pytest.approx(-apart)
    assert there[:, 2] == pytest.approx(0.031 * 1.75)
    standing = leg_discs(body, Stance(), HERE, 0.2)
    assert np.hypot(*(standing[0, :2] - standing[1, :2])) == pytest.approx(0.104 * 1.75)
    assert standing[:, :2].mean(axis=0) == pytest.approx(HERE[:2])


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
