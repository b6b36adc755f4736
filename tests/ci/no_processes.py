"""Plug-in of ``make unit``: a test that starts a process fails.

Its file belongs in ``tests/ci/not_unit``, the list of the files that ``make unit`` leaves out.
"""

import asyncio
import sys
from collections.abc import Callable, Generator
from typing import Any

import pytest

EVENTS = ("subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.system")
"""Audit events of Python when a process starts; uvloop raises none, so the functions below are replaced."""

_started: list[str] = []


def pytest_configure() -> None:
    """Note from now on which processes start."""
    sys.addaudithook(_note_event)
    for name in ("create_subprocess_exec", "create_subprocess_shell"):
        setattr(asyncio, name, _noting(getattr(asyncio, name)))


def _note_event(event: str, arguments: tuple[Any, ...]) -> None:
    if event in EVENTS and arguments[:1] != ("uname",):  # the module platform asks it once a process
        _started.append(f"{event} {arguments[:1]}")


def _noting(start: Callable[..., Any]) -> Callable[..., Any]:
    def start_noted(*arguments: Any, **options: Any) -> Any:
        _started.append(f"{start.__name__} {arguments[:1]}")
        return start(*arguments, **options)

    return start_noted


def _check() -> None:
    started, _started[:] = [*_started], []
    if started:
        pytest.fail(f"starts a process ({started[0]}): add the file to tests/ci/not_unit", pytrace=False)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup() -> Generator[None, None, None]:
    """Check the fixtures of a test."""
    yield
    _check()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, None, None]:
    """Check a test."""
    yield
    _check()
