"""Tests of quotas: limits and usage of users."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.master.quotas import QUOTAS, Quota, Quotas, Used, check_quota
from ppaas.errors import QuotaExceeded
from storage.records import Limits


def test_who_has_no_limits_of_the_own_may_have_what_all_may() -> None:
    quotas = Quotas(Quota(containers=3))
    quotas.set_limits("ann", Limits())
    assert quotas.of("ann") == quotas.of("bob") == Quota(containers=3)


def test_a_limit_of_ones_own_takes_the_place_of_that_one_alone() -> None:
    quotas = Quotas(Quota(containers=3, cores=2.0))
    quotas.set_limits("ann", Limits(containers=0))
    assert quotas.of("ann") == Quota(containers=0, cores=2.0)
    assert quotas.limits("ann") == Limits(containers=0)
    quotas.set_limits("ann", Limits())
    assert quotas.of("ann").containers == 3
    assert quotas.limits("ann") == Limits()


def test_there_is_a_limit_of_ones_own_for_every_quota() -> None:
    assert set(Limits.__struct_fields__) == set(QUOTAS)


def test_a_container_too_many_names_the_quota_its_limit_and_what_is_used() -> None:
    quotas = Quotas(Quota(containers=2, cores=1.5))
    quotas.add("ann", 1, 1.0)
    with pytest.raises(QuotaExceeded, match=r"'ann' may have 1.5 cores and has 1; 0.75 more .* quota 'cores'"):
        quotas.check_container("ann", 0.75)
    quotas.check_container("ann", 0.5)
    quotas.add("ann", 1, 0.5)
    with pytest.raises(QuotaExceeded, match=r"'ann' may have 2 containers and has 2; 1 more .* quota 'containers'"):
        quotas.check_container("ann", 0.1)
    quotas.check_container("bob", 1.5)


def test_what_is_given_back_may_be_had_again() -> None:
    quotas = Quotas(Quota(containers=1))
    quotas.add("ann", 1, 0.3)
    quotas.add("ann", -1, -0.3)
    assert quotas.used("ann") == Used()
    quotas.check_container("ann", 1.0)


@given(st.lists(st.integers(1, 400).map(lambda hundredths: hundredths / 100), max_size=50))
def test_sums_of_sizes_leave_no_traces_of_floats(sizes: list[float]) -> None:
    quotas = Quotas(Quota(containers=100, cores=round(sum(sizes), 2) or 1.0))
    for size in sizes:
        quotas.check_container("ann", size)
        quotas.add("ann", 1, size)
    assert quotas.used("ann") == Used(len(sizes), round(sum(sizes), 2))


def test_a_quota_of_which_more_is_used_than_may_be_gives_nothing() -> None:
    with pytest.raises(QuotaExceeded, match="3 maps and has 5"):
        check_quota("ann", "maps", 3, 5)
