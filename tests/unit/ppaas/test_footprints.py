"""Footprints as users write them: lists and text, open and closed, with commas or spaces; and invalid values."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clone.robot_body import robot_body
from ppaas.controllers.drive_parameters import DriveParameters
from ppaas.errors import InvalidParameter
from ppaas.footprints import MAX_CORNERS, read_footprint
from ppaas.parameters import read_parameters
from ppaas.planners.lattice.parameters import LatticeParameters
from ppaas.polygons import within_polygon

SQUARE = [[0.2, 0.2], [0.2, -0.2], [-0.2, -0.2], [-0.2, 0.2]]


@pytest.mark.parametrize(
    "written",
    [
        SQUARE,
        [*SQUARE, [0.2, 0.2]],
        [*SQUARE[:2], SQUARE[1], *SQUARE[2:]],
        tuple(map(tuple, SQUARE)),
        "[[0.2, 0.2], [0.2, -0.2], [-0.2, -0.2], [-0.2, 0.2]]",
        "[ [0.2, 0.2], [0.2, -0.2], [-0.2, -0.2], [-0.2, 0.2], [0.2, 0.2] ]",
        "[[.2 .2] [2e-1 -.2] [-.2 -.2] [-.2 .2]]",
        "[[0.2,0.2],\n [0.2,-0.2],\n [-0.2,-0.2],\n [-0.2,0.2],]",
    ],
)
@pytest.mark.parametrize("kind", [DriveParameters, LatticeParameters])
def test_footprint_is_read_wherever_it_is_a_parameter(kind, written):
    corners = read_parameters(kind, "dwa", {"footprint": written}).footprint
    assert sorted(corners) == sorted(map(tuple, SQUARE))
    assert len(corners) == 4
    body = robot_body("turtlebot2", None, {"global_costmap": {"footprint": written}})
    assert (sorted(body.footprint), body.robot_radius) == (sorted(corners), 0.283)


@pytest.mark.parametrize("none", [[], "[]", "", " [ ] "])
def test_empty_footprint_is_a_disc(none):
    assert read_parameters(DriveParameters, "dwa", {"footprint": none}).footprint == ()


@pytest.mark.parametrize(
    "wrong",
    [
        "0.2 0.2", "[0.2, 0.2]", "[[0.2, 0.2], [0.2]]", "[[0.2, 0.2, 0.1]]", "[[a, b]]", "[[0.2, 0.2]", "[[[1 2]]]",
        "[[1, 2], [3, 4], ]]", "[" * 2000, "9" * 200_000, [[0, 0]] * (MAX_CORNERS + 1), 7, {"x": 1}, [[1, 2], 3],
        [[0, 0]] * 4, "[[nan, 0], [1, 0], [0, 1]]", [[0.2, 0.2], [0.2, -0.2], [0.2, 0.2]],
    ],
)  # fmt: skip
def test_what_is_no_footprint_is_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match="footprint"):
        read_parameters(DriveParameters, "dwa", {"footprint": wrong})


@given(st.text(alphabet="[] ,.1-e\n", max_size=60))
def test_any_text_is_a_list_of_corners_or_refused(text):
    try:
        corners = read_footprint(text)
    except InvalidParameter:
        return
    assert isinstance(corners, list)
    assert all(len(corner) == 2 and all(isinstance(number, float) for number in corner) for corner in corners)
    assert not any(math.isnan(number) for corner in corners for number in corner)


@pytest.mark.parametrize(("point", "inside"), [((1.0, 0.5), True), ((3.0, 0.5), False), ((1.0, 1.9), False)])
def test_a_polygon_may_have_a_notch(point: tuple[float, float], inside: bool) -> None:
    corners = np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 1.0), (0.0, 2.0)])
    assert within_polygon(corners, np.array([point])).tolist() == [inside]


@pytest.mark.filterwarnings("error")
def test_an_edge_that_is_nearly_level_overflows_nothing() -> None:
    corners = np.array([(0.0, 0.0), (4e9, 5e-324), (4e9, 2.0), (0.0, 2.0)])
    assert within_polygon(corners, np.array([(1.0, 1.0), (1.0, 3.0)])).tolist() == [True, False]
