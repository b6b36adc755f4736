"""Quotas of users, and their usage of the engine."""

from collections import defaultdict
from dataclasses import dataclass, fields, replace

from engine.master.machine import DECIMALS
from ppaas.errors import QuotaExceeded
from storage.records import Limits


@dataclass(frozen=True, slots=True)
class Quota:
    """Quota of one user.

    Parameters
    ----------
    containers : int
        Containers at once, for clones and for planning.
    cores : float
        Sum of the sizes of these containers [cores].
    robots : int
        Registered robots, connected or not.
    maps : int
        Maps that the user owns.
    plans_per_minute : int
        Paths requested by REST or by a service of the robot; plans that a clone makes for its own goals do not count.
    stored_bytes : int
        Size of the files of all versions of these maps, and of the URDFs of the robots [bytes].
    versions_per_map : int
        Versions of one map.
    """

    containers: int = 64
    cores: float = 64.0
    robots: int = 1000
    maps: int = 1000
    plans_per_minute: int = 120_000
    stored_bytes: int = 16 << 30
    versions_per_map: int = 1000

    def with_own(self, limits: Limits) -> "Quota":
        """Return this quota with a user's own limits in place of the defaults."""
        own = {name: getattr(limits, name) for name in QUOTAS}
        return replace(self, **{name: value for name, value in own.items() if value is not None})


QUOTAS = tuple(field.name for field in fields(Quota))


@dataclass(frozen=True, slots=True)
class Used:
    """Usage of one user: number of containers, and the sum of their sizes [cores]."""

    containers: int = 0
    cores: float = 0.0


class Quotas:
    """Quota and usage of every user.

    Parameters
    ----------
    default : Quota, optional
        Quota of users without own limits.
    """

    def __init__(self, default: Quota | None = None) -> None:
        self._default = default or Quota()
        self._limits: dict[str, Limits] = {}
        self._own: dict[str, Quota] = {}
        self._used: defaultdict[str, Used] = defaultdict(Used)

    def set_limits(self, user: str, limits: Limits) -> None:
        """Apply a user's own limits."""
        if limits == NO_LIMITS:
            self._limits.pop(user, None)
            self._own.pop(user, None)
        else:
            self._limits[user] = limits
            self._own[user] = self._default.with_own(limits)

    @property
    def default(self) -> Quota:
        """Quota of users without own limits."""
        return self._default

    def set_default(self, quota: Quota) -> None:
        """Apply another quota of users without own limits."""
        self._default = quota
        self._own = {user: quota.with_own(limits) for user, limits in self._limits.items()}

    def limits(self, user: str) -> Limits:
        """Return a user's own limits."""
        return self._limits.get(user, NO_LIMITS)

    def of(self, user: str) -> Quota:
        """Return the quota of a user."""
        return self._own.get(user, self._default)

    def used(self, user: str) -> Used:
        """Return the usage of a user."""
        return self._used.get(user, NOTHING)

    def check_container(self, user: str, cores: float) -> None:
        """Check that a user may have one more container of this size.

        Raises
        ------
        QuotaExceeded
            It would exceed the quota of containers or of cores.
        """
        check_quota(user, "containers", self.of(user).containers, self.used(user).containers)
        self.check_cores(user, cores)

    def check_cores(self, user: str, cores: float) -> None:
        """Check that a user may have ``cores`` more.

        Raises
        ------
        QuotaExceeded
            They would exceed the quota.
        """
        check_quota(user, "cores", self.of(user).cores, self.used(user).cores, cores)

    def add(self, user: str, containers: int, cores: float) -> None:
        """Add to the usage of a user; negative numbers subtract."""
        had = self._used[user]
        self._used[user] = Used(had.containers + containers, round(had.cores + cores, DECIMALS))
        if not self._used[user].containers:
            del self._used[user]


LONG = 1e6
"""Number from which the default format has an exponent."""

NO_LIMITS = Limits()
NOTHING = Used()


def check_quota(user: str, name: str, limit: float, used: float, more: float = 1) -> None:
    """Check that ``more`` of a resource stays within a user's limit.

    Raises
    ------
    QuotaExceeded
        It would exceed the limit; the text names the quota, the limit, the usage and the request.
    """
    if round(used + more, DECIMALS) > limit:
        raise QuotaExceeded(
            f"user {user!r} may have {_text(limit)} {name} and has {_text(used)}; {_text(more)} more would exceed the "
            f"limit: remove some, or ask an administrator to raise the quota {name!r}"
        )


def _text(number: float) -> str:
    return f"{number:g}" if number < LONG else f"{number:.0f}"
