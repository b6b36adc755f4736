"""A viewer of ann's, who has two robots, one of them with a clone."""

import pytest

from endpoints.accounts.tokens import token_id
from endpoints.resources.services import Services
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.foxglove import StillViewer
from tests.support.endpoints.rapyuta import ClonePlace, StillSessions
from tests.support.storage import records


@pytest.fixture
async def place() -> ClonePlace:
    return ClonePlace()


@pytest.fixture
def sessions(place: ClonePlace) -> StillSessions:
    return StillSessions(place)


@pytest.fixture
async def token(services: Services, cloud: FakeCloud) -> str:
    """Return the id of a token of ann."""
    await services.accounts.register("ann", "correct horse")
    for robot in ("tb1", "tb2"):
        services.store.put_robot(records.robot(robot))
    cloud.running = [container()]
    return token_id(await services.accounts.login("ann", "correct horse"))


@pytest.fixture
async def viewer(services: Services, sessions: StillSessions, token: str) -> StillViewer:
    """Return a viewer that sees the robot."""
    found = StillViewer(services, sessions, token)
    await found.look()
    return found
