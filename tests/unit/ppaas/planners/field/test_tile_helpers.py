import os
import subprocess
import sys
import threading

import numpy as np
import pytest

from ppaas.planners.field.kernels.tile_help import BOX, RINGS, WORD
from ppaas.planners.field.tile_field import TileField
from ppaas.planners.field.tile_helpers import FieldHelpers, boxes_for
from tests.support.sources import ROOT
from tests.support.world import grids

A_FIELD = """
import numpy as np
from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import GridInfo
from ppaas.planners.field.tile_field import TileField
field = TileField(Costmap(np.zeros((600, 600), np.uint8), GridInfo(0.05, 600, 600)), np.array([(0, 0)]), threads=2)
field.grow()
"""


@pytest.fixture
def helpers():
    found = FieldHelpers()
    yield found
    found.close()


def alive():
    return [thread for thread in threading.enumerate() if thread.name == "field"]


def test_threads_are_started_on_demand_up_to_the_number_of_cpus(helpers):
    before = len(alive())
    assert helpers.boxes(0).shape == helpers.boxes(-1).shape == (0, BOX)
    assert len(alive()) == before
    assert len(helpers.boxes(1)) == 1
    assert len(helpers.boxes(1)) == 1
    assert len(alive()) == before + 1
    assert len(helpers.boxes(1_000)) == os.cpu_count()
    assert len(alive()) == before + os.cpu_count()


def test_concurrent_callers_get_the_same_helpers(helpers):
    before, ready = len(alive()), threading.Barrier(8)

    def need():
        ready.wait()
        helpers.boxes(1)

    callers = [threading.Thread(target=need) for _ in range(8)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert len(alive()) == before + 1


def test_closing_ends_all_threads(helpers):
    before = len(alive())
    helpers.boxes(2)
    helpers.close()
    assert len(alive()) == before
    helpers.close()


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one CPU: no other to run on")
def test_helpers_are_moved_off_the_callers_cpu(helpers):
    helpers.boxes(1)
    (helper,) = set(alive()) & set(helpers._threads)
    assert len(os.sched_getaffinity(0) - os.sched_getaffinity(helper.native_id)) == 1


def test_a_stray_byte_leaves_an_uncalled_helper_asleep(helpers):
    (box,) = helpers.boxes(1)
    for _ in range(100_000):  # more than a pipe can hold
        try:
            os.write(int(box[RINGS]), b"!")
        except BlockingIOError:
            break
    assert box[WORD] == 0
    assert alive()


def grown():
    field = TileField(grids.of(np.zeros((600, 600), np.uint8)), np.array([(0, 0)]), threads=2)
    field.grow()
    return field.values()


def test_a_forked_process_has_its_own_helpers():
    expected = grown()
    child = os.fork()
    if not child:
        same = np.array_equal(grown(), expected)
        os._exit(7 if same and len(boxes_for(2)) == 1 and len(alive()) == 1 else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
    assert np.array_equal(grown(), expected)


@pytest.mark.parametrize(
    "ending", ["", "raise SystemExit(0)", "import os, signal; os.kill(os.getpid(), signal.SIGTERM)"]
)
def test_a_process_with_helpers_exits_normally(ending):
    command = (sys.executable, "-c", A_FIELD + ending)
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == (-15 if "SIGTERM" in ending else 0)
    assert not done.stderr


def test_a_helper_does_not_need_the_interpreter_lock():
    """A Python thread in an endless loop blocks neither the caller's nor its helper's kernel."""
    expected, over = grown(), threading.Event()

    def compute():
        while not over.is_set():
            sum(range(1_000))

    busy = threading.Thread(target=compute)
    busy.start()
    try:
        assert all(np.array_equal(grown(), expected) for _ in range(5))
    finally:
        over.set()
        busy.join()
