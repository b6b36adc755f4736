"""Tests of the rate limit of path requests."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.control.planning.plan_rate import MAX_KNOWN, PlanRate
from engine.master.quotas import Quota, Quotas
from ppaas.clock import ManualClock
from ppaas.errors import QuotaExceeded
from storage.records import Limits


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(1000.0)


@pytest.fixture
def quotas() -> Quotas:
    return Quotas(Quota(plans_per_minute=6))


@pytest.fixture
def rate(quotas: Quotas, clock: ManualClock) -> PlanRate:
    return PlanRate(quotas, clock)


def test_burst_of_a_minutes_paths_is_allowed_and_refills_over_time(rate: PlanRate, clock: ManualClock) -> None:
    for _ in range(6):
        rate.take("ann")
    with pytest.raises(QuotaExceeded, match="'ann' may request 6 paths a minute and has used 6;") as refused:
        rate.take("ann")
    assert refused.value.retry_after == pytest.approx(10.0)
    assert "plans_per_minute" in str(refused.value)
    rate.take("bob")
    clock.advance(10.0)
    rate.take("ann")
    with pytest.raises(QuotaExceeded):
        rate.take("ann")


def test_refused_requests_use_no_quota(rate: PlanRate, clock: ManualClock) -> None:
    rate.take("ann", 5)
    for _ in range(10):
        with pytest.raises(QuotaExceeded):
            rate.take("ann", 2)
    rate.take("ann")


def test_request_above_the_quota_has_no_retry_time(rate: PlanRate) -> None:
    with pytest.raises(QuotaExceeded, match="fewer at once") as refused:
        rate.take("ann", 7)
    assert refused.value.retry_after is None


def test_user_with_a_zero_quota_is_refused(rate: PlanRate, quotas: Quotas) -> None:
    quotas.set_limits("ann", Limits(plans_per_minute=0))
    with pytest.raises(QuotaExceeded, match="0 paths a minute"):
        rate.take("ann")
    assert rate.used("ann") == 0


def test_changed_limit_applies_at_once(rate: PlanRate, quotas: Quotas) -> None:
    rate.take("ann", 6)
    quotas.set_limits("ann", Limits(plans_per_minute=600))
    with pytest.raises(QuotaExceeded) as refused:
        rate.take("ann")
    assert refused.value.retry_after == pytest.approx(0.1)


def test_inactive_users_are_dropped(rate: PlanRate, clock: ManualClock) -> None:
    for number in range(MAX_KNOWN):
        rate.take(f"u{number}")
    clock.advance(60.0)
    rate.take("ann")
    assert len(rate._whole) == 1


@given(st.lists(st.tuples(st.floats(0.0, 30.0), st.integers(1, 4)), max_size=60))
def test_granted_paths_never_exceed_burst_plus_refill(
    requests: list[tuple[float, int]],
) -> None:
    clock = ManualClock(0.0)
    rate = PlanRate(Quotas(Quota(plans_per_minute=6)), clock)
    given_out = 0
    for pause, plans in requests:
        clock.advance(pause)
        try:
            rate.take("ann", plans)
        except QuotaExceeded:
            continue
        given_out += plans
        assert 0 < rate.used("ann") <= 6
        assert given_out <= 6 + clock() / 10.0 + 1e-6


def test_paths_ahead_are_a_small_share_of_the_quota_and_are_counted(clock: ManualClock) -> None:
    quotas = Quotas(Quota(plans_per_minute=6000))
    rate = PlanRate(quotas, clock)
    assert rate.take_ahead("ann", 1, 64) == 6
    assert rate.used("ann") == 7
    assert rate.take_ahead("ann", 1, 2) == 2
    assert rate.used("ann") == 10


@pytest.mark.parametrize("limit", [0, 1, 6])
def test_small_quotas_are_counted_exactly(clock: ManualClock, limit: int) -> None:
    rate = PlanRate(Quotas(Quota(plans_per_minute=limit)), clock)
    for _ in range(limit):
        assert rate.take_ahead("ann", 1, 64) == 0
    with pytest.raises(QuotaExceeded):
        rate.take_ahead("ann", 1, 64)


def test_no_paths_are_counted_ahead_at_the_end_of_a_quota(clock: ManualClock) -> None:
    rate = PlanRate(Quotas(Quota(plans_per_minute=2000)), clock)
    rate.take("ann", 1998)
    assert rate.take_ahead("ann", 1, 64) == 0
    with pytest.raises(QuotaExceeded):
        rate.take_ahead("ann", 2, 64)
