import math

import pytest

from ppaas.errors import InvalidParameter
from ppaas.mapping.lifelong.parameters import LifelongParameters


@pytest.mark.parametrize(
    "given",
    [{"lifelong_iou_match": 0.0}, {"lifelong_iou_match": 1.5}, {"pass_distance": math.nan}, {"least_new_frames": -1}],
)
def test_values_out_of_range_are_refused(given):
    with pytest.raises(InvalidParameter, match=next(iter(given))):
        LifelongParameters(**given)
