"""Interface of protocols that endpoints serve on ports of their own, beside REST and rosbridge, and their registry."""

from abc import ABC, abstractmethod
from typing import ClassVar

from starlette.types import ASGIApp

from endpoints.http.front_settings import FrontSettings
from endpoints.resources.services import Services
from endpoints.rosbridge import SessionRegistry
from ppaas.plugins import PluginRegistry

MAX_FRAME = 16 * 1024 * 1024
"""Largest frame of a robot [bytes]: ten times a raw 640×480 depth image."""


class ClientProtocol(ABC):
    """Protocol of clients, found by an entry point in the group ``ppaas.protocols``, and loaded if its port is given.

    Parameters
    ----------
    services : Services
        Services with the accounts, the store and the audit log.
    sessions : SessionRegistry
        Attaches to the places of robots.
    settings : FrontSettings
        Trusted proxies.

    Attributes
    ----------
    max_frame : int
        Largest frame of a client [bytes].
    """

    max_frame: ClassVar[int] = MAX_FRAME

    def __init__(self, services: Services, sessions: SessionRegistry, settings: FrontSettings) -> None:
        self._services = services
        self._sessions = sessions
        self._settings = settings

    @abstractmethod
    def app(self) -> ASGIApp:
        """Return the application; its address is ``/``."""

    async def watch(self) -> None:
        """Watch its clients until cancelled, if it has to."""

    async def close(self) -> None:
        """End all its clients."""


PROTOCOLS: PluginRegistry[ClientProtocol] = PluginRegistry("ppaas.protocols", "protocol", ClientProtocol, {})  # type: ignore[type-abstract]
