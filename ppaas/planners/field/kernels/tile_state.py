"""What the threads that grow a field of tiles tell each other: an array of int64.

- `STOP`: whether all are to leave.
- `ACTIVE`: how many threads may still wake a tile.
- `OVERLONG`: whether values grow too large.
- From `THREADS` on `APART` numbers for each thread, the planner's own before its helpers: at `WAITING` how many tiles
  it woke less those it took, at `LINES` those of tiles that it did, at `CALLED` whether it was called and has not left.
"""

LINE = 8
"""Numbers of a cache line: what one thread often writes lies as far from what others read."""
STOP, ACTIVE, OVERLONG, THREADS = (LINE * place for place in range(4))
ALIGNED = 8 * LINE
"""Bytes of a line: it begins at a multiple of so many."""
WAITING, LINES, CALLED, APART = 0, 1, LINE, 2 * LINE


def state_size(threads: int) -> int:
    """Return how many numbers the state has for so many threads."""
    return THREADS + threads * APART
