"""TLS of the web server: its certificate, and the connections whose handshake is not complete.

The certificate is read again when its files change, without ending connections.
"""

import asyncio
import ipaddress
import logging
import socket
import ssl
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from endpoints.http.connection_table import ConnectionTable
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


# Connections by TLS, bounded in time and number before their handshake is complete.
#
# A server of asyncio makes the protocol of a connection when its handshake is complete. Until then it would not be
# counted.

HANDSHAKE_SECONDS = 10.0
"""Time limit of the handshake [s]."""

PAUSE = 0.1
"""Pause after a connection could not be accepted, for example because too many files are open [s]."""


class HandshakeListener:
    """Accepts connections and completes their handshakes.

    Parameters
    ----------
    listener : socket
        Listening socket.
    context : SSLContext
        Context of the server.
    table : ConnectionTable
        Table of the connections of the server.
    served : callable
        Makes the protocol of a connection whose handshake is complete.
    """

    def __init__(
        self,
        listener: socket.socket,
        context: ssl.SSLContext,
        table: ConnectionTable,
        served: Callable[[], asyncio.Protocol],
    ) -> None:
        self._listener = listener
        self._context = context
        self._table = table
        self._served = served
        self._handshakes: set[_Handshake] = set()

    async def run(self) -> None:
        """Accept connections until cancelled; then end those whose handshake is not complete."""
        loop = asyncio.get_running_loop()
        self._listener.setblocking(False)
        try:
            while True:
                try:
                    accepted, peer = await loop.sock_accept(self._listener)
                except OSError as error:
                    logger.warning("a connection could not be accepted: %s", error)
                    await asyncio.sleep(PAUSE)
                    continue
                self._begin(accepted, str(peer[0]))
        finally:
            for handshake in tuple(self._handshakes):
                handshake.make_room()

    def _begin(self, accepted: socket.socket, host: str) -> None:
        handshake = _Handshake(accepted)
        if not self._table.admit(handshake, host):
            accepted.close()
            return
        self._handshakes.add(handshake)
        handshake.task = asyncio.get_running_loop().create_task(self._complete(handshake))

    async def _complete(self, handshake: "_Handshake") -> None:
        try:
            await asyncio.get_running_loop().connect_accepted_socket(
                lambda: _Starter(self._served, lambda: self._table.leave(handshake)),
                handshake.socket,
                ssl=self._context,
                ssl_handshake_timeout=HANDSHAKE_SECONDS,
            )
        except OSError as error:
            logger.debug("a TLS handshake failed: %s", error)
        finally:
            self._table.leave(handshake)
            self._handshakes.discard(handshake)


class _Handshake:
    """Connection whose handshake is not complete."""

    def __init__(self, accepted: socket.socket) -> None:
        self.socket = accepted
        self.task: asyncio.Task[None] | None = None

    def make_room(self) -> None:
        """Close the connection."""
        if self.task is not None:
            self.task.cancel()


class _Starter(asyncio.Protocol):
    """Protocol that is replaced by the one of the server when the handshake is complete."""

    def __init__(self, served: Callable[[], asyncio.Protocol], complete: Callable[[], None]) -> None:
        self._served = served
        self._complete = complete

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Handle the end of the handshake."""
        self._complete()
        protocol = self._served()
        transport.set_protocol(protocol)
        protocol.connection_made(transport)
