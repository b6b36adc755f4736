"""Shared state of the threads that grow a tile field: an array of int64.

- `STOP`: whether all threads must leave.
- `ACTIVE`: number of threads that may still queue a tile.
- `OVERLONG`: whether values have become too large for 32 bits.
- From `THREADS` on, `APART` numbers for each thread; thread 0 is the planner's own, the others are helpers. `WAITING`:
  tiles that it queued minus tiles that it took; `LINES`: lines of tiles that it processed; `CALLED`: whether it has
  been called and has not left.
"""

LINE = 8
"""Numbers in a cache line. Numbers that one thread writes often are in another line than those that others read."""
STOP, ACTIVE, OVERLONG, THREADS = (LINE * place for place in range(4))
ALIGNED = 8 * LINE
"""Size and alignment of a cache line [bytes]."""
WAITING, LINES, CALLED, APART = 0, 1, LINE, 2 * LINE
"""Offsets in the numbers of a thread, and their count."""


def state_size(threads: int) -> int:
    """Return the length of the state for a number of threads."""
    return THREADS + threads * APART
