"""Fixtures that all tests share, and how several processes share the tests."""

import asyncio
import gc
import os
import tempfile
from collections.abc import Callable, Generator, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import uvloop
from hypothesis import settings

from engine.runtimes.fork_server import early_start
from ppaas import plugins
from ppaas.kernel_cache.target import export_target
from tests.ci import whole_files
from tests.ci.shares import place_in_line
from tests.support.budget import EXAMPLES

export_target()  # a test may compile something before it imports our kernels, which decides for all of them

pytest_plugins = ["tests.servers.fixtures"]

# A property holds however long it takes: benches measure times, and a busy machine must not fail a test.
settings.register_profile("ppaas", deadline=None, max_examples=EXAMPLES)
settings.load_profile("ppaas")

GARBAGE = 20_000, 20, 20
"""Thresholds of the searches for garbage in tests (`gc.set_threshold`): a process of many has millions of objects."""

ROOT = Path(__file__).resolve().parent.parent


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect tests without searches for garbage: modules and tests are millions of objects that live to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()  # later searches do not visit them either
        gc.set_threshold(*GARBAGE)
        gc.enable()


def pytest_configure(config: pytest.Config) -> None:
    """Let a process of several collect the tests of a file when it runs them."""
    if whole_files.is_wanted(config):
        config.pluginmanager.register(whole_files)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> Generator[None, None, None]:
    """Put the longest shares first."""
    yield
    places = {path: place_in_line(path.relative_to(ROOT)) for path in {item.path for item in items}}
    items.sort(key=lambda item: places[item.path])


LOOPS: Mapping[str, Callable[[], asyncio.AbstractEventLoop]] = {
    "uvloop": uvloop.new_event_loop,
    "asyncio": asyncio.new_event_loop,
}
"""Event loops of tests. A timer, a transport or a handle of one is not that of the other."""

LOOPS_OF: Mapping[str, tuple[str, ...]] = {
    "unit/endpoints/http/test_tls_handshake.py": ("uvloop", "asyncio"),
    "unit/endpoints": ("uvloop",),
    "unit/engine/links": ("uvloop", "asyncio"),
    "unit/engine/recorder": ("asyncio",),
    "unit/engine/links/test_place_link.py": ("uvloop", "asyncio"),
    "unit/engine/sessions": ("uvloop", "asyncio"),
    "unit/engine": ("uvloop",),
    "unit/robots/bridges/vda5050": ("uvloop", "asyncio"),
}
"""Loops of the tests below ``tests/`` by file or folder, the longest first: those that the processes of the code run
on. All other tests run on that of asyncio."""


def pytest_asyncio_loop_factories(
    config: pytest.Config, item: pytest.Item
) -> Mapping[str, Callable[[], asyncio.AbstractEventLoop]]:
    """Return the event loops that a test runs on."""
    path = item.path.relative_to(ROOT / "tests").as_posix()
    names = next((loops for place, loops in LOOPS_OF.items() if path.startswith(place)), ("asyncio",))
    return {name: LOOPS[name] for name in names}


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Return what hands the shares to the processes."""
    from tests.ci.share_scheduling import ShareScheduling

    return ShareScheduling(config, log)


@pytest.fixture(scope="session")
def data() -> Path:
    """Return the folder of real maps and logs, or skip: the project does not ship them."""
    folder = Path(os.environ.get("PPAAS_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("no real data: set PPAAS_DATA")
    return folder


@pytest.fixture(autouse=True)
def _permits(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no test permit plug-ins for those after it."""
    monkeypatch.setattr(plugins, "_permitted", plugins._permitted)


@pytest.fixture(scope="module", autouse=True)
def _own_fork_server() -> Iterator[None]:
    """End the fork server of a module's tests: the next may want one that has imported other modules."""
    yield
    early_start.end()


@pytest.fixture
def short_path(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder for temporary files with a path short enough for Unix sockets, which ``tmp_path`` may not be."""
    with tempfile.TemporaryDirectory(prefix="t-") as name:
        monkeypatch.setattr(tempfile, "tempdir", name)
        yield Path(name)
