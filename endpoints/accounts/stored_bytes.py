"""Stored bytes of a user: the files of all versions of the user's maps, and the URDFs of the user's robots."""

import threading
from dataclasses import dataclass, field

from endpoints.accounts.user_turns import Turn
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.errors import NotFound
from storage.ports import MapStore, Store
from storage.records import MapRecord

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
