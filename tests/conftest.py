"""Fixtures that all tests share, and how several processes share the tests."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.shares import place_in_line, share_of

ROOT = Path(__file__).resolve().parent.parent


@pytest.hookimpl(tryfirst=True)  # pytest-xdist reads the marks in the same hook
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put each test into its share, and the longest shares first."""
    for item in items:
        item.add_marker(pytest.mark.xdist_group(share_of(item.path.relative_to(ROOT))))
    items.sort(key=lambda item: place_in_line(item.path.relative_to(ROOT)))


@pytest.fixture(scope="session")
def data() -> Path:
    """Return the folder of real maps and logs, or skip: the project does not ship them."""
    folder = Path(os.environ.get("PPAAS_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("no real data: set PPAAS_DATA")
    return folder


@pytest.fixture
def short_path(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder for temporary files with a path short enough for Unix sockets, which ``tmp_path`` may not be."""
    with tempfile.TemporaryDirectory(prefix="t-") as name:
        monkeypatch.setattr(tempfile, "tempdir", name)
        yield Path(name)
