"""A doubled array keeps its items."""

import numpy as np
import pytest

from ppaas.planners import array_growth
from ppaas.planners.watch import proceed


@pytest.mark.parametrize("shape", [(1,), (7,), (5, 2)])
def test_the_doubled_array_begins_with_the_old_items(shape: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(array_growth, "SLICE_COPIED", 12)
    before = np.arange(np.prod(shape), dtype=np.int32).reshape(shape)
    after = array_growth.doubled(before, proceed)
    assert after.shape == (2 * shape[0], *shape[1:]) and after.dtype == before.dtype
    assert (after[: len(before)] == before).all()


def test_check_is_called_for_each_slice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(array_growth, "SLICE_COPIED", 8)
    checks: list[int] = []
    array_growth.doubled(np.zeros(6, np.int32), lambda: checks.append(1))
    assert len(checks) == 3
