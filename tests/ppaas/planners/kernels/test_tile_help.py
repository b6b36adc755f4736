import os
import threading

import numpy as np
import pytest

from ppaas.planners.kernels import tile_help
from ppaas.planners.kernels.addresses import address_of, longs_at, map_at, numbers_at, octets_at
from ppaas.planners.kernels.bare import bare
from ppaas.planners.kernels.tile_help import BOX, HEARS, NOBODY, OVER, RINGS, STATE, TARGET, THREAD, WORD, WRITTEN
from ppaas.planners.kernels.tile_rows import SCRATCH
from ppaas.planners.kernels.tile_state import APART, CALLED, STOP, THREADS, state_size


@pytest.fixture
def boxes():
    """Two boxes, and nobody who would hear."""
    found = np.zeros((2, BOX), np.int64)
    for box in found:
        box[HEARS], box[RINGS] = os.pipe()
    yield found
    for box in found:
        os.close(box[HEARS])
        os.close(box[RINGS])


class Field:
    def __init__(self, threads):
        octets = np.empty(8 * state_size(threads) + 64, np.uint8)
        begin = -octets.ctypes.data % 64
        self.state = octets[begin : begin + 8 * state_size(threads)].view(np.int64)
        self.state[:] = 0
        self._numbers, self._scratch = np.zeros(4, np.uint32), np.zeros(threads * SCRATCH, np.uint32)

    def call(self, boxes):
        octets, n = np.zeros(4, np.uint8), self._numbers
        return tile_help.call_one(
            boxes, octets, 1, 1, 0, n, n, octets, 1, 1, octets, n, n, n, self._scratch, self.state, 5
        )

    def called(self):
        return np.flatnonzero(self.state[THREADS + CALLED :: APART]).tolist()


def test_each_who_is_called_is_told_of_the_field_and_of_its_number(boxes):
    field = Field(3)
    assert field.call(boxes)
    assert field.call(boxes)
    assert boxes[:, THREAD].tolist() == field.called() == [1, 2]
    assert boxes[:, STATE].tolist() == [field.state.ctypes.data] * 2
    assert boxes[:, STATE + 1].tolist() == [len(field.state)] * 2
    assert boxes[:, TARGET].tolist() == [5, 5]
    assert [os.read(box[HEARS], 9) for box in boxes] == [b"\1", b"\1"]


def test_no_more_are_called_than_may_work_at_the_field_or_there_are(boxes):
    small, large = Field(2), Field(9)
    assert [small.call(boxes), small.call(boxes)] == [True, False]
    assert [large.call(boxes), large.call(boxes)] == [True, False]
    assert not large.call(boxes[:0])


def test_who_is_called_comes_once(boxes):
    field = Field(2)
    field.call(boxes)
    assert tile_help.comes(boxes[0])
    boxes[0, OVER] = 1
    assert not tile_help.comes(boxes[0])
    tile_help.leave(boxes[0])
    assert boxes[0, WORD] == NOBODY


def test_who_was_sent_away_before_it_came_never_comes(boxes):
    field, other = Field(3), Field(2)
    field.call(boxes)
    tile_help.send_away(boxes, field.state)
    assert field.state[STOP]
    assert field.called() == []
    assert boxes[0, WORD] == NOBODY
    assert other.call(boxes)
    assert tile_help.comes(boxes[0])
    assert boxes[0, STATE] == other.state.ctypes.data


def test_who_has_come_leaves_by_itself_when_sent_away(boxes):
    field = Field(2)
    field.call(boxes)
    tile_help.comes(boxes[0])
    tile_help.send_away(boxes, field.state)
    assert field.called() == [1]
    assert boxes[0, WORD] not in (NOBODY, WRITTEN)


def test_helpers_of_others_are_not_sent_away(boxes):
    field, other = Field(2), Field(2)
    field.call(boxes)
    other.call(boxes)
    tile_help.send_away(boxes, other.state)
    assert field.called() == [1]
    assert other.called() == []
    assert tile_help.comes(boxes[0])


def test_a_sleeper_wakes_when_it_is_called_and_not_when_only_the_bell_rings(boxes):
    came = threading.Event()
    sleeper = threading.Thread(target=lambda: (tile_help.comes(boxes[0]), came.set()))
    sleeper.start()
    os.write(boxes[0, RINGS], b"!")
    assert not came.wait(0.05)
    Field(2).call(boxes[:1])
    assert came.wait(30)
    sleeper.join()


@bare
def doubled(octets, read_only, numbers, longs):
    """Double what lies where the arrays do, as one does who knows the addresses alone."""
    first = octets_at(address_of(octets), len(octets))
    found = numbers_at(address_of(numbers), len(numbers))
    more = longs_at(address_of(longs), len(longs))
    for place in range(len(found)):
        first[place] *= 2
        found[place] *= 2
        more[place] *= 2
    return map_at(address_of(read_only), len(read_only))[1]


def test_an_array_is_found_by_its_address():
    octets, numbers, longs = (np.arange(3).astype(kind) for kind in (np.uint8, np.uint32, np.int64))
    read_only = np.array([7, 9, 11], np.uint8)
    read_only.flags.writeable = False
    assert doubled(octets, read_only, numbers, longs) == 9
    for array in (octets, numbers, longs):
        assert array.tolist() == [0, 2, 4]
