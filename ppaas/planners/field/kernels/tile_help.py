"""Kernel: call helper threads to a tile field, and release them.

Each helper has a mailbox (*box*). The caller writes the helper's task into it before it wakes the helper. The first
word of the box is its owner: `NOBODY`; `WRITTEN` while a caller is writing; or the address of a field's state, plus a
flag that the helper has been called or has arrived. The word changes by compare-and-swap only. So a call can be revoked
without waiting as long as the helper has not arrived, and a helper that arrives too late finds no task."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.field.kernels.tile_record import RECORD, SCRATCH_MEMORY, STATE, store_array
from ppaas.planners.field.kernels.tile_rows import SCRATCH
from ppaas.planners.field.kernels.tile_state import ALIGNED, APART, CALLED, LINE, STOP, THREADS
from ppaas.planners.kernels import atomics
from ppaas.planners.kernels.addresses import address_of, int64s_of
from ppaas.planners.kernels.wakeup import send_byte, sleep, wait_for_byte

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]

WORD, HEARS, RINGS, OVER, THREAD, FIELD_RECORD = 0, *range(LINE, LINE + 5)
"""Elements of a box: owner; read and write end of the pipe that wakes the helper; whether the helper must exit; number
of the thread in the field; address of the field's record, followed by its length."""
BOX = 2 * LINE
"""Length of a box [int64 numbers]."""

NOBODY, WRITTEN = 0, 1
_CALLED, _CAME = 1, 2
"""Flags added to the address of a field's state, which is a multiple of `ALIGNED`."""
POLL_INTERVAL = 50
"""Time between two polls for helpers to leave [µs]."""


@bare
def _claim(boxes: Ints) -> Int:
    """Claim a free box for writing and return its number; −1 if there is none."""
    for number in range(len(boxes)):
        if atomics.replace(boxes[number], WORD, NOBODY, WRITTEN):
            return np.int64(number)
    return np.int64(-1)


@bare
def call_one(boxes: Ints, record: Ints) -> bool:
    """Call one more helper to a field; return false if no helper is free, or the field has its maximum of threads.

    Parameters
    ----------
    boxes : (n, BOX) int64 array
        Mailboxes of all available helpers.
    record : (RECORD,) int64 array
        As in `ppaas.planners.field.kernels.tile_record`.
    """
    state, threads = int64s_of(record, STATE), record[SCRATCH_MEMORY + 1] // SCRATCH
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
    send_byte(box[RINGS])
    return True


@bare
def release_helpers(boxes: Ints, record: Ints) -> None:
    """Ask all helpers of a field to leave, without waiting: the scheduler may have preempted one.

    Calls of helpers that have not arrived yet are revoked.
    """
    state = int64s_of(record, STATE)
    atomics.write(state, STOP, 1)
    called = address_of(state) + _CALLED
    for number in range(len(boxes)):
        box = boxes[number]
        thread = box[THREAD]
        if atomics.replace(box, WORD, called, NOBODY):
            atomics.write(state, THREADS + thread * APART + CALLED, 0)


@bare
def wait_for_call(box: Ints) -> bool:
    """Sleep until called, and accept the call; return false if the helper must exit."""
    while not atomics.read(box, OVER):
        word = atomics.read(box, WORD)
        if word % ALIGNED == _CALLED and atomics.replace(box, WORD, word, word - _CALLED + _CAME):
            return True
        wait_for_byte(box[HEARS])
    return False


@bare
def finish(box: Ints) -> None:
    """Mark the helper as free."""
    atomics.write(box, WORD, NOBODY)


@bare
def wait_briefly() -> None:
    """Sleep for `POLL_INTERVAL`."""
    sleep(POLL_INTERVAL)


def warm() -> None:
    """Compile and call each kernel that Python calls."""
    wait_briefly()
    record, state = np.zeros(RECORD, np.int64), np.zeros(THREADS, np.int64)
    store_array(record, STATE, state)
    release_helpers(np.zeros((0, BOX), np.int64), record)
