import asyncio
import os

import pytest

from tests.support import waiting


@pytest.fixture
def load(monkeypatch):
    """Return a function that sets how many processes per core want to run, on a computer as fast as the reference."""
    monkeypatch.setattr(waiting, "slowness", lambda: 1.0)
    cores = len(os.sched_getaffinity(0))
    return lambda of_a_core: monkeypatch.setattr(os, "getloadavg", lambda: (of_a_core * cores, 0.0, 0.0))


@pytest.mark.parametrize(("of_a_core", "expected"), [(0.0, 1.0), (0.9, 1.0), (3.0, 3.0), (100.0, waiting.LONGEST)])
def test_limits_grow_with_the_processes_that_want_to_run(load, of_a_core, expected):
    load(of_a_core)
    assert waiting.stretch() == pytest.approx(expected)


def test_a_slow_computer_gets_longer_and_a_fast_one_not_less(load, monkeypatch):
    load(0.0)
    monkeypatch.setattr(waiting, "slowness", lambda: 2.5)
    assert waiting.stretch() == pytest.approx(2.5)
    monkeypatch.setattr(waiting, "slowness", lambda: 0.2)
    assert waiting.stretch() == 1.0


async def test_a_wait_is_as_long_as_the_load_of_its_end_allows(load):
    load(4.0)
    changed = asyncio.get_running_loop().time() + 0.1
    await waiting.until(lambda: asyncio.get_running_loop().time() > changed, 0.05)
    load(1.0)
    with pytest.raises(TimeoutError):
        await waiting.until(lambda: False, 0.01)
    with pytest.raises(TimeoutError):
        async with waiting.patience(0.01):
            await asyncio.sleep(10.0)
