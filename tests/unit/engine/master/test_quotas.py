"""Tests of quotas: limits and usage of users."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.master.quotas import QUOTAS, Quota, Quotas, Used, check_quota
from ppaas.errors import QuotaExceeded
from storage.records import Limits


def test_user_without_own_limits_has_the_default_quota() -> None:
    quotas = Quotas(Quota(containers=3))
    quotas.set_limits("ann", Limits())
    assert quotas.of("ann") == quotas.of("bob") == Quota(containers=3)


def test_own_limit_replaces_only_that_quota() -> None:
    quotas = Quotas(Quota(containers=3, cores=2.0))
    quotas.set_limits("ann", Limits(containers=0))
    assert quotas.of("ann") == Quota(containers=0, cores=2.0)
    assert quotas.limits("ann") == Limits(containers=0)
    quotas.set_limits("ann", Limits())
    assert quotas.of("ann").containers == 3
    assert quotas.limits("ann") == Limits()


def test_every_quota_has_an_own_limit() -> None:
    assert set(Limits.__struct_fields__) == set(QUOTAS)


def test_exceeded_quota_error_names_quota_limit_and_usage() -> None:
    quotas = Quotas(Quota(containers=2, cores=1.5))
    quotas.add("ann", 1, 1.0)
    with pytest.raises(QuotaExceeded, match=r"'ann' may have 1.5 cores and has 1; 0.75 more .* quota 'cores'"):
        quotas.check_container("ann", 0.75)
    quotas.check_container("ann", 0.5)
    quotas.add("ann", 1, 0.5)
    with pytest.raises(QuotaExceeded, match=r"'ann' may have 2 containers and has 2; 1 more .* quota 'containers'"):
        quotas.check_container("ann", 0.1)
    quotas.check_container("bob", 1.5)


def test_released_usage_is_available_again() -> None:
    quotas = Quotas(Quota(containers=1))
    quotas.add("ann", 1, 0.3)
    quotas.add("ann", -1, -0.3)
    assert quotas.used("ann") == Used()
    quotas.check_container("ann", 1.0)


@given(st.lists(st.integers(1, 400).map(lambda hundredths: hundredths / 100), max_size=50))
def test_sums_of_sizes_have_no_rounding_errors(sizes: list[float]) -> None:
    quotas = Quotas(Quota(containers=100, cores=round(sum(sizes), 2) or 1.0))
    for size in sizes:
        quotas.check_container("ann", size)
        quotas.add("ann", 1, size)
    assert quotas.used("ann") == Used(len(sizes), round(sum(sizes), 2))


def test_overused_quota_refuses_more() -> None:
    with pytest.raises(QuotaExceeded, match="3 maps and has 5"):
        check_quota("ann", "maps", 3, 5)


def test_another_default_holds_for_all_but_own_limits_and_keeps_the_usage() -> None:
    quotas = Quotas(Quota(containers=3, cores=2.0))
    quotas.set_limits("ann", Limits(containers=1))
    quotas.add("bob", 3, 1.0)
    quotas.set_default(Quota(containers=5, cores=9.0))
    assert quotas.default == quotas.of("bob") == Quota(containers=5, cores=9.0)
    assert quotas.of("ann") == Quota(containers=1, cores=9.0)
    quotas.check_container("bob", 8.0)
    quotas.set_limits("ann", Limits())
    assert quotas.of("ann").containers == 5
