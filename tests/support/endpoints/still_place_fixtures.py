"""Fixtures for tests of rosbridge: a place without sockets, and two clients at it."""

from collections.abc import AsyncIterator

import pytest

from tests.support.endpoints.still_place import StillClient, StillPlace


@pytest.fixture
async def place() -> StillPlace:
    return StillPlace()


@pytest.fixture
async def client(place: StillPlace) -> AsyncIterator[StillClient]:
    made = StillClient(place)
    yield made
    made.session.end()


@pytest.fixture
async def other(place: StillPlace) -> AsyncIterator[StillClient]:
    made = StillClient(place, "operator")
    yield made
    made.session.end()
