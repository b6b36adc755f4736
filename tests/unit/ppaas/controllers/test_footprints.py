import math

import pytest

from ppaas.controllers.footprints import body_of, checked_footprint
from ppaas.errors import InvalidParameter

BOX = ((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2))


def test_a_footprint_of_json_is_taken_and_may_go_round_either_way():
    assert checked_footprint([list(corner) for corner in BOX]) == BOX
    assert checked_footprint(BOX[::-1]) == BOX[::-1]
    assert checked_footprint([]) == ()


@pytest.mark.parametrize(
    "wrong",
    [
        [[0.1, 0.1], [0.2, 0.2]],
        [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]],
        [[0.2, math.inf], [-0.2, 0.2], [-0.2, -0.2]],
        [[0.2, 0.2, 0.0], [-0.2, 0.2, 0.0], [-0.2, -0.2, 0.0]],
        "box",
    ],
)
def test_what_is_no_outline_around_the_origin_is_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match="footprint"):
        checked_footprint(wrong)


def test_a_body_has_the_circles_of_its_outline():
    box = body_of(BOX, 0.0)
    assert (box.inscribed, box.circumscribed) == pytest.approx((0.2, math.hypot(0.3, 0.2)))
    assert box.edges[0] == pytest.approx((0.3, 0.2, -1.0, 0.0, 0.6))
    disc = body_of((), 0.25)
    assert (len(disc.edges), disc.inscribed, disc.circumscribed) == (0, 0.25, 0.25)
