"""Step 1: maximum position deviation of each robot."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from ppaas.people.coordinator.positions import LEAST, UNKNOWN, maximum_position_deviation, position_deviation


def covariance(xx: float, xy: float, yy: float) -> NDArray[np.float64]:
    return np.array([[xx, xy, 0.0], [xy, yy, 0.0], [0.0, 0.0, 0.0]])


def test_the_deviation_holds_95_percent_along_the_widest_axis() -> None:
    assert position_deviation(covariance(0.04, 0.0, 0.01)) == pytest.approx(2.4477 * 0.2, rel=1e-3)


def test_the_deviation_does_not_depend_on_how_the_axes_lie() -> None:
    c, s = math.cos(0.7), math.sin(0.7)
    xx, xy, yy = c * c * 0.04 + s * s * 0.01, c * s * 0.03, s * s * 0.04 + c * c * 0.01
    assert position_deviation(covariance(xx, xy, yy)) == pytest.approx(position_deviation(covariance(0.04, 0.0, 0.01)))


def test_a_covariance_of_zeros_means_unknown() -> None:
    assert position_deviation(np.zeros((3, 3))) == UNKNOWN


def test_no_robot_is_surer_than_a_cell_of_the_map() -> None:
    assert position_deviation(covariance(1e-8, 0.0, 1e-8)) == LEAST


def test_the_maximum_over_the_history_counts() -> None:
    assert maximum_position_deviation([0.1, 0.9, 0.2]) == 0.9


def test_a_disagreement_with_other_robots_counts_as_a_deviation() -> None:
    assert maximum_position_deviation([0.1], disagreement=1.0) == 1.0


def test_a_robot_without_history_has_an_unknown_deviation() -> None:
    assert maximum_position_deviation([]) == UNKNOWN
