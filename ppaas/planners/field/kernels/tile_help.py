"""Kernel: call other threads to help with a field of tiles, and send them away.

Each helper has a *box*, in which what it is to help with is written before it is woken. The first word of a box tells
whose it is: nobody's, somebody's who is just writing into it, or that of one field, given by the address of its state,
with a bit for whether the helper was called, or has come. It changes by compare-and-swap: so a helper that has not
come yet can be sent away without waiting for it, and one that comes too late finds nothing.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.field.kernels.tile_record import RECORD, SCRATCH_MEMORY, STATE, note
from ppaas.planners.field.kernels.tile_rows import SCRATCH
from ppaas.planners.field.kernels.tile_state import ALIGNED, APART, CALLED, LINE, STOP, THREADS
from ppaas.planners.kernels import atomics
from ppaas.planners.kernels.addresses import address_of, longs_of
from ppaas.planners.kernels.jit_decorators import bare
from ppaas.planners.kernels.wakeup import doze, hear, ring

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]

WORD, HEARS, RINGS, OVER, THREAD, FIELD_RECORD = 0, *range(LINE, LINE + 5)
"""Of a box: whose it is; both ends of the pipe that wakes its helper, and whether that is to end for good; which of the
threads of a field the helper is to be, and where the record of that field lies, followed by how long it is."""
BOX = 2 * LINE
"""Numbers of a box."""

NOBODY, WRITTEN = 0, 1
_CALLED, _CAME = 1, 2
"""What is added to the address of a field's state, which is a multiple of `ALIGNED`."""
PATIENCE = 50
"""How long who waits for helpers sleeps before it looks again [µs]."""


@bare
def _claim(boxes: Ints) -> Int:
    """Return the number of a box that was nobody's and is ours to write into now, or −1."""
    for number in range(len(boxes)):
        if atomics.replace(boxes[number], WORD, NOBODY, WRITTEN):
            return np.int64(number)
    return np.int64(-1)


@bare
def call_one(boxes: Ints, record: Ints) -> bool:
    """Call one more helper to a field; return false if there is none, or no more may work at it.

    Parameters
    ----------
    boxes : (n, BOX) int64 array
        Of all helpers who may be called.
    record : (RECORD,) int64 array
        As in `ppaas.planners.field.kernels.tile_record`.
    """
    state, threads = longs_of(record, STATE), record[SCRATCH_MEMORY + 1] // SCRATCH
    thread = 1
    while thread < threads and atomics.read(state, THREADS + thread * APART + CALLED):
        thread += 1
    number = _claim(boxes) if thread < threads else -1
    if number < 0:
        return False
    box = boxes[number]
    box[THREAD], box[FIELD_RECORD], box[FIELD_RECORD + 1] = thread, address_of(record), len(record)
    atomics.write(state, THREADS + thread * APART + CALLED, 1)
    atomics.write(box, WORD, address_of(state) + _CALLED)
    ring(box[RINGS])
    return True


@bare
def send_away(boxes: Ints, record: Ints) -> None:
    """Tell all helpers of a field to leave, and do not wait for them: one may have been put aside for a while.

    Those who were called and have not come yet never will.
    """
    state = longs_of(record, STATE)
    atomics.write(state, STOP, 1)
    called = address_of(state) + _CALLED
    for number in range(len(boxes)):
        box = boxes[number]
        thread = box[THREAD]
        if atomics.replace(box, WORD, called, NOBODY):
            atomics.write(state, THREADS + thread * APART + CALLED, 0)


@bare
def comes(box: Ints) -> bool:
    """Sleep until called, and come; return false when it is over."""
    while not atomics.read(box, OVER):
        word = atomics.read(box, WORD)
        if word % ALIGNED == _CALLED and atomics.replace(box, WORD, word, word - _CALLED + _CAME):
            return True
        hear(box[HEARS])
    return False


@bare
def leave(box: Ints) -> None:
    """Be free to be called by anybody."""
    atomics.write(box, WORD, NOBODY)


@bare
def rest() -> None:
    """Sleep for a moment, as who waits for helpers does before it looks again."""
    doze(PATIENCE)


def warm() -> None:
    """Compile and call each kernel once that Python calls."""
    rest()
    record, state = np.zeros(RECORD, np.int64), np.zeros(THREADS, np.int64)
    note(record, STATE, state)
    send_away(np.zeros((0, BOX), np.int64), record)
