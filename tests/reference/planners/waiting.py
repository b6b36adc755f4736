"""Slow, obvious twin of the priority queue of tiles."""


class Waiting:
    """Queued tiles with their keys, and the reasons for which they were woken."""

    def __init__(self) -> None:
        self.keys: dict[int, int] = {}
        self.reasons: dict[int, set[int]] = {}
        self.busy: set[int] = set()

    def wake(self, tile: int, key: int, reason: int) -> bool:
        """Queue a tile with a key, or lower its key to it; return whether it was idle."""
        idle = tile not in self.keys and tile not in self.busy
        self.keys[tile] = min(key, self.keys.get(tile, key))
        self.reasons.setdefault(tile, set()).add(reason)
        return idle

    def least(self) -> int | None:
        """Return the least key of the queued tiles that are not being worked on."""
        return min((key for tile, key in self.keys.items() if tile not in self.busy), default=None)

    def take(self, tile: int) -> tuple[int, set[int]]:
        """Take a tile from the queue; return its key and its reasons."""
        self.busy.add(tile)
        return self.keys.pop(tile), self.reasons.pop(tile)

    def let_go(self, tile: int) -> bool:
        """End the work on a tile; return whether it is queued again."""
        self.busy.remove(tile)
        return tile in self.keys
