"""Offsets of robots."""

import numpy as np

from ppaas.people.coordinator.positions import OffsetFilter


def test_an_offset_follows_what_is_seen_for_long_and_not_one_observation() -> None:
    offset = OffsetFilter()
    offset.covariance = np.diag([0.04, 0.04, 0.01])
    means = []
    for _ in range(50):
        offset.observe(np.array([[2.0, 0.0]]), np.array([[0.4, 0.0]]), np.array([0.01 * np.eye(2)]))
        means.append(float(offset.mean[0]))
    assert means[0] < 0.15
    assert means[-1] > 0.3
