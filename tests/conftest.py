"""Fixtures that all tests share, and how several processes share the tests."""

import gc
import os
import tempfile
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from ppaas import plugins
from tests.ci.shares import place_in_line

pytest_plugins = ["tests.servers.fixtures"]

# A property holds however long it takes: benches measure times, and a busy machine must not fail a test. Each run tries
# other examples, so many short runs try more than a long one; ``make properties`` tries a thousand of each.
EXAMPLES = int(os.environ.get("PPAAS_PROPERTY_EXAMPLES", "30"))
settings.register_profile("ppaas", deadline=None, max_examples=EXAMPLES)
settings.load_profile("ppaas")

ROOT = Path(__file__).resolve().parent.parent


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect tests without searches for garbage: modules and tests are millions of objects that live to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()  # later searches do not visit them either
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest shares first."""
    places = {path: place_in_line(path.relative_to(ROOT)) for path in {item.path for item in items}}
    items.sort(key=lambda item: places[item.path])


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


@pytest.fixture
def short_path(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder for temporary files with a path short enough for Unix sockets, which ``tmp_path`` may not be."""
    with tempfile.TemporaryDirectory(prefix="t-") as name:
        monkeypatch.setattr(tempfile, "tempdir", name)
        yield Path(name)
