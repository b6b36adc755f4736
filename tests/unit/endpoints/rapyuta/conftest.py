"""Robots of 2013 at a still place."""

import pytest

from endpoints.accounts.tokens import token_id
from endpoints.rapyuta.interfaces import EndpointTable
from endpoints.resources.services import Services
from tests.support.endpoints.rapyuta import ClonePlace, StillRobot, StillSessions
from tests.support.storage import records


@pytest.fixture
async def place() -> ClonePlace:
    return ClonePlace()


@pytest.fixture
def sessions(place: ClonePlace) -> StillSessions:
    return StillSessions(place)


@pytest.fixture
def table() -> EndpointTable:
    return EndpointTable()


@pytest.fixture
async def token(services: Services) -> str:
    """Return the id of a token of ann, who has two robots."""
    await services.accounts.register("ann", "correct horse")
    for robot in ("tb1", "tb2"):
        services.store.put_robot(records.robot(robot))
    return token_id(await services.accounts.login("ann", "correct horse"))


@pytest.fixture
async def robot(services: Services, sessions: StillSessions, table: EndpointTable, token: str) -> StillRobot:
    """Return a robot without a container."""
    return StillRobot(services, sessions, table, token)


@pytest.fixture
async def other(services: Services, sessions: StillSessions, table: EndpointTable, token: str) -> StillRobot:
    """Return another robot of the same user."""
    return StillRobot(services, sessions, table, token, "tb2")
