import math

import pytest

from ppaas.controllers.drive_parameters import body_of, check_footprint
from ppaas.errors import InvalidParameter

BOX = ((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2))


def test_footprint_may_have_either_orientation_or_be_empty():
    for footprint in (BOX, BOX[::-1], ()):
        check_footprint(footprint)


@pytest.mark.parametrize(
    "wrong",
    [
        ((0.1, 0.1),),
        ((0.1, 0.1), (0.2, 0.2)),
        ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0)),
        ((0.2, math.inf), (-0.2, 0.2), (-0.2, -0.2)),
        ((0.2, math.nan), (-0.2, 0.2), (-0.2, -0.2)),
    ],
)
def test_invalid_footprint_is_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match="footprint"):
        check_footprint(wrong)


def test_body_has_inscribed_and_circumscribed_radii():
    box = body_of(BOX, 0.0)
    assert (box.inscribed, box.circumscribed) == pytest.approx((0.2, math.hypot(0.3, 0.2)))
    assert box.edges[0] == pytest.approx((0.3, 0.2, -1.0, 0.0, 0.6))
    disc = body_of((), 0.25)
    assert (len(disc.edges), disc.inscribed, disc.circumscribed) == (0, 0.25, 0.25)
