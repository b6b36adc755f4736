"""Usage of stored resources per user: counted, remembered, and checked against the quota before one is added."""

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import ParamSpec, Protocol, TypeVar

from endpoints.accounts.user_turns import LocalTurns, Turn, UserTurns, in_turn
from engine.master.quotas import Quotas, check_quota
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.errors import NotAuthenticated, NotFound
from storage.ports import MapStore, Store
from storage.records import MapFile, MapRecord
from storage.staged_uploads import StagedUpload
from storage.versions import map_version

# Stored bytes of a user: the files of all versions of the user's maps, and the URDFs of the user's robots.

PAGE = 32
"""Number of versions that are read at once; usually only the newest ones are new."""

LIFETIME = 60.0
"""Time for which what is shown of a user is used before it is counted again [s]: other endpoints may change it."""

MAX_USERS = 1000
"""Largest number of users of whom something is remembered; the longest unused ones are forgotten first."""


@dataclass(slots=True)
class MapContent:
    """Versions and files of a map up to a publication; the files by their hash, with their sizes [bytes]."""

    number: int = 0
    versions: set[str] = field(default_factory=set)
    files: dict[str, int] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Size of all files [bytes]; a file that several versions have counts once."""
        return sum(self.files.values())


@dataclass(slots=True)
class _Remembered:
    """Storage of one user, as counted last: the last turn of this endpoint, the sum [bytes], and the counted parts.

    ``changes`` counts what this endpoint has changed, since what was read before a change must not be remembered.
    """

    since: float
    turn: str | None = None
    sum: int | None = None
    maps: dict[str, MapContent] = field(default_factory=dict)
    urdfs: dict[str, int] = field(default_factory=dict)
    changes: int = 0


class StoredBytes:
    """Counts what users have stored, and remembers it, so that a publication reads only what is new. Thread-safe.

    What is remembered is true during a turn of the user: it is forgotten if another endpoint had a turn since the last
    one of this endpoint. Outside of turns, as when it is shown, it may be as old as ``LIFETIME``.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._users: BoundedDict[str, _Remembered] = BoundedDict(MAX_USERS)

    def follow(self, user: str, turn: Turn) -> None:
        """Begin a turn of a user: forget what another endpoint may have changed."""
        with self._lock:
            known = self._users.get(user)
            if known is None or turn.before is None or known.turn != turn.before:
                known = _Remembered(self._clock())
            known.turn = turn.id
            self._users[user] = known

    def refresh(self, user: str) -> None:
        """Forget what is older than ``LIFETIME``, before what a user has stored is shown."""
        with self._lock:
            known = self._users.get(user)
            if known is not None and self._clock() - known.since >= LIFETIME:
                self._users[user] = _Remembered(self._clock(), known.turn)

    def of_map(self, map_store: MapStore, head: MapRecord) -> MapContent:
        """Return the versions and files of a map; blocks."""
        remembered, changes = self._of(head.owner)
        known = remembered.maps.get(head.id) or MapContent()
        if known.number == head.present.number:
            return known
        found = MapContent(head.present.number, set(known.versions), dict(known.files))
        before: int | None = None
        while page := map_store.versions(head.id, before=before, limit=PAGE):
            for one in page:
                found.versions.add(one.version)
                found.files |= {file.sha256: file.size for file in one.files.values()}
            before = page[-1].number
            if before <= known.number or len(page) < PAGE:
                break
        for review in map_store.reviews(head.id):
            found.files |= {file.sha256: file.size for file in review.files.values()}
        with self._lock:
            if remembered.changes == changes:
                remembered.maps[head.id] = found
        return found

    def of_user(self, store: Store, map_store: MapStore, user: str) -> int:
        """Return the stored bytes of a user; blocks."""
        remembered, changes = self._of(user)
        known = remembered.sum
        if known is not None:
            return known
        counted = sum(one.size for one in self.maps_of(map_store, user))
        counted += sum(self.of_urdf(store, user, record.id) for record in store.robots(user))
        with self._lock:
            if remembered.changes == changes:
                remembered.sum = counted
        return counted

    def maps_of(self, map_store: MapStore, user: str) -> list[MapContent]:
        """Return the content of each map of a user; blocks."""
        found = []
        for head in map_store.maps(user):
            if head.owner == user:
                try:
                    found.append(self.of_map(map_store, head))
                except NotFound:  # removed meanwhile
                    continue
        return found

    def of_urdf(self, store: Store, user: str, robot: str) -> int:
        """Return the size of the URDF of a robot [bytes], 0 if it has none; blocks."""
        remembered, changes = self._of(user)
        size = remembered.urdfs.get(robot)
        if size is None:
            try:
                size = len(store.urdf(user, robot))
            except NotFound:
                size = 0
            with self._lock:
                if remembered.changes == changes:
                    remembered.urdfs[robot] = size
        return size

    def set_urdf(self, user: str, robot: str, size: int) -> None:
        """Remember the size of a URDF that was stored [bytes]; ``add`` adds it."""
        remembered, _ = self._of(user)
        with self._lock:
            remembered.changes += 1
            remembered.urdfs[robot] = size

    def add(self, user: str, size: int) -> None:
        """Add bytes that a user has stored."""
        remembered, _ = self._of(user)
        with self._lock:
            remembered.changes += 1
            if remembered.sum is not None:
                remembered.sum += size

    def forget_map(self, owner: str, map_id: str) -> None:
        """Count a map again, because it or some of its versions were removed."""
        remembered, _ = self._of(owner)
        with self._lock:
            remembered.changes += 1
            remembered.maps.pop(map_id, None)
            remembered.sum = None

    def forget_urdf(self, user: str, robot: str) -> None:
        """Read the size of a URDF again, because it or its robot was removed."""
        remembered, _ = self._of(user)
        with self._lock:
            remembered.changes += 1
            remembered.urdfs.pop(robot, None)
            remembered.sum = None

    def forget_user(self, user: str) -> None:
        """Forget all that is remembered of a user, because the user was removed."""
        with self._lock:
            self._users.pop(user, None)

    def _of(self, user: str) -> tuple[_Remembered, int]:
        """Return what is remembered of a user, and the number of changes so far."""
        with self._lock:
            known = self._users.get(user)
            if known is None:
                known = self._users[user] = _Remembered(self._clock())
            return known, known.changes


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
