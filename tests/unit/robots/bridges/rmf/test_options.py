"""Reference points of levels, as configurations of fleet adapters have them."""

import math

import pytest

from ppaas.errors import InvalidInput
from robots.bridges.rmf.options import MOST_BYTES, read_frames

CONFIGURATION = b"""
rmf_fleet:
  name: carts
reference_coordinates:
  ground:
    rmf: [[1.0, 2.0], [1.0, 4.0], [-3.0, 2.0]]
    robot: [[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]]
  2: {rmf: [[0, 0], [1, 0]], robot: [[5, 5], [6, 5]]}
"""


def test_frames_are_read_by_level() -> None:
    found = read_frames(CONFIGURATION)
    assert list(found) == ["ground", "2"]
    ground = found["ground"]
    assert (ground.scale, ground.rotation, ground.x, ground.y) == pytest.approx((2.0, math.pi / 2, 1.0, 2.0))
    assert ground.residual == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"rmf_fleet: {}", "no 'reference_coordinates'"),
        (b"[1, 2]", "no 'reference_coordinates'"),
        (b"reference_coordinates: {L1: {rmf: [[0, 0]]}}", "level 'L1': 'rmf' and 'robot'"),
        (b"reference_coordinates: {L1: {rmf: [[0, 0, 1]], robot: [[0, 0]]}}", "level 'L1': 'rmf' and 'robot'"),
        (b"reference_coordinates: {L1: {rmf: [[a, 0]], robot: [[0, 0]]}}", "level 'L1': 'rmf' and 'robot'"),
        (b"reference_coordinates: {L1: {rmf: [[1, 0]], robot: [[0, 0]]}}", "level 'L1': .* two or more"),
        (b"a: [", "must be YAML"),
        (b"\xff\xfe\x00", "must be YAML"),
        (b" " * (MOST_BYTES + 1), "up to"),
    ],
)
def test_what_has_no_points_is_refused(content: bytes, text: str) -> None:
    with pytest.raises(InvalidInput, match=text):
        read_frames(content)
