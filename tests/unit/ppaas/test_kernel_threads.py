import numba
import pytest

from ppaas import kernel_threads
from ppaas.planners.field.kernels import descent, propagation, setup


def test_number_of_threads_is_limited_and_restored():
    before = numba.get_num_threads()
    with kernel_threads.limit_threads(2) as usable:
        assert usable <= 2
        assert numba.get_num_threads() == min(2, numba.config.NUMBA_NUM_THREADS)
    assert numba.get_num_threads() == before


def test_number_of_threads_is_restored_after_an_error():
    before = numba.get_num_threads()
    with pytest.raises(KeyError), kernel_threads.limit_threads(2):
        raise KeyError
    assert numba.get_num_threads() == before


def test_more_threads_than_cores_are_not_an_error():
    with kernel_threads.limit_threads(10_000) as usable:
        assert usable <= numba.config.NUMBA_NUM_THREADS


def test_kernels_run_serially_without_a_threading_layer(monkeypatch):
    def missing():
        raise ValueError("No threading layer could be loaded.")

    monkeypatch.setattr(numba, "get_num_threads", missing)
    with kernel_threads.limit_threads(2) as usable:
        assert usable == 1


def test_threading_layer_that_is_not_thread_safe_is_not_used(monkeypatch):
    monkeypatch.setattr(numba, "threading_layer", lambda: "workqueue")
    with kernel_threads.limit_threads(2) as usable:
        assert usable == 1


def test_warm_compiles_each_kernel():
    for module in (setup, propagation, descent):
        module.warm()
    compiled = [propagation.propagate, propagation.seed, descent.descend]
    assert all(len(kernel.signatures) >= 2 for kernel in compiled)
