"""Usage of stored resources per user, checked against the quota before one is added."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import ParamSpec, Protocol, TypeVar

from endpoints.accounts.stored_bytes import MapContent, StoredBytes
from endpoints.accounts.user_turns import LocalTurns, Turn, UserTurns, in_turn
from engine.master.quotas import Quotas, check_quota
from ppaas.errors import NotAuthenticated, NotFound
from storage.ports import MapStore, Store
from storage.records import MapFile
from storage.staged_uploads import StagedUpload
from storage.versions import map_version

P = ParamSpec("P")
T = TypeVar("T")


class HasQuotas(Protocol):
    """The engine, as far as usage needs it."""

    @property
    def quotas(self) -> Quotas:
        """Quotas of the users."""
        ...


class Stores(Protocol):
    """The stores, the engine, and the number of versions of a map that are kept; None for all."""

    @property
    def store(self) -> Store:
        """Store of everything but maps."""
        ...

    @property
    def map_store(self) -> MapStore:
        """Store of maps."""
        ...

    @property
    def cloud(self) -> HasQuotas:
        """The engine."""
        ...

    @property
    def keep_versions(self) -> int | None:
        """Number of versions of a map to keep."""
        ...


class Usage:
    """Quota checks of what users store.

    A check and the change that it allows are made in one turn of the user (``in_turn``), and so are removals. Endpoints
    that share the turns therefore never use the last place twice.

    Parameters
    ----------
    turns : UserTurns, optional
        Turns of the users; by default of this process alone.

    Attributes
    ----------
    stored : StoredBytes
        Stored bytes of the users.
    """

    def __init__(self, turns: UserTurns | None = None) -> None:
        self._turns = turns or LocalTurns()
        self.stored = StoredBytes()

    async def in_turn(self, user: str, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        """Return the result of blocking work on what a user stores, done in a thread during a turn of the user.

        Its errors are raised. It must be short, and must not wait for another turn of the user.

        Raises
        ------
        Unavailable
            There is no turn now.
        """

        def do(turn: Turn) -> T:
            self.stored.follow(user, turn)
            return work(*args, **kwargs)

        return await in_turn(self._turns, user, do)

    @contextmanager
    def new_robot(self, store: Store, quotas: Quotas, user: str, robot: str) -> Iterator[None]:
        """Check the quota, then store a robot, new or existing, in the ``with`` block; blocks. In a turn of the user.

        Raises
        ------
        QuotaExceeded
            The robot is new and the user already has the maximum.
        NotAuthenticated
            The user was removed meanwhile.
        """
        try:
            store.robot(user, robot)
        except NotFound:
            _check_present(store, user)
            check_quota(user, "robots", quotas.of(user).robots, robot_count(store, user))
        yield

    @contextmanager
    def new_map(self, stores: Stores, user: str, map_id: str, upload: StagedUpload) -> Iterator[None]:
        """Check the quota, then publish a map, new or existing, in the ``with`` block; blocks. In a turn of the user.

        Raises
        ------
        QuotaExceeded
            The map is new and the user already has the maximum, the version is new and the map has the maximum, or
            the user would have too many bytes.
        NotAuthenticated
            The map is new, and the user was removed meanwhile.
        """
        quota = stores.cloud.quotas.of(user)
        current: Mapping[str, MapFile] = {}
        try:
            head = stores.map_store.map_head(map_id)
            known, current = self.stored.of_map(stores.map_store, head), head.present.files
        except NotFound:
            _check_present(stores.store, user)
            check_quota(user, "maps", quota.maps, len(owned_maps(stores.map_store, user)))
            known = MapContent()
        if map_version(upload.files_after(current)) not in known.versions:
            count = len(known.versions)
            kept = count if stores.keep_versions is None else min(count, stores.keep_versions - 1)
            check_quota(user, "versions_per_map", quota.versions_per_map, kept)
        more = sum(file.size for file in upload.files.values() if file.sha256 not in known.files)
        self._check_bytes(stores, user, more)
        with self._forgotten_on_error(user):
            yield
        self.stored.add(user, more)

    @contextmanager
    def new_urdf(self, stores: Stores, user: str, robot: str, size: int) -> Iterator[None]:
        """Check the quota, then store a URDF of ``size`` bytes in the ``with`` block; blocks. In a turn of the user.

        Raises
        ------
        QuotaExceeded
            The user would have too many bytes.
        """
        more = size - self.stored.of_urdf(stores.store, user, robot)
        self._check_bytes(stores, user, more)
        with self._forgotten_on_error(user):
            yield
        self.stored.set_urdf(user, robot, size)
        self.stored.add(user, more)

    @contextmanager
    def _forgotten_on_error(self, user: str) -> Iterator[None]:
        """Count what a user has stored again if the block fails: nobody knows what it has stored by then."""
        try:
            yield
        except BaseException:
            self.stored.forget_user(user)
            raise

    def _check_bytes(self, stores: Stores, user: str, more: int) -> None:
        if more > 0:
            has = self.stored.of_user(stores.store, stores.map_store, user)
            check_quota(user, "stored_bytes", stores.cloud.quotas.of(user).stored_bytes, has, more)


def _check_present(store: Store, user: str) -> None:
    """Raise ``NotAuthenticated`` if a user was removed: what such a user stores now would be a later one's."""
    try:
        leaving = store.user(user).leaving
    except NotFound:
        leaving = True
    if leaving:
        raise NotAuthenticated("this user was removed")


def robot_count(store: Store, user: str) -> int:
    """Return the number of robots of a user."""
    return len(store.robots(user))


def owned_maps(map_store: MapStore, user: str) -> list[str]:
    """Return the ids of the maps that a user owns."""
    return [head.id for head in map_store.maps(user) if head.owner == user]
