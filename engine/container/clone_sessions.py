"""Sessions of the clients of a clone, in the process of its container."""

import os

from engine.container.endpoint_link import EndpointLink
from engine.container.local_link import LocalLink
from engine.container.robot_link_handler import Container
from engine.container.served_link import ServedLink
from engine.protocols import robot_link
from engine.sessions.host import SessionHost
from engine.sessions.place.place import Place
from engine.specs.containers import SESSIONS_STATE, ContainerSpec, RobotConfig, base_frame


class _NearEnd:
    """The place's end of the local link."""

    waiting = 0

    def __init__(self, container: Container, link: ServedLink) -> None:
        self._container = container
        self._link = link

    def write(self, frame: robot_link.ToContainer) -> None:
        """Pass on a frame of the sessions."""
        if not isinstance(frame, robot_link.Shutdown):  # only the endpoint ends a container
            self._container.take(self._link, frame)


class CloneSessions:
    """Place of a robot with its sessions, connected to the clone by a link within the process.

    Parameters
    ----------
    spec : ContainerSpec
        The container; its checkpoint may have sessions of an earlier one.
    robot : RobotConfig
        The robot.
    """

    def __init__(self, spec: ContainerSpec, robot: RobotConfig) -> None:
        self._place = Place(f"{spec.user}/{robot.id}", base_frame(robot))
        self.host = SessionHost(self._place)
        if SESSIONS_STATE in spec.checkpoint:
            self.host.restore(spec.checkpoint[SESSIONS_STATE])

    def begin(self, container: Container, endpoint: EndpointLink) -> None:
        """Connect the place to the clone, and serve the sockets of the endpoint."""
        link = ServedLink(LocalLink(self._place.take))
        container.add_link(link)
        self._place.begin(container.hello(os.getpid()), _NearEnd(container, link))
        self.host.link_up(endpoint)
        self.host.forget_restored()
