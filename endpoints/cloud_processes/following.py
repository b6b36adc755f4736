"""Settings that an endpoint follows while it serves, as the process of the master reads them again."""

import asyncio
import logging
from typing import TYPE_CHECKING

import msgspec

from endpoints.cloud_processes.config import EndpointConfig, settings_at_start
from endpoints.http.connection_table import connection_limits, raise_file_limit
from endpoints.settings.live import LiveCalls, LiveSettings
from endpoints.web import Web, log_at
from engine.master.quotas import Quotas
from ppaas.errors import PPaaSError

if TYPE_CHECKING:
    from endpoints.oidc.logins import OidcLogins
    from endpoints.oidc.settings import OidcSettings

logger = logging.getLogger(__name__)

RETRY = 1.0
"""Time between two attempts to ask a master [s]."""


def oidc_logins(settings: "OidcSettings | None") -> "OidcLogins | None":
    """Return the logins with an identity provider; None for a cloud without one."""
    if settings is None:
        return None
    from endpoints.oidc.logins import OidcLogins  # noqa: PLC0415 - imports authlib, of an extra

    return OidcLogins(settings)


class FollowedSettings:
    """Applies settings to an endpoint.

    Parameters
    ----------
    config : EndpointConfig
        Settings at its start.
    web : Web
    quotas : Quotas
    is_far : bool
        Whether the endpoint is on another host, which has own settings of how it serves clients.
    """

    def __init__(self, config: EndpointConfig, web: Web, quotas: Quotas, *, is_far: bool) -> None:
        self._services = web.services
        self._web = web
        self._quotas = quotas
        self._is_far = is_far
        self._now = settings_at_start(config)

    async def run(self, calls: LiveCalls) -> None:
        """Follow the master's settings until cancelled; without a master, they stay as they are."""
        known: LiveSettings | None = None
        while True:
            try:
                known = await calls.changed(known)
            except PPaaSError as error:
                logger.debug("the settings cannot be followed now: %s", error)
                await asyncio.sleep(RETRY)
            else:
                self.apply(known)

    def apply(self, live: LiveSettings) -> None:
        """Put settings into force."""
        before = self._now
        if self._is_far:
            live = msgspec.structs.replace(before, quota=live.quota, keep_versions=live.keep_versions)
        self._now = live
        self._quotas.set_default(live.quota)
        self._services.keep_versions = live.keep_versions
        if live.log_level != before.log_level:
            log_at(live.log_level)
        if (live.trusted_proxy, live.allow_origin) != (before.trusted_proxy, before.allow_origin):
            self._web.change_front(live.trusted_proxy, live.allow_origin)
        limits = live.max_connections, live.max_connections_per_address
        if limits != (before.max_connections, before.max_connections_per_address):
            self._web.connections.limit(*connection_limits(raise_file_limit(), *limits))
        if live.oidc != before.oidc:
            self._services.oidc = oidc_logins(live.oidc)
        if live != before:
            logger.info("the settings of this endpoint have changed")
