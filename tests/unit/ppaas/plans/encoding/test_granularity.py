import pytest

from ppaas.errors import InvalidInput
from ppaas.plans.encoding.granularity import GRANULARITY, inner_granularity


@pytest.mark.parametrize("granularity", [-1, 0, 1, 65537])
def test_invalid_granularity_is_refused(granularity: int) -> None:
    with pytest.raises(InvalidInput, match="granularity"):
        inner_granularity(granularity)


def test_plans_are_cut_with_half_of_the_granularity() -> None:
    assert inner_granularity(GRANULARITY) == 8
    assert inner_granularity(3) == 1
