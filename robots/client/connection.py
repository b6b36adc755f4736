"""Opening the WebSocket to the cloud, and saying why it was refused."""

import random
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal
from urllib.parse import urlencode, urlsplit, urlunsplit

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidHandshake, InvalidStatus, InvalidURI

from ppaas.errors import InvalidInput, Unavailable
from ppaas.wire.refusals import error_of_status
from ppaas.wire.resumption import ANEW, ID_HEADER, RESUME, RESUMED, SESSION, STATE_HEADER, TAKEN_HEADER, ResumptionPoint

Role = Literal["robot", "operator"]

_SCHEMES = {"ws": "ws", "wss": "wss", "http": "ws", "https": "wss"}


@dataclass(frozen=True, slots=True)
class Link:
    """How a client holds its connection.

    Parameters
    ----------
    open_timeout : float
        Seconds in which one attempt to connect must succeed; the cloud answers when the robot's container is ready.
    ping_interval, ping_timeout : float
        The link is lost when no pong came for so many seconds after a ping [s].
    max_size : int
        Largest frame taken [bytes]; a map is the largest there is.
    write_limit : int
        Bytes given to the operating system's care before sending waits: the less, the fresher is what a slow link
        carries.
    """

    open_timeout: float = 20.0
    ping_interval: float = 5.0
    ping_timeout: float = 10.0
    max_size: int = 1 << 26
    write_limit: int = 1 << 15


class Address:
    """Of the WebSocket of a robot, for one client of it.

    Parameters
    ----------
    url : str
        Of the cloud: ``http://host:port``, or the same with https, ws or wss.
    robot, token, role : str
        Who connects.
    session : str
        Name of the client's session.
    hold : bool
        Open a place for the robot if it has none, and hold it.

    Raises
    ------
    InvalidInput
        Not such a URL.
    """

    def __init__(self, url: str, *, robot: str, token: str, role: Role, session: str, hold: bool = True) -> None:
        parts = urlsplit(url)
        if parts.scheme not in _SCHEMES or not parts.hostname:
            raise InvalidInput(f"the cloud's URL must look like http://host:port, not {url!r}")
        self._base = (_SCHEMES[parts.scheme], parts.netloc, parts.path or "/")
        self._query: dict[str, object] = {"robot": robot, "token": token, "role": role, "status": 1, SESSION: session}
        if not hold:
            self._query["hold"] = 0
        self.hold = hold

    def at(self, point: ResumptionPoint | None) -> str:
        """Return the URL with which to go on where a session was left; without one, to begin anew."""
        return urlunsplit((*self._base, urlencode(self._query | {RESUME: point or ANEW}), ""))


def session_of(socket: ClientConnection) -> tuple[str, int | None]:
    """Return what the handshake told.

    Returns
    -------
    id : str
        Of the session; empty if the server keeps none.
    taken : int or None
        Frames that the cloud took in it, if it goes on; None if it is new.
    """
    headers = socket.response.headers if socket.response is not None else {}
    resumed = headers.get(STATE_HEADER) == RESUMED
    return headers.get(ID_HEADER, ""), int(headers.get(TAKEN_HEADER, "0")) if resumed else None


async def open_socket(url: str, link: Link) -> ClientConnection:
    """Connect.

    Raises
    ------
    PPaaSError
        What the refusal says; ``Unavailable`` where it is worth trying again.
    """
    try:
        return await connect(
            url,
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
        raise error_of_status(error.response.status_code, bytes(error.response.body or b"")) from error
    except InvalidURI as error:
        raise InvalidInput(str(error)) from error
    except (OSError, TimeoutError, InvalidHandshake) as error:
        host = urlsplit(url).netloc
        raise Unavailable(f"cannot connect to {host}: {error or type(error).__name__}") from error


def backoff(first: float = 0.2, factor: float = 2.0, most: float = 10.0) -> Iterator[float]:
    """Yield the seconds to wait before each next attempt; spread at random, lest a fleet comes back at once."""
    delay = first
    while True:
        yield delay * random.uniform(0.5, 1.0)
        delay = min(delay * factor, most)
