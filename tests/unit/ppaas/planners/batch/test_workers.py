import threading

import pytest

from ppaas.errors import InvalidInput
from ppaas.planners.batch.workers import run_jobs
from ppaas.planners.watch import proceed


def ignore(job):
    """Do nothing when a job is done."""


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_results_are_in_the_order_of_the_jobs(threads):
    done_jobs = []
    workers = [lambda job, check: job * job] * threads
    assert run_jobs(workers, range(40), check=proceed, done=done_jobs.append) == [n * n for n in range(40)]
    assert sorted(done_jobs) == list(range(40))


def test_two_workers_run_at_once_and_neither_runs_two_jobs_at_once():
    both = threading.Barrier(2, timeout=30)
    busy = {0: 0, 1: 0}

    def worker(number):
        def work(job, check):
            busy[number] += 1
            assert busy[number] == 1
            both.wait()
            busy[number] -= 1

        return work

    run_jobs([worker(0), worker(1)], range(6), check=proceed, done=ignore)


def test_done_is_called_in_the_callers_thread():
    done_jobs = []
    run_jobs(
        [lambda job, check: None] * 3, "abc", check=proceed, done=lambda job: done_jobs.append(threading.get_ident())
    )
    assert set(done_jobs) == {threading.get_ident()}


@pytest.mark.parametrize("threads", [1, 3])
def test_first_error_ends_all_jobs(threads):
    started = []

    def work(job, check):
        started.append(job)
        if job == 2:
            raise InvalidInput("no")
        while threads > 1:
            check()

    with pytest.raises(InvalidInput, match="no"):
        run_jobs([work] * threads, range(100), check=proceed, done=ignore)
    assert len(started) < 100


def test_an_error_of_the_check_ends_all_jobs():
    def stop():
        raise InvalidInput("enough")

    def work(job, check):
        check()

    with pytest.raises(InvalidInput, match="enough"):
        run_jobs([work, work], range(10), check=stop, done=ignore)


def test_no_jobs_give_no_results():
    assert run_jobs([ignore], [], check=proceed, done=ignore) == []
