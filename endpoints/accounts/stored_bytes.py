"""Stored bytes of a user: the files of all versions of the user's maps, and the URDFs of the user's robots."""

import threading
from dataclasses import dataclass, field

from ppaas.clock import Clock, monotonic
from ppaas.errors import NotFound
from storage.ports import MapStore, Store
from storage.records import MapRecord

PAGE = 32
"""Number of versions that are read at once; usually only the newest ones are new."""

LIFETIME = 60.0
"""Time for which the sum of a user is used before it is counted again [s]: other processes may change it."""


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


class StoredBytes:
    """Counts what users have stored, and remembers it, so that a publication reads only what is new. Thread-safe.

    Of changes by other processes that share the stores, additions are counted within ``LIFETIME``, and removals when
    this process changes the same map or starts again.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._maps: dict[str, MapContent] = {}
        self._urdfs: dict[tuple[str, str], int] = {}
        self._sums: dict[str, tuple[float, int]] = {}

    def of_map(self, map_store: MapStore, head: MapRecord) -> MapContent:
        """Return the versions and files of a map; blocks."""
        with self._lock:
            known = self._maps.get(head.id) or MapContent()
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
            self._maps[head.id] = found
        return found

    def of_user(self, store: Store, map_store: MapStore, user: str) -> int:
        """Return the stored bytes of a user; blocks."""
        with self._lock:
            until, known = self._sums.get(user, (float("-inf"), 0))
        if self._clock() < until:
            return known
        counted = sum(one.size for one in self.maps_of(map_store, user))
        counted += sum(self.of_urdf(store, user, record.id) for record in store.robots(user))
        with self._lock:
            self._sums[user] = self._clock() + LIFETIME, counted
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
        with self._lock:
            size = self._urdfs.get((user, robot))
        if size is None:
            try:
                size = len(store.urdf(user, robot))
            except NotFound:
                size = 0
            self.set_urdf(user, robot, size)
        return size

    def set_urdf(self, user: str, robot: str, size: int) -> None:
        """Remember the size of the URDF of a robot [bytes]."""
        with self._lock:
            self._urdfs[user, robot] = size

    def add(self, user: str, size: int) -> None:
        """Add bytes that a user has stored."""
        with self._lock:
            if user in self._sums:
                until, known = self._sums[user]
                self._sums[user] = until, known + size

    def forget_map(self, owner: str, map_id: str) -> None:
        """Count a map again, because it or some of its versions were removed."""
        with self._lock:
            self._maps.pop(map_id, None)
            self._sums.pop(owner, None)

    def forget_urdf(self, user: str, robot: str) -> None:
        """Read the size of a URDF again, because it or its robot was removed."""
        with self._lock:
            self._urdfs.pop((user, robot), None)
            self._sums.pop(user, None)

    def forget_user(self, user: str) -> None:
        """Forget the robots of a user, because the user was removed."""
        with self._lock:
            self._sums.pop(user, None)
            self._urdfs = {key: size for key, size in self._urdfs.items() if key[0] != user}
