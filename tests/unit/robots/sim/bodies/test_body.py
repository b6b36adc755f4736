import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from robots.sim.bodies.body import SEAT, BodyModel, Stance, body_shapes, head_height, leg_discs
from robots.sim.depth.shapes import Shapes

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
