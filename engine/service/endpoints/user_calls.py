"""Calls of the master about users: what they hold, and what their quotas allow."""

from typing import Protocol

from engine.service.views import UserUsage
from ppaas.errors import PPaaSError
from storage.records import Limits


class UserCalls(Protocol):
    """Places and quotas of users."""

    async def usage(self, user: str) -> UserUsage:
        """Return what counts against the quotas of a user, beside what is stored."""
        ...

    async def check_container(self, user: str, cores: float) -> None:
        """Raise ``QuotaExceeded`` if the quota of a user allows no other container of this size [cores]."""
        ...

    async def take_paths(self, user: str, paths: int, ahead: int) -> int:
        """Count paths that a user requests, and up to ``ahead`` further ones; return the number of these.

        Raises
        ------
        QuotaExceeded
            They exceed the quota; see ``PlanRate.take``.
        """
        ...

    async def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits, as they are stored; opens the queued places that they allow."""
        ...

    async def end_places(self, user: str, reason: PPaaSError, robot: str | None = None) -> None:
        """Close all places of a user, or only the place of a robot, and notify their clients of the reason."""
        ...
