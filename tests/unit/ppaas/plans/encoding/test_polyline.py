"""Encoded polylines."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.plans.encoding.polyline import polyline_of

coordinates = st.floats(-1e6, 1e6)


def decoded(text: str, decimals: int) -> list[list[float]]:
    """Return the points of a polyline, as the description of the format decodes it: character by character."""
    numbers, value, shift = list[int](), 0, 0
    for character in text:
        part = ord(character) - 63
        value |= (part & 31) << shift
        shift += 5
        if not part & 32:
            numbers.append(~(value >> 1) if value & 1 else value >> 1)
            value = shift = 0
    points = np.cumsum(np.array(numbers, np.int64).reshape(-1, 2), axis=0)
    return (points / 10.0**decimals).tolist()


def test_the_example_of_the_format() -> None:
    points = np.array([[38.5, -120.2], [40.7, -120.95], [43.252, -126.453]])
    assert polyline_of(points, 5) == "_p~iF~ps|U_ulLnnqC_mqNvxq`@"


@given(st.lists(st.tuples(coordinates, coordinates), max_size=20))
def test_points_round_trip_to_the_millimetre(points: list[tuple[float, float]]) -> None:
    given_points = np.array(points).reshape(-1, 2)
    again = np.array(decoded(polyline_of(given_points), 3)).reshape(-1, 2)
    np.testing.assert_allclose(again, given_points, rtol=0.0, atol=5.001e-4)


def test_a_step_between_cells_takes_four_characters() -> None:
    points = np.cumsum(np.full((100, 2), 0.05), axis=0)
    assert len(polyline_of(points)) == pytest.approx(400, abs=8)
