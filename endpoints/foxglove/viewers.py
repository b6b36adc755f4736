"""Viewers that are connected, and their limits."""

import asyncio

from endpoints.foxglove.viewer import Login, Viewer
from endpoints.http.websocket_protocol import Probe
from endpoints.rosbridge.session_registry import SessionRegistry
from endpoints.services.services import Services
from ppaas.errors import QuotaExceeded
from ppaas.messages import type_name
from ppaas.nodes.topics import TOPICS
from ppaas.wire.foxglove.conversion.conversions import conversion_of
from ppaas.wire.ros.types import ROS_1, ros_types

MAX_VIEWERS = 100
"""Largest number of viewers."""

MAX_OF_USER = 16
"""Largest number of viewers of one user."""


class Viewers:
    """Connected viewers.

    Parameters
    ----------
    services : Services
    sessions : SessionRegistry
    """

    def __init__(self, services: Services, sessions: SessionRegistry) -> None:
        self._services = services
        self._sessions = sessions
        self._viewers: set[Viewer] = set()

    def __len__(self) -> int:
        """Return the number of viewers."""
        return len(self._viewers)

    def admit(self, login: Login, probe: Probe) -> Viewer:
        """Return a new viewer; `release` must follow.

        Raises
        ------
        QuotaExceeded
            There are too many viewers, or too many of the same user.
        """
        mine = sum(viewer.login.user == login.user for viewer in self._viewers)
        if mine >= MAX_OF_USER or len(self._viewers) >= MAX_VIEWERS:
            raise QuotaExceeded(
                f"at most {MAX_OF_USER} viewers of a user, and {MAX_VIEWERS} in all, are connected: close one first"
            )
        viewer = Viewer(self._services, self._sessions, login, probe)
        self._viewers.add(viewer)
        return viewer

    def release(self, viewer: Viewer) -> None:
        """Close a viewer."""
        self._viewers.discard(viewer)
        viewer.close()

    async def prepare(self) -> None:
        """Read the definitions of types of ROS, which takes a second the first time, in a thread."""
        await asyncio.to_thread(_read_definitions)


def _read_definitions() -> None:
    for topic in TOPICS.values():
        conversion_of(type_name(topic.type))
    ros_types(ROS_1)
