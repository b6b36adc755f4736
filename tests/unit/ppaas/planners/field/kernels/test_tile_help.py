import os
import threading

import numpy as np
import pytest

from ppaas.planners.field.kernels import tile_help
from ppaas.planners.field.kernels.tile_help import BOX, FIELD_RECORD, HEARS, NOBODY, OVER, RINGS, THREAD, WORD, WRITTEN
from ppaas.planners.field.kernels.tile_record import RECORD, SCRATCH_MEMORY, STATE, note
from ppaas.planners.field.kernels.tile_rows import SCRATCH
from ppaas.planners.field.kernels.tile_state import APART, CALLED, STOP, THREADS, state_size
from ppaas.planners.kernels.addresses import longs_of, map_of, numbers_of, octets_of
from ppaas.planners.kernels.jit_decorators import bare


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
        self.record = np.zeros(RECORD, np.int64)
        self.record[SCRATCH_MEMORY + 1] = threads * SCRATCH
        note(self.record, STATE, self.state)

    def call(self, boxes):
        return tile_help.call_one(boxes, self.record)

    def called(self):
        return np.flatnonzero(self.state[THREADS + CALLED :: APART]).tolist()


def test_each_who_is_called_is_told_of_the_field_and_of_its_number(boxes):
    field = Field(3)
    assert field.call(boxes)
    assert field.call(boxes)
    assert boxes[:, THREAD].tolist() == field.called() == [1, 2]
    assert boxes[:, FIELD_RECORD].tolist() == [field.record.ctypes.data] * 2
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
    tile_help.send_away(boxes, field.record)
    assert field.state[STOP]
    assert field.called() == []
    assert boxes[0, WORD] == NOBODY
    assert other.call(boxes)
    assert tile_help.comes(boxes[0])
    assert boxes[0, FIELD_RECORD] == other.record.ctypes.data


def test_who_has_come_leaves_by_itself_when_sent_away(boxes):
    field = Field(2)
    field.call(boxes)
    tile_help.comes(boxes[0])
    tile_help.send_away(boxes, field.record)
    assert field.called() == [1]
    assert boxes[0, WORD] not in (NOBODY, WRITTEN)


def test_helpers_of_others_are_not_sent_away(boxes):
    field, other = Field(2), Field(2)
    field.call(boxes)
    other.call(boxes)
    tile_help.send_away(boxes, other.record)
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
def doubled(record):
    """Double what lies where arrays do of which one knows the addresses alone."""
    octets, numbers, longs = octets_of(record, 0), numbers_of(record, 2), longs_of(record, 4)
    for place in range(len(numbers)):
        octets[place] *= 2
        numbers[place] *= 2
        longs[place] *= 2
    return map_of(record, 6)[1] + len(octets)


def test_an_array_is_found_by_its_address():
    octets, numbers, longs = (np.arange(3).astype(kind) for kind in (np.uint8, np.uint32, np.int64))
    read_only, record = np.array([7, 9, 11], np.uint8), np.zeros(8, np.int64)
    for place, array in enumerate((octets, numbers, longs, read_only)):
        note(record, 2 * place, array)
    assert doubled(record) == 12
    for array in (octets, numbers, longs):
        assert array.tolist() == [0, 2, 4]
