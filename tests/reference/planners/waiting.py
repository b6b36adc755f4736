"""What waits, in the order of whom to take: the slow and obvious way."""


class Waiting:
    """Tiles that wait with a key, and who woke them."""

    def __init__(self) -> None:
        self.keys: dict[int, int] = {}
        self.reasons: dict[int, set[int]] = {}
        self.busy: set[int] = set()

    def wake(self, tile: int, key: int, reason: int) -> bool:
        """Let a tile wait with a key, unless it waits with a lesser one; return whether it was idle."""
        idle = tile not in self.keys and tile not in self.busy
        self.keys[tile] = min(key, self.keys.get(tile, key))
        self.reasons.setdefault(tile, set()).add(reason)
        return idle

    def least(self) -> int | None:
        """Return the least key of those that nobody works on."""
        return min((key for tile, key in self.keys.items() if tile not in self.busy), default=None)

    def take(self, tile: int) -> tuple[int, set[int]]:
        """Let somebody work on a tile; return with which key it waited, and for which reasons."""
        self.busy.add(tile)
        return self.keys.pop(tile), self.reasons.pop(tile)

    def let_go(self, tile: int) -> bool:
        """End the work on a tile; return whether it waits again."""
        self.busy.remove(tile)
        return tile in self.keys
