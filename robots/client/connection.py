"""WebSocket connection to the cloud: its URL, its options, and the errors of a refused handshake."""

import logging
import random
import ssl
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal
from urllib.parse import urlencode, urlsplit, urlunsplit

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidHandshake, InvalidStatus, InvalidURI

from ppaas import __version__
from ppaas.errors import InvalidInput, Unavailable
from ppaas.wire.refusals import error_of_status, untrusted
from ppaas.wire.resumption import (
    ANEW,
    ENDPOINT_HEADER,
    ID_HEADER,
    RESUME,
    RESUMED,
    SESSION,
    STATE_HEADER,
    TAKEN_HEADER,
    ResumptionPoint,
)
from robots.client.cloud_url import CloudUrl, bearer, check_redirect

logger = logging.getLogger(__name__)

Role = Literal["robot", "operator"]


@dataclass(frozen=True, slots=True)
class ConnectionOptions:
    """Time-outs and sizes of a client's connection.

    Parameters
    ----------
    open_timeout : float
        Time limit of one attempt to connect [s]; the cloud completes the handshake when the container is ready.
    ping_interval : float
        Time between two pings [s].
    ping_timeout : float
        The connection counts as lost if the pong does not arrive within this time [s].
    max_size : int
        Largest frame accepted [bytes]; maps are the largest messages.
    write_limit : int
        High-water mark of the write buffer [bytes]. Smaller values keep the data on a slow link fresher.
    """

    open_timeout: float = 20.0
    ping_interval: float = 5.0
    ping_timeout: float = 10.0
    max_size: int = 1 << 26
    write_limit: int = 1 << 15


class Address:
    """URL and headers of a robot's WebSocket, for one client of the robot.

    Parameters
    ----------
    url : str
        URL of the cloud: ``http://host:port``, or the same with https, ws or wss, and with a path if a proxy serves the
        cloud below one.
    robot, token, role : str
        Id of the robot, token of the user, and role of the client.
    session : str
        Name of the client's session.
    hold : bool
        Whether the connection opens a place for the robot and keeps it open.

    Attributes
    ----------
    headers : dict of str to str
        Headers of the handshake, with the token.

    Raises
    ------
    InvalidInput
        The URL has another form.
    NotAuthenticated
        The token has characters that no token has.
    """

    def __init__(self, url: str, *, robot: str, token: str, role: Role, session: str, hold: bool = True) -> None:
        self._given = CloudUrl.parse(url)
        self._preferred = self._given
        self._query: dict[str, object] = {"robot": robot, "role": role, "status": 1, SESSION: session}
        self._query["software"] = f"ppaas/{__version__}"
        self.headers = bearer(token)
        if not hold:
            self._query["hold"] = 0
        self.hold = hold

    def at(self, point: ResumptionPoint | None) -> str:
        """Return the URL that resumes a session at ``point``, or begins a new session if it is None."""
        parts = self._preferred
        base = ("wss" if parts.secure else "ws", parts.netloc, f"{parts.path}/")
        return urlunsplit((*base, urlencode(self._query | {RESUME: point or ANEW}), ""))

    def prefer(self, url: str) -> None:
        """Use another address of the same cloud from now on, unless it is not valid or would not encrypt as before."""
        try:
            parts = CloudUrl.parse(url)
        except InvalidInput as error:
            logger.warning("the address of a nearer endpoint is not used: %s", error)
            return
        if parts.secure or not self._given.secure:
            self._preferred = parts

    def go_back(self) -> bool:
        """Use the given address again; return whether another one was preferred."""
        preferred, self._preferred = self._preferred, self._given
        return preferred != self._given


def session_of(socket: ClientConnection) -> tuple[str, int | None]:
    """Return the session that the server reported in the handshake.

    Returns
    -------
    id : str
        Id of the session; empty if the server does not keep sessions.
    taken : int or None
        Number of frames that the cloud has received in a resumed session; None for a new session.
    """
    headers = socket.response.headers if socket.response is not None else {}
    resumed = headers.get(STATE_HEADER) == RESUMED
    return headers.get(ID_HEADER, ""), int(headers.get(TAKEN_HEADER, "0")) if resumed else None


def nearer_endpoint(socket: ClientConnection) -> str:
    """Return the address of an endpoint on the machine of the robot's container; empty if the server names none."""
    return socket.response.headers.get(ENDPOINT_HEADER, "") if socket.response is not None else ""


class _Connect(connect):
    """Connection attempt that follows no redirect: the token is for the cloud of the URL alone."""

    def process_redirect(self, exc: Exception) -> Exception | str:
        """Return the refusal itself."""
        return exc


async def open_socket(url: str, headers: dict[str, str], link: ConnectionOptions) -> ClientConnection:
    """Open the WebSocket, with headers besides the handshake's.

    Raises
    ------
    PPaaSError
        The reason of the refusal; ``Unavailable`` if another attempt may succeed.
    """
    try:
        return await _Connect(
            url,
            additional_headers=headers,
            open_timeout=link.open_timeout,
            ping_interval=link.ping_interval,
            ping_timeout=link.ping_timeout,
            max_size=link.max_size,
            write_limit=link.write_limit,
            close_timeout=2.0,
            compression=None,
            proxy=None,
        )
    except InvalidStatus as error:
        check_redirect(url, error.response.status_code, error.response.headers.get("Location"))
        raise error_of_status(error.response.status_code, bytes(error.response.body or b"")) from error
    except InvalidURI as error:
        raise InvalidInput(str(error)) from error
    except ssl.SSLCertVerificationError as error:
        raise Unavailable(f"cannot connect to {urlsplit(url).netloc}: {untrusted(error.verify_message)}") from error
    except (OSError, TimeoutError, InvalidHandshake) as error:
        host = urlsplit(url).netloc
        raise Unavailable(f"cannot connect to {host}: {error or type(error).__name__}") from error


def backoff(first: float = 0.2, factor: float = 2.0, longest: float = 10.0) -> Iterator[float]:
    """Yield the delays between attempts to connect [s]: exponential backoff, with jitter to spread a fleet."""
    delay = first
    while True:
        yield delay * random.uniform(0.5, 1.0)
        delay = min(delay * factor, longest)
