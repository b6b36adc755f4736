"""A cloud for MCP servers: real REST, stores in memory, and a place of a robot that the test plays."""

from collections.abc import AsyncIterator

import pytest

from engine.control import robot_navigation
from robots.mcp import driving
from tests.support.cloud.served_users import ServedUsers, serving_users
from tests.support.endpoints.still_place import StillRobot
from tests.support.storage import records


@pytest.fixture
async def served(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[ServedUsers]:
    """Return the cloud; its users are ann, bob and admin."""
    monkeypatch.setattr(robot_navigation, "POSE_TIMEOUT", 0.01)
    monkeypatch.setattr(driving, "POLL", 0.01)
    async with serving_users() as served:
        yield served


@pytest.fixture
def place(served: ServedUsers) -> StillRobot:
    """Return the place of ann's connected robot tb1; tb2 is not connected."""
    for robot in ("tb1", "tb2"):
        served.services.store.put_robot(records.robot(robot, user="ann"))
    made = StillRobot()
    served.cloud.connect("ann", "tb1", made)
    return made
