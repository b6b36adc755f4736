import os
import threading

import numpy as np
import pytest

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.field.kernels import tile_help
from ppaas.planners.field.kernels.tile_help import BOX, FIELD_RECORD, HEARS, NOBODY, OVER, RINGS, THREAD, WORD, WRITTEN
from ppaas.planners.field.kernels.tile_record import RECORD, SCRATCH_MEMORY, STATE, store_array
from ppaas.planners.field.kernels.tile_rows import SCRATCH
from ppaas.planners.field.kernels.tile_state import APART, CALLED, STOP, THREADS, state_size
from ppaas.planners.kernels.addresses import bytes_of, int64s_of, readonly_bytes_of, uint32s_of


@pytest.fixture
def boxes():
    """Two mailboxes without helper threads."""
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
        store_array(self.record, STATE, self.state)

    def call(self, boxes):
        return tile_help.call_one(boxes, self.record)

    def called(self):
        return np.flatnonzero(self.state[THREADS + CALLED :: APART]).tolist()


def test_each_called_helper_gets_the_record_and_its_thread_number(boxes):
    field = Field(3)
    assert field.call(boxes)
    assert field.call(boxes)
    assert boxes[:, THREAD].tolist() == field.called() == [1, 2]
    assert boxes[:, FIELD_RECORD].tolist() == [field.record.ctypes.data] * 2
    assert [os.read(box[HEARS], 9) for box in boxes] == [b"\1", b"\1"]


def test_no_more_helpers_are_called_than_the_field_allows_or_exist(boxes):
    small, large = Field(2), Field(9)
    assert [small.call(boxes), small.call(boxes)] == [True, False]
    assert [large.call(boxes), large.call(boxes)] == [True, False]
    assert not large.call(boxes[:0])


def test_a_called_helper_accepts_once(boxes):
    field = Field(2)
    field.call(boxes)
    assert tile_help.wait_for_call(boxes[0])
    boxes[0, OVER] = 1
    assert not tile_help.wait_for_call(boxes[0])
    tile_help.finish(boxes[0])
    assert boxes[0, WORD] == NOBODY


def test_a_helper_released_before_it_arrives_never_accepts(boxes):
    field, other = Field(3), Field(2)
    field.call(boxes)
    tile_help.release_helpers(boxes, field.record)
    assert field.state[STOP]
    assert field.called() == []
    assert boxes[0, WORD] == NOBODY
    assert other.call(boxes)
    assert tile_help.wait_for_call(boxes[0])
    assert boxes[0, FIELD_RECORD] == other.record.ctypes.data


def test_a_helper_that_has_arrived_leaves_by_itself_when_released(boxes):
    field = Field(2)
    field.call(boxes)
    tile_help.wait_for_call(boxes[0])
    tile_help.release_helpers(boxes, field.record)
    assert field.called() == [1]
    assert boxes[0, WORD] not in (NOBODY, WRITTEN)


def test_helpers_of_other_fields_are_not_released(boxes):
    field, other = Field(2), Field(2)
    field.call(boxes)
    other.call(boxes)
    tile_help.release_helpers(boxes, other.record)
    assert field.called() == [1]
    assert other.called() == []
    assert tile_help.wait_for_call(boxes[0])


def test_a_sleeping_helper_accepts_a_call_but_not_a_stray_byte(boxes):
    came = threading.Event()
    sleeper = threading.Thread(target=lambda: (tile_help.wait_for_call(boxes[0]), came.set()))
    sleeper.start()
    os.write(boxes[0, RINGS], b"!")
    assert not came.wait(0.05)
    Field(2).call(boxes[:1])
    assert came.wait(30)
    sleeper.join()


@bare
def doubled(record):
    """Double all items of three arrays that are given by their addresses."""
    octets, numbers, longs = bytes_of(record, 0), uint32s_of(record, 2), int64s_of(record, 4)
    for place in range(len(numbers)):
        octets[place] *= 2
        numbers[place] *= 2
        longs[place] *= 2
    return readonly_bytes_of(record, 6)[1] + len(octets)


def test_an_array_is_found_by_its_address():
    octets, numbers, longs = (np.arange(3).astype(kind) for kind in (np.uint8, np.uint32, np.int64))
    read_only, record = np.array([7, 9, 11], np.uint8), np.zeros(8, np.int64)
    for place, array in enumerate((octets, numbers, longs, read_only)):
        store_array(record, 2 * place, array)
    assert doubled(record) == 12
    for array in (octets, numbers, longs):
        assert array.tolist() == [0, 2, 4]
