import threading

import pytest

from ppaas.errors import InvalidInput
from ppaas.planners.batch.workers import work_off
from ppaas.planners.watch import proceed


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
