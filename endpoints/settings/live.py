"""Settings that endpoints follow while they serve; the process of the master has them."""

import argparse
from typing import Protocol

import msgspec

from endpoints.oidc.settings import OidcSettings, provider_settings
from engine.master.quotas import Quota


class LiveSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Settings of a cloud that endpoints follow: the first two in the whole cloud, the others on the master's host.

    Parameters
    ----------
    quota : Quota
        Quota of users without own limits.
    keep_versions : int, optional
        Number of versions of a map that are kept; None for all.
    log_level : str
    trusted_proxy, allow_origin : tuple of str
    max_connections, max_connections_per_address : int, optional
    oidc : OidcSettings, optional
        As in ``FrontConfig``.
    """

    quota: Quota
    keep_versions: int | None
    log_level: str
    trusted_proxy: tuple[str, ...]
    allow_origin: tuple[str, ...]
    max_connections: int | None
    max_connections_per_address: int | None
    oidc: OidcSettings | None


def live_settings(arguments: argparse.Namespace) -> LiveSettings:
    """Return the settings from the options of ``ppaas up``.

    Raises
    ------
    InvalidInput
        They do not fit together, or a file that they name cannot be read.
    Unavailable
        A package that they need is too old or too new.
    """
    return LiveSettings(
        quota=Quota(**dict(arguments.quota)),
        keep_versions=arguments.keep_versions,
        log_level=arguments.log_level,
        trusted_proxy=tuple(arguments.trusted_proxy),
        allow_origin=tuple(arguments.allow_origin),
        max_connections=arguments.max_connections,
        max_connections_per_address=arguments.max_connections_per_address,
        oidc=provider_settings(arguments),
    )


class LiveCalls(Protocol):
    """Calls of endpoints about the settings that they follow."""

    async def changed(self, known: LiveSettings | None) -> LiveSettings:
        """Return the settings once they are not the known ones."""
        ...
