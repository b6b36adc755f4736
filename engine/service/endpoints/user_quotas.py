"""Quotas of users, and the places that they hold, in the process of the master."""

from engine.master.places import robot_key
from engine.master.quotas import Quotas
from engine.service.master_driver import MasterDriver
from engine.service.planning.plan_rate import PlanRate
from engine.service.views import UserUsage
from ppaas.errors import PPaaSError
from storage.records import Limits


class UserQuotas:
    """Counts what users hold and request, and ends what they hold; implements ``UserCalls``.

    Parameters
    ----------
    driver : MasterDriver
        Driver of the master.
    quotas : Quotas
        Limits of the users.
    """

    def __init__(self, driver: MasterDriver, quotas: Quotas) -> None:
        self._driver = driver
        self._quotas = quotas
        self._rate = PlanRate(quotas)

    async def usage(self, user: str) -> UserUsage:
        """Return what counts against the quotas of a user, beside what is stored."""
        used = self._quotas.used(user)
        return UserUsage(used.containers, used.cores, self._rate.used(user))

    async def check_container(self, user: str, cores: float) -> None:
        """Raise ``QuotaExceeded`` if the quota of a user allows no other container of this size [cores]."""
        self._quotas.check_container(user, cores)

    async def take_paths(self, user: str, paths: int, ahead: int) -> int:
        """Count paths that a user requests, and further ones if the quota allows; return the number of these."""
        return self._rate.take_ahead(user, paths, ahead)

    async def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, and open the queued places that they allow."""
        if limits != self._quotas.limits(user):
            self._driver.set_limits(user, limits)

    async def end_places(self, user: str, reason: PPaaSError, robot: str | None = None) -> None:
        """Close all places of a user, or only the place of a robot."""
        if robot is None:
            await self._driver.close_places(user, reason)
        else:
            await self._driver.close_place(robot_key(user, robot), reason)
