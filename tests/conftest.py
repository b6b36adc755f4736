"""Fixtures that all tests share, and how several processes share the tests."""

import os
from pathlib import Path

import pytest

from tests.support.shares import place_in_line, share_of

ROOT = Path(__file__).resolve().parent.parent


@pytest.hookimpl(trylast=True)
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
