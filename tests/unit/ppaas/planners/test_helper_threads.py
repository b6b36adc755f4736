import os
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import PlanCancelled
from ppaas.planners import helper_threads
from ppaas.planners.helper_threads import HelperThreads, share
from ppaas.planners.watch import proceed

CPUS = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()
with_two_cpus = pytest.mark.skipif(len(CPUS) < 2, reason="one CPU: no other to run on")


@pytest.fixture
def asleep():
    """Yield helper threads with one sleeping thread, its executor, and its native id."""
    threads = HelperThreads()
    with ThreadPoolExecutor(1, initializer=threads.register) as executor:
        yield threads, executor, executor.submit(threading.get_native_id).result()


@with_two_cpus
def test_a_helper_does_not_run_on_the_callers_cpu(asleep):
    threads, executor, helper = asleep
    threads.move_off_this_cpu()
    allowed = executor.submit(lambda: os.sched_getaffinity(0)).result()
    assert allowed == os.sched_getaffinity(helper)
    assert allowed < CPUS
    assert len(CPUS - allowed) == 1


@with_two_cpus
def test_a_helper_follows_a_change_of_the_callers_affinity(asleep):
    placed, executor, _ = asleep
    found = []

    def call():
        for cpus in ({min(CPUS)}, {max(CPUS)}, CPUS):
            os.sched_setaffinity(0, cpus)  # of this thread only
            placed.move_off_this_cpu()
            found.append(executor.submit(lambda: os.sched_getaffinity(0)).result())

    caller = threading.Thread(target=call)
    caller.start()
    caller.join()
    assert found[:2] == [{min(CPUS)}, {max(CPUS)}], "there is no other CPU"
    assert len(CPUS - found[2]) == 1


def test_an_unchanged_affinity_is_not_set_again(asleep, monkeypatch):
    threads, _, helper = asleep
    calls, here = [], 0
    monkeypatch.setattr(helper_threads, "_sched_getcpu", lambda: lambda: here)
    monkeypatch.setattr(os, "sched_getaffinity", lambda thread: {0, 1, 2})
    monkeypatch.setattr(os, "sched_setaffinity", lambda thread, cpus: calls.append((thread, cpus)))
    for here in (0, 0, 2, 2, 0):  # noqa: B007 - looked at by the function above
        threads.move_off_this_cpu()
    assert calls == [(helper, {1, 2}), (helper, {0, 1}), (helper, {1, 2})]


def test_helpers_work_where_the_affinity_cannot_be_set(asleep, monkeypatch):
    threads, executor, _ = asleep

    def refuse(thread, cpus):
        raise PermissionError("not in here")

    monkeypatch.setattr(os, "sched_setaffinity", refuse)
    threads.move_off_this_cpu()
    assert executor.submit(lambda: 7).result() == 7


def test_helpers_work_without_sched_getcpu(asleep, monkeypatch):
    threads, executor, _ = asleep
    monkeypatch.setattr(helper_threads, "_sched_getcpu", lambda: None)
    monkeypatch.delattr(os, "sched_setaffinity", raising=False)
    threads.move_off_this_cpu()
    assert executor.submit(lambda: 7).result() == 7


@pytest.mark.parametrize("helpers", [-1, 0, 2])
def test_each_slice_is_processed_once(helpers):
    done = []
    share(range(200), done.append, helpers=helpers, check=proceed)
    assert sorted(done) == list(range(200))


def test_a_helper_works_beside_the_caller():
    both = threading.Barrier(2, timeout=30)
    share(range(2), lambda one: both.wait(), helpers=1, check=proceed)


def test_the_check_ends_the_work_on_slices():
    done = []

    def check():
        if done:
            raise PlanCancelled("enough")

    with pytest.raises(PlanCancelled):
        share(range(200), done.append, helpers=0, check=check)
    assert done == [0]


def test_an_error_in_a_helper_is_raised():
    started, failed = threading.Event(), threading.Event()

    def work(one):
        if threading.current_thread() is threading.main_thread():
            started.set()
            assert failed.wait(30)
        else:
            assert started.wait(30)
            failed.set()
            raise OSError("broken")

    with pytest.raises(OSError, match="broken"):
        share(range(2), work, helpers=1, check=proceed)


def test_helper_that_has_not_started_is_not_waited_for():
    release, others = threading.Event(), ThreadPoolExecutor(1)
    busy = others.submit(
        share, range(os.cpu_count() + 1), lambda one: release.wait(), helpers=os.cpu_count(), check=proceed
    )
    done = []
    share(range(3), done.append, helpers=2, check=proceed)
    release.set()
    busy.result()
    assert sorted(done) == [0, 1, 2]


def test_a_forked_process_gets_its_own_threads():
    both = threading.Barrier(2, timeout=30)
    share(range(2), lambda one: both.wait(), helpers=1, check=proceed)
    child = os.fork()
    if not child:
        together = threading.Barrier(2, timeout=10)
        share(range(2), lambda one: together.wait(), helpers=1, check=proceed)
        os._exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
