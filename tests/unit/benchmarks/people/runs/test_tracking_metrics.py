"""HOTA and MOTA of identities."""

import numpy as np
import pytest

from benchmarks.people.runs.run import TrackRecord
from robots.demo.people_score import Frame

AT = np.array([[0.0, 0.0], [5.0, 0.0]])


def frame(identities: dict[int, int], *, edge: tuple[int, ...] = ()) -> Frame:
    at_edge = np.isin(np.arange(2), edge)
    positions = AT[list(identities.values())].reshape(-1, 2)
    return Frame(~at_edge, at_edge, list(identities), positions, dict(identities))


def test_right_tracks_have_metrics_of_one() -> None:
    record = TrackRecord()
    for _ in range(10):
        record.take(frame({7: 0, 9: 1}), AT)
    assert record.metrics() == pytest.approx((1.0, 1.0))


def test_switched_identities_and_missed_people_make_both_smaller() -> None:
    record = TrackRecord()
    for tick in range(10):
        record.take(frame({7: 0, 9: 1} if tick < 5 else {9: 0}), AT)
    hota, mota = record.metrics()
    assert mota == pytest.approx((20 - 5 - 1) / 20)
    assert 0.4 < hota < 0.8


def test_people_at_the_edge_count_neither_way() -> None:
    record = TrackRecord()
    for tick in range(10):
        record.take(frame({7: 0, 9: 1} if tick % 2 else {7: 0}, edge=(1,)), AT)
    assert record.metrics() == pytest.approx((1.0, 1.0))


def test_nobody_to_track_and_nobody_tracked_is_right() -> None:
    assert TrackRecord().metrics() == (1.0, 1.0)
