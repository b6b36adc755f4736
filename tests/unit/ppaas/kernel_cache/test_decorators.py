"""Kernels have no versions and wrappers that nobody uses."""

import os
import subprocess
import sys
from typing import Any

import numpy as np

from ppaas.kernel_cache.decorators import compiled


@compiled(cache=False)
def scaled(number: int, by: int) -> int:
    return number * by


@compiled(cache=False)
def twice_and_thrice(number: int) -> int:
    return scaled(number, 2) + scaled(number, by=3)


@compiled(cache=False, _nrt=False, forceinline=True)
def least(numbers: Any, first: int) -> Any:
    found = numbers[first]
    for number in numbers[first:]:
        found = min(found, number)
    return found


@compiled(cache=False)
def least_of_all(numbers: Any) -> Any:
    return min(least(numbers, 0), least(numbers, 1))


def test_constants_do_not_make_versions() -> None:
    assert twice_and_thrice(5) == 25
    assert len(scaled.signatures) == 1  # type: ignore[attr-defined]
    assert least_of_all(np.array([3, 1, 2])) == 1
    assert len(least.signatures) == 1


def test_types_do_make_versions() -> None:
    assert least_of_all(np.array([0.5, 0.25])) == 0.25
    assert {str(array.dtype) for array, _ in least.signatures} >= {"float64"}


def test_kernels_have_no_wrapper_for_c() -> None:
    twice_and_thrice(1)
    for kernel in (scaled, twice_and_thrice):
        (version,) = kernel.overloads.values()  # type: ignore[attr-defined]
        assert not [name for name in version.library.get_defined_functions() if name.name.startswith("cfunc.")]


def test_kernels_may_be_plain_functions() -> None:
    """Files of robots are checked in a process that compiles nothing."""
    of_plain = "from ppaas.kernel_cache.decorators import compiled; print(compiled(lambda: 5)())"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    assert subprocess.check_output([sys.executable, "-c", of_plain], env=environment) == b"5\n"
