"""TLS of the web server: its certificate, read again when its files change, without ending connections."""

import asyncio
import ipaddress
import logging
import socket
import ssl
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from engine.processes.background import repeat
from ppaas.errors import InvalidInput

logger = logging.getLogger(__name__)

PERIOD = 1.0
"""Interval of checks whether the files have changed [s]."""

Stamp = tuple[tuple[int, int, int], ...]
"""Inode, size and time of change of each file."""


class ServerTls:
    """Certificate and key of the server, and the context that uses them.

    Connections that are open keep the certificate that they began with. A context that is in use is never changed,
    since OpenSSL may be in the middle of a handshake with it: each handshake takes the newest context.

    Parameters
    ----------
    certificate : Path
        Certificate of the server in PEM, followed by its issuers' certificates.
    key : Path
        Its private key in PEM, not encrypted.

    Raises
    ------
    InvalidInput
        A file cannot be read, or they do not belong together.
    """

    def __init__(self, certificate: Path, key: Path) -> None:
        self._certificate, self._key = certificate, key
        try:
            self._loaded = self._stamp()
            self.context = self._newest = self._new_context()
        except (OSError, ValueError) as error:
            raise InvalidInput(
                f"cannot use the certificate {certificate} with the key {key}: {error}; give files in PEM that belong "
                "together, the key not encrypted"
            ) from error
        self.context.sni_callback = self._use_newest
        self._failed: Stamp | None = None
        self._reported = False

    async def watch(self, period: float = PERIOD) -> None:
        """Load the files again whenever they change, until cancelled."""
        await repeat(partial(asyncio.to_thread, self.reload_if_changed), period)

    def reload_if_changed(self) -> None:
        """Load the files if they have changed; if they are unusable, keep the certificate, and log it once.

        Certificate and key may be replaced one after the other. So a failure is logged only if it stays.
        """
        try:
            stamp = self._stamp()
            if stamp == self._loaded:
                return
            self._newest = self._new_context()
        except (OSError, ValueError) as error:
            self._note_failure(error)
            return
        self._loaded, self._failed = stamp, None
        logger.info("the certificate %s was read again", self._certificate)

    def _note_failure(self, error: Exception) -> None:
        try:
            stamp = self._stamp()
        except OSError:
            stamp = ()
        if self._failed is None or self._failed != stamp:
            self._failed, self._reported = stamp, False
        elif not self._reported:
            self._reported = True
            logger.error("the new certificate %s is not used: %s; the one before stays", self._certificate, error)

    def _stamp(self) -> Stamp:
        states = [path.stat() for path in (self._certificate, self._key)]
        return tuple((state.st_ino, state.st_size, state.st_mtime_ns) for state in states)

    def _new_context(self) -> ssl.SSLContext:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        context.set_alpn_protocols(["http/1.1"])
        context.load_cert_chain(self._certificate, self._key, password=_no_password)
        return context

    def _use_newest(self, connection: ssl.SSLSocket | ssl.SSLObject, _name: str | None, _first: ssl.SSLContext) -> None:
        """Use the newest certificate in a handshake; OpenSSL calls it for each, also if the client names no host."""
        connection.context = self._newest


def server_tls(certificate: Path | None, key: Path | None) -> ServerTls | None:
    """Return the certificate of the server from the options ``--tls-cert`` and ``--tls-key``; None if there is none.

    Raises
    ------
    InvalidInput
        Certificate or key is missing or unusable.
    """
    if certificate is None and key is None:
        return None
    if certificate is None or key is None:
        raise InvalidInput("TLS needs a certificate and its key: give both --tls-cert and --tls-key")
    return ServerTls(certificate, key)


def warn_if_open_to_others(listeners: Sequence[socket.socket]) -> None:
    """Log a warning if other hosts can connect, because passwords and tokens then cross the network unencrypted."""
    hosts = [str(listener.getsockname()[0]) for listener in listeners]
    others = [host for host in hosts if not ipaddress.ip_address(host.partition("%")[0]).is_loopback]
    if others:
        logger.warning(
            "listening at %s without TLS: passwords and tokens cross the network unencrypted; give --tls-cert and "
            "--tls-key, or listen at 127.0.0.1 behind a proxy that has TLS",
            ", ".join(others),
        )


def _no_password() -> str:
    raise ValueError("the key is encrypted")
