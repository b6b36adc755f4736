import os
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import InvalidInput, PlanCancelled
from ppaas.planners.watch import proceed
from ppaas.planners.workers import share, work_off


def ignore(job):
    """Be told of a job."""


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_what_came_of_the_jobs_is_in_their_order(threads):
    told = []
    workers = [lambda job, check: job * job] * threads
    assert work_off(workers, range(40), check=proceed, done=told.append) == [n * n for n in range(40)]
    assert sorted(told) == list(range(40))


def test_two_workers_are_at_work_at_a_time_and_neither_twice():
    both = threading.Barrier(2, timeout=30)
    busy = {0: 0, 1: 0}

    def worker(number):
        def work(job, check):
            busy[number] += 1
            assert busy[number] == 1
            both.wait()
            busy[number] -= 1

        return work

    work_off([worker(0), worker(1)], range(6), check=proceed, done=ignore)


def test_they_are_told_of_in_the_thread_of_the_caller():
    told = []
    work_off([lambda job, check: None] * 3, "abc", check=proceed, done=lambda job: told.append(threading.get_ident()))
    assert set(told) == {threading.get_ident()}


@pytest.mark.parametrize("threads", [1, 3])
def test_the_first_error_ends_all(threads):
    begun = []

    def work(job, check):
        begun.append(job)
        if job == 2:
            raise InvalidInput("no")
        while threads > 1:
            check()

    with pytest.raises(InvalidInput, match="no"):
        work_off([work] * threads, range(100), check=proceed, done=ignore)
    assert len(begun) < 100


def test_what_the_check_raises_ends_all():
    def stop():
        raise InvalidInput("enough")

    def work(job, check):
        check()

    with pytest.raises(InvalidInput, match="enough"):
        work_off([work, work], range(10), check=stop, done=ignore)


def test_no_job_is_no_work():
    assert work_off([ignore], [], check=proceed, done=ignore) == []


@pytest.mark.parametrize("helpers", [-1, 0, 2])
def test_each_slice_is_done_once_by_whoever_comes_first(helpers):
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


def test_what_goes_wrong_with_a_helper_is_told():
    begun, failed = threading.Event(), threading.Event()

    def work(one):
        if threading.current_thread() is threading.main_thread():
            begun.set()
            assert failed.wait(30)
        else:
            assert begun.wait(30)
            failed.set()
            raise OSError("broken")

    with pytest.raises(OSError, match="broken"):
        share(range(2), work, helpers=1, check=proceed)


def test_who_has_not_begun_when_all_is_done_is_not_waited_for():
    gate, others = threading.Event(), ThreadPoolExecutor(1)
    busy = others.submit(
        share, range(os.cpu_count() + 1), lambda one: gate.wait(), helpers=os.cpu_count(), check=proceed
    )
    done = []
    share(range(3), done.append, helpers=2, check=proceed)
    gate.set()
    busy.result()
    assert sorted(done) == [0, 1, 2]


def test_a_process_that_is_forked_gets_threads_of_its_own():
    both = threading.Barrier(2, timeout=30)
    share(range(2), lambda one: both.wait(), helpers=1, check=proceed)
    child = os.fork()
    if not child:
        together = threading.Barrier(2, timeout=10)
        share(range(2), lambda one: together.wait(), helpers=1, check=proceed)
        os._exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
