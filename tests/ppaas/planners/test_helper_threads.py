import os
import threading

import pytest

from ppaas.planners import helper_threads
from ppaas.planners.helper_threads import HelperThreads

CPUS = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()


@pytest.fixture
def asleep():
    """Threads of which one has worked and sleeps, and its number."""
    threads = HelperThreads()
    return threads, threads.submit(threading.get_native_id).result()


@pytest.mark.skipif(len(CPUS) < 2, reason="one CPU: no other to run on")
def test_a_helper_is_not_woken_where_the_caller_runs_and_goes_anywhere_when_it_works(asleep):
    threads, helper = asleep
    threads.keep_off()
    assert len(CPUS - os.sched_getaffinity(helper)) == 1
    assert threads.submit(lambda: os.sched_getaffinity(0)).result() == CPUS


@pytest.mark.skipif(len(CPUS) < 2, reason="one CPU: no other to run on")
def test_a_helper_keeps_to_the_cpus_that_the_caller_is_given_meanwhile(asleep):
    threads, _ = asleep
    found = []

    def call():
        threads.keep_off()
        os.sched_setaffinity(0, {min(CPUS)})  # of this thread alone
        found.append(threads.submit(lambda: os.sched_getaffinity(0)).result())

    caller = threading.Thread(target=call)
    caller.start()
    caller.join()
    assert found == [{min(CPUS)}]


def test_a_caller_with_one_cpu_has_its_helpers_there(asleep, monkeypatch):
    threads, _ = asleep
    monkeypatch.setattr(helper_threads, "_sched_getcpu", lambda: lambda: 3)
    monkeypatch.setattr(os, "sched_getaffinity", lambda thread: {3})
    monkeypatch.setattr(os, "sched_setaffinity", lambda thread, cpus: pytest.fail("there is no other"))
    threads.keep_off()


def test_where_cpus_cannot_be_chosen_helpers_work_all_the_same(asleep, monkeypatch):
    threads, _ = asleep

    def refuse(thread, cpus):
        raise PermissionError("not in here")

    monkeypatch.setattr(os, "sched_setaffinity", refuse)
    threads.keep_off()
    assert threads.submit(lambda: 7).result() == 7


def test_nor_are_cpus_needed_that_can_be_told_apart(asleep, monkeypatch):
    threads, _ = asleep
    monkeypatch.setattr(helper_threads, "_sched_getcpu", lambda: None)
    monkeypatch.delattr(os, "sched_setaffinity", raising=False)
    threads.keep_off()
    assert threads.submit(lambda: 7).result() == 7
