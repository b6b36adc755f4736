import os
import threading

import pytest

from ppaas.planners.workers import Helpers


def test_helpers_work_at_a_time_and_are_waited_for():
    together, done = threading.Barrier(2, timeout=10), []

    def work():
        together.wait()
        done.append(threading.get_ident())

    helpers = Helpers()
    helpers.call(work)
    together.wait()
    helpers.wait()
    assert done != [threading.get_ident()]
    assert len(done) == 1


def test_who_rests_goes_on_when_a_helper_has_left_or_a_moment_has_passed():
    gate, helpers = threading.Event(), Helpers()
    helpers.call(gate.wait)
    helpers.rest()
    gate.set()
    helpers.wait()
    helpers.rest()


def test_who_has_not_begun_when_all_are_sent_away_never_does():
    gate, helpers, begun = threading.Event(), Helpers(), []
    for _ in range(os.cpu_count() + 3):
        helpers.call(lambda: (begun.append(1), gate.wait()))
    helpers.send_away()
    gate.set()
    helpers.wait()
    assert len(begun) <= os.cpu_count()


def test_what_goes_wrong_with_a_helper_is_told():
    def fail():
        raise OSError("broken")

    helpers = Helpers()
    helpers.call(fail)
    with pytest.raises(OSError, match="broken"):
        helpers.wait()


def test_a_process_that_is_forked_gets_threads_of_its_own():
    helpers = Helpers()
    helpers.call(lambda: None)
    helpers.wait()
    child = os.fork()
    if not child:
        again = Helpers()
        again.call(lambda: os._exit(7))
        again.wait()
        os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
