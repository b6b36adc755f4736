import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from ppaas.controllers.drive_parameters import body_of
from ppaas.controllers.kernels.clearance import REACH, clearance, clearance_along, warm
from ppaas.controllers.obstacles import distance_to_lethal
from ppaas.maps.kernels.distance import distance_serial
from tests.reference.driving import controllers as pursuit
from tests.reference.driving import controllers as twin
from tests.support.world import grids


@pytest.mark.parametrize("allow_unknown", [True, False])
def test_distances_are_to_lethal_and_disallowed_unknown_cells(allow_unknown):
    data = np.random.default_rng(1).choice(np.array([0, 200, 253, 254, 255], np.uint8), (30, 40), p=[0.9, *[0.025] * 4])
    blocked = (data == 254) | ((data == 255) & (not allow_unknown))
    got = distance_to_lethal(grids.of(data, 0.05), allow_unknown=allow_unknown)
    assert got == pytest.approx(distance_transform_edt(~blocked) * 0.05, abs=1e-5)


def test_distance_without_lethal_cells_exceeds_the_costmap():
    assert (distance_to_lethal(grids.of(np.full((4, 5), 253, np.uint8), 0.05), allow_unknown=True) > 5 * 0.05).all()


EDGE = 0.05
BOX = ((0.25, 0.2), (-0.25, 0.2), (-0.25, -0.2), (0.25, -0.2))


def field(seed, density, size=60):
    lethal = np.random.default_rng(seed).random((size, size)) < density
    lethal[0, 0] = True
    return lethal, distance_serial(lethal.view(np.uint8), EDGE)


@given(
    seed=st.integers(0, 10_000),
    pose=st.tuples(st.floats(0.5, 2.5), st.floats(0.5, 2.5), st.floats(-3.2, 3.2)),
)
def test_clearance_of_an_outline_agrees_with_the_twin(seed, pose):
    lethal, distance = field(seed, 0.003)
    body = body_of(BOX, 0.0)
    x, y, theta = pose
    got = clearance(distance, EDGE, body, x, y, math.cos(theta), math.sin(theta))
    measured = twin.outline_distance(lethal, EDGE, np.array(BOX), pose)
    centre = twin.bilinear(distance, x, y, EDGE)
    if centre <= body.inscribed:
        assert got <= 0.0
    elif centre > body.circumscribed + REACH:
        assert measured - 0.15 < got < measured + 0.05
    else:
        # Distances are interpolated between the centres of cells, and steps along an edge skip small differences.
        assert got < 1.16 * measured + 0.04
        # For an obstacle between circle and outline, the clearance is the distance to the circle if that is less.
        assert got > measured - 0.04 or twin.outline_holds(lethal, EDGE, np.array(BOX), pose)


@given(
    seed=st.integers(0, 10_000),
    pose=st.tuples(st.floats(0.8, 2.2), st.floats(0.8, 2.2), st.floats(-3.2, 3.2)),
    motion=st.tuples(st.floats(-1.0, 1.0), st.floats(-2.0, 2.0)),
    corners=st.sampled_from([BOX, ()]),
)
@example(seed=98, pose=(0.8, 0.8125, 0.75), motion=(0.796875, 0.0), corners=BOX)
def test_clearance_along_an_arc_is_the_minimum_over_its_poses(seed, pose, motion, corners):
    _, distance = field(seed, 0.002)
    body = body_of(corners, 0.18)
    got = clearance_along(distance, EDGE, body, pose, motion)
    # Samples are a twentieth of a cell apart, so values between them differ by no more than that.
    poses = pursuit.arc(pose, *motion, 600)
    clearances = [clearance(distance, EDGE, body, x, y, math.cos(a), math.sin(a)) for x, y, a in poses]
    # The nearest sampled pose is within half a cell of any pose, and the nearest sampled point of an edge within a
    # quarter; between the middles of cells a distance changes by up to √2 m a metre.
    assert min(clearances) - 0.05 * EDGE <= got <= min(clearances) + 0.75 * math.sqrt(2.0) * EDGE
    assert got <= min(clearances[0], clearances[-1]) + 1e-6


def test_warm_runs():
    warm()
