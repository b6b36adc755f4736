"""Tests of the rate limit of path requests."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.master.quotas import Quota, Quotas
from engine.service.plan_rate import MAX_KNOWN, PlanRate
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


def test_a_minutes_paths_may_come_at_once_and_the_next_when_time_gives_it_back(
    rate: PlanRate, clock: ManualClock
) -> None:
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


def test_what_is_refused_counts_for_nothing(rate: PlanRate, clock: ManualClock) -> None:
    rate.take("ann", 5)
    for _ in range(10):
        with pytest.raises(QuotaExceeded):
            rate.take("ann", 2)
    rate.take("ann")


def test_what_can_never_be_given_says_no_time(rate: PlanRate) -> None:
    with pytest.raises(QuotaExceeded, match="fewer at once") as refused:
        rate.take("ann", 7)
    assert refused.value.retry_after is None


def test_who_may_ask_for_none_is_told_so(rate: PlanRate, quotas: Quotas) -> None:
    quotas.set_limits("ann", Limits(plans_per_minute=0))
    with pytest.raises(QuotaExceeded, match="0 paths a minute"):
        rate.take("ann")
    assert rate.used("ann") == 0


def test_a_limit_that_is_changed_holds_at_once(rate: PlanRate, quotas: Quotas) -> None:
    rate.take("ann", 6)
    quotas.set_limits("ann", Limits(plans_per_minute=600))
    with pytest.raises(QuotaExceeded) as refused:
        rate.take("ann")
    assert refused.value.retry_after == pytest.approx(0.1)


def test_users_of_long_ago_are_forgotten(rate: PlanRate, clock: ManualClock) -> None:
    for number in range(MAX_KNOWN):
        rate.take(f"u{number}")
    clock.advance(60.0)
    rate.take("ann")
    assert len(rate._whole) == 1


@given(st.lists(st.tuples(st.floats(0.0, 30.0), st.integers(1, 4)), max_size=60))
def test_no_minute_has_more_than_twice_the_quota_and_no_hour_more_than_its_share_and_one(
    asked: list[tuple[float, int]],
) -> None:
    clock = ManualClock(0.0)
    rate = PlanRate(Quotas(Quota(plans_per_minute=6)), clock)
    given_out = 0
    for pause, plans in asked:
        clock.advance(pause)
        try:
            rate.take("ann", plans)
        except QuotaExceeded:
            continue
        given_out += plans
        assert 0 < rate.used("ann") <= 6
        assert given_out <= 6 + clock() / 10.0 + 1e-6
