"""Place links whose containers and clients the tests play."""

from collections.abc import AsyncIterator

import pytest

from tests.support.engine.place_peers import close_links


@pytest.fixture(autouse=True)
async def links() -> AsyncIterator[None]:
    """Close the links that a test left open."""
    yield
    await close_links()
