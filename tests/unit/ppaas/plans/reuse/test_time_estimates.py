"""Estimates follow measurements, borrow from other complexities, and report their uncertainty."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clock import ManualClock
from ppaas.plans.history import LinkHistory, bucket_of, computed_row
from ppaas.plans.reuse.time_estimates import ComputationTimes, LinkTimes

KEY = ("house", "v1", "dijkstra")


def test_unmeasured_planner_has_no_estimate() -> None:
    times = ComputationTimes()
    times.note("astar", 100.0, 0.1)
    assert times.expect("dijkstra", 100.0) is None


@given(st.floats(min_value=1e-5, max_value=10.0), st.integers(min_value=1, max_value=200))
def test_constant_times_give_their_value_with_growing_certainty(seconds: float, count: int) -> None:
    times, widths = ComputationTimes(), []
    for _ in range(count):
        times.note("dijkstra", 500.0, seconds)
        expected = times.expect("dijkstra", 500.0)
        assert expected is not None
        assert expected.mean == pytest.approx(seconds, rel=1e-6)
        assert expected.lower < seconds < expected.upper
        widths.append(expected.upper / expected.lower)
    assert widths[-1] <= widths[0] * (1 + 1e-9)


def test_unseen_complexity_is_extrapolated_with_less_certainty() -> None:
    times = ComputationTimes()
    for cells, _ in itertools.product((64.0, 128.0, 256.0), range(20)):
        times.note("dijkstra", cells, cells * 1e-5)
    near, far = times.expect("dijkstra", 512.0), times.expect("dijkstra", 4096.0)
    assert near is not None
    assert far is not None
    assert near.mean == pytest.approx(512e-5, rel=0.1)
    assert far.mean == pytest.approx(4096e-5, rel=0.1)
    assert far.upper / far.lower > near.upper / near.lower


def test_estimate_follows_changed_times() -> None:
    times = ComputationTimes()
    for seconds in (*itertools.repeat(1.0, 500), *itertools.repeat(0.01, 300)):
        times.note("dijkstra", 500.0, seconds)
    expected = times.expect("dijkstra", 500.0)
    assert expected is not None
    assert expected.mean < 0.015


def test_stored_history_counts_like_local_measurements() -> None:
    measured, kept = ComputationTimes(), ComputationTimes()
    for seconds in (0.1, 0.2, 0.15):
        measured.note("dijkstra", 500.0, seconds)
        kept.add([computed_row((*KEY, bucket_of(500.0)), seconds)])
    here, there = measured.expect("dijkstra", 500.0), kept.expect("dijkstra", 500.0)
    assert here is not None
    assert there is not None
    assert there.mean == pytest.approx(here.mean, rel=1e-3)


@given(st.floats(min_value=1e-4, max_value=0.5), st.floats(min_value=1e6, max_value=1e10))
def test_link_estimate_is_round_trip_plus_size_over_bandwidth(round_trip: float, bandwidth: float) -> None:
    clock = ManualClock()
    link = LinkTimes(clock)
    for size in (100.0, 300_000.0, 1000.0, 50_000.0) * 20:
        link.note(size, round_trip + size / bandwidth)
    for size in (100.0, 300_000.0):
        expected = link.expect(size)
        assert expected.lower <= expected.mean <= expected.upper
        # The prior weighs as much as one of the ten answers that count.
        assert expected.mean == pytest.approx(round_trip + size / bandwidth, rel=0.3, abs=3e-3)


def test_unused_link_returns_to_the_prior_estimate() -> None:
    clock = ManualClock()
    link = LinkTimes(clock)
    before = link.expect(1e5)
    for _ in range(20):
        link.note(1e5, 1.0)
    slow = link.expect(1e5)
    clock.advance(1800.0)
    assert slow.mean > 0.5 > link.expect(1e5).mean
    assert link.expect(1e5).mean == pytest.approx(before.mean, rel=0.01)


def test_stored_link_history_is_used_until_measured() -> None:
    link = LinkTimes(ManualClock())
    link.start_from(LinkHistory("m1", 0.1, 1e6, 100, 0.0))
    assert link.expect(0.0).mean > 0.05
    for _ in range(30):
        link.note(1000.0, 0.001)
    assert link.expect(1000.0).mean < 0.01
    assert link.history("m1", 5.0).answers == 130
