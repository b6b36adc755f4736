"""What each user may have at a time, and what each has of the engine."""

from collections import defaultdict
from dataclasses import dataclass, fields, replace

from engine.master.machine import DECIMALS
from ppaas.errors import QuotaExceeded
from storage.records import Limits, User


@dataclass(frozen=True, slots=True)
class Quota:
    """What one user may have.

    Parameters
    ----------
    containers : int
        Clones that run and planning on a map, together.
    cores : float
        Of these containers, together.
    robots : int
        Robots that are told of, connected or not.
    maps : int
        Maps that the user owns, however many versions each has.
    plans_per_minute : int
        Paths asked for by REST or as a service of the robot; not what a clone plans on its way.
    """

    containers: int = 64
    cores: float = 64.0
    robots: int = 1000
    maps: int = 1000
    plans_per_minute: int = 120_000

    def with_own(self, limits: Limits) -> "Quota":
        """Return what a user may have who has limits of the user's own."""
        own = {name: getattr(limits, name) for name in QUOTAS}
        return replace(self, **{name: value for name, value in own.items() if value is not None})


QUOTAS = tuple(field.name for field in fields(Quota))


@dataclass(frozen=True, slots=True)
class Used:
    """What a user has of the engine."""

    containers: int = 0
    cores: float = 0.0


class Quotas:
    """The quota of every user, and what is used of it.

    Parameters
    ----------
    default : Quota, optional
        Of each user who has no limits of the user's own.
    """

    def __init__(self, default: Quota | None = None) -> None:
        self._default = default or Quota()
        self._own: dict[str, Quota] = {}
        self._used: defaultdict[str, Used] = defaultdict(Used)

    def learn(self, user: User) -> None:
        """Note what the store says that a user may have."""
        if user.limits == NO_LIMITS:
            self._own.pop(user.id, None)
        else:
            self._own[user.id] = self._default.with_own(user.limits)

    def forget(self, user: str) -> None:
        """Forget the limits of a user who is no more."""
        self._own.pop(user, None)

    def of(self, user: str) -> Quota:
        """Return what a user may have."""
        return self._own.get(user, self._default)

    def used(self, user: str) -> Used:
        """Return what a user has."""
        return self._used.get(user, NOTHING)

    def check_container(self, user: str, cores: float) -> None:
        """Make sure that a user may have one more container of this size.

        Raises
        ------
        QuotaExceeded
            It would be one too many, or too large.
        """
        check_quota(user, "containers", self.of(user).containers, self.used(user).containers)
        self.check_cores(user, cores)

    def check_cores(self, user: str, cores: float) -> None:
        """Make sure that a user may have so many cores more.

        Raises
        ------
        QuotaExceeded
            They would be too many.
        """
        check_quota(user, "cores", self.of(user).cores, self.used(user).cores, cores)

    def add(self, user: str, containers: int, cores: float) -> None:
        """Note that a user has more, or less if they are negative."""
        had = self._used[user]
        self._used[user] = Used(had.containers + containers, round(had.cores + cores, DECIMALS))
        if not self._used[user].containers:
            del self._used[user]


NO_LIMITS = Limits()
NOTHING = Used()


def check_quota(user: str, name: str, limit: float, used: float, more: float = 1) -> None:
    """Make sure that a user may have so much more of something.

    Raises
    ------
    QuotaExceeded
        It would be over the limit; the text names the quota, the limit, what is used and what was asked for.
    """
    if round(used + more, DECIMALS) > limit:
        raise QuotaExceeded(
            f"user {user!r} may have {limit:g} {name} and has {used:g}; {more:g} more cannot be given: "
            f"remove what is not needed, or let an administrator raise the quota {name!r}"
        )
