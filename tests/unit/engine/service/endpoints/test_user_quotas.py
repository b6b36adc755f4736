"""Quotas of users in the process of the master."""

from typing import Any

import pytest

from engine.master.quotas import Quota, Quotas
from engine.service.endpoints.cloud import UserQuotas
from engine.service.views import UserUsage
from ppaas.errors import NotAuthenticated, QuotaExceeded
from storage.records import Limits


class Driver:
    """Notes what it is asked to do."""

    def __init__(self, quotas: Quotas) -> None:
        self.quotas = quotas
        self.did: list[tuple[Any, ...]] = []

    def set_limits(self, user: str, limits: Limits) -> None:
        self.did.append((user, limits))
        self.quotas.set_limits(user, limits)

    async def close_places(self, user: str, reason: Exception) -> None:
        self.did.append((user, reason))

    async def close_place(self, key: str, reason: Exception) -> None:
        self.did.append((key, reason))


@pytest.fixture
def driver() -> Driver:
    return Driver(Quotas(Quota(containers=1, cores=1.0, plans_per_minute=2000)))


@pytest.fixture
def users(driver: Driver) -> UserQuotas:
    return UserQuotas(driver, driver.quotas)  # type: ignore[arg-type]


async def test_limits_are_applied_once(users: UserQuotas, driver: Driver) -> None:
    limits = Limits(containers=3)
    await users.set_limits("ann", limits)
    await users.set_limits("ann", limits)
    assert driver.did == [("ann", limits)]


async def test_paths_count_against_the_quota_and_some_are_counted_ahead(users: UserQuotas) -> None:
    assert await users.take_paths("ann", 3, 64) == 2, "a thousandth of the quota"
    assert await users.usage("ann") == UserUsage(0, 0.0, 5)
    with pytest.raises(QuotaExceeded):
        await users.take_paths("ann", 2000, 0)


async def test_a_container_above_the_quota_is_refused(users: UserQuotas) -> None:
    await users.check_container("ann", 1.0)
    with pytest.raises(QuotaExceeded):
        await users.check_container("ann", 2.0)


async def test_all_places_of_a_user_are_ended_or_only_the_place_of_a_robot(users: UserQuotas, driver: Driver) -> None:
    reason = NotAuthenticated("this user was removed")
    await users.end_places("ann", reason)
    await users.end_places("ann", reason, "tb1")
    assert driver.did == [("ann", reason), ("robot:ann/tb1", reason)]
