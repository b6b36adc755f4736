"""The few REST calls that a robot's owner needs: log in, publish a map, tell of a robot."""

import asyncio
import http.client
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote, urlsplit

import msgspec

from ppaas.errors import InvalidInput, PPaaSError, Unavailable
from ppaas.wire.refusals import error_of_status
from robots.robot_file import RobotFile


class Login(msgspec.Struct, frozen=True):
    """A token, and when it ends [seconds since the epoch]."""

    token: str
    expires: float


@dataclass(frozen=True, slots=True)
class _Body:
    content_type: str
    data: bytes


_NOTHING = _Body("application/json", b"")


def _parse(data: bytes) -> Any:
    try:
        return msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise PPaaSError(f"the answer is not JSON, so it is not from this cloud: {error}") from error


def _json(value: Any) -> _Body:
    return _Body("application/json", msgspec.json.encode(value))


def _multipart(fields: list[tuple[str, str]], files: list[tuple[str, str, bytes]]) -> _Body:
    """Return a form (RFC 7578) of (name, value) fields and (name, file name, content) files."""
    boundary = secrets.token_hex(16)
    parts = [(f'form-data; name="{name}"', value.encode()) for name, value in fields]
    parts += [(f'form-data; name="{name}"; filename="{file_name}"', data) for name, file_name, data in files]
    lines = [
        f"--{boundary}\r\nContent-Disposition: {disposition}\r\n\r\n".encode() + data + b"\r\n"
        for disposition, data in parts
    ]
    return _Body(f"multipart/form-data; boundary={boundary}", b"".join(lines) + f"--{boundary}--\r\n".encode())


class RestClient:
    """Asks the cloud's REST service. One connection a request; the calls run in a thread.

    Parameters
    ----------
    url : str
        ``http://host:port`` or ``https://host:port``.
    token : str, optional
        From an earlier ``login``.
    timeout : float
        Seconds that one request may take.

    Raises
    ------
    InvalidInput
        Not such a URL.
    """

    def __init__(self, url: str, token: str | None = None, timeout: float = 30.0) -> None:
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise InvalidInput(f"the cloud's URL must look like http://host:port, not {url!r}")
        self._url = url
        self._https = parts.scheme == "https"
        self._netloc = parts.netloc
        self._timeout = timeout
        self.token = token

    async def login(self, user: str, password: str) -> Login:
        """Get a token, and use it from now on.

        Raises
        ------
        PPaaSError
            What the cloud refuses with; ``Unavailable`` if it cannot be reached. So do all methods here.
        """
        data = await self._ask("POST", "/v1/tokens", _json({"user": user, "password": password}))
        try:
            login = msgspec.json.decode(data, type=Login)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise PPaaSError(f"{self._netloc} answers, but not as this cloud does: {error}") from error
        self.token = login.token
        return login

    async def upload_map(self, map_id: str, yaml: bytes, image: bytes, readers: tuple[str, ...] = ()) -> None:
        """Publish a map, or its new version: the bytes of its YAML and PGM files. Reader ``*`` is everybody."""
        body = _multipart(
            [("id", map_id), *(("readers", reader) for reader in readers)],
            [("yaml", "map.yaml", yaml), ("image", "map.pgm", image)],
        )
        await self._ask("POST", "/v1/maps", body)

    async def put_robot(self, robot_id: str, robot: RobotFile) -> None:
        """Tell of a robot, or change what is known of it."""
        await self._ask("PUT", f"/v1/robots/{quote(robot_id, safe='')}", _Body("application/json", robot.encode()))

    async def plan(
        self, map_id: str, start: Sequence[float], goal: Sequence[float], **options: float | str
    ) -> dict[str, Any]:
        """Have a path planned without a robot; options are ``planner``, ``tolerance`` [m] and ``timeout`` [s]."""
        path = f"/v1/maps/{quote(map_id, safe='')}/plans"
        answer: dict[str, Any] = await self.post(path, {"start": list(start), "goal": list(goal), **options})
        return answer

    async def get(self, path: str) -> Any:
        """Return the JSON at a path such as ``/v1/maps``."""
        return _parse(await self._ask("GET", path))

    async def post(self, path: str, value: Any) -> Any:
        """Send JSON to a path and return the answer's."""
        return _parse(await self._ask("POST", path, _json(value)))

    async def delete(self, path: str) -> None:
        """Delete what is at a path."""
        await self._ask("DELETE", path)

    async def _ask(self, method: str, path: str, body: _Body = _NOTHING) -> bytes:
        return await asyncio.to_thread(self._exchange, method, path, body)

    def _exchange(self, method: str, path: str, body: _Body) -> bytes:
        kind = http.client.HTTPSConnection if self._https else http.client.HTTPConnection
        connection = kind(self._netloc, timeout=self._timeout)
        headers = {"Content-Type": body.content_type, "Accept": "application/json"}
        if self.token is not None:
            headers["Authorization"] = f"Bearer {self.token}"
        try:
            connection.request(method, path, body.data, headers)
            response = connection.getresponse()
            data = response.read()
        except (OSError, http.client.HTTPException) as error:
            why = error or type(error).__name__
            raise Unavailable(f"cannot reach {self._netloc}: {why}; is the cloud up at {self._url}?") from error
        finally:
            connection.close()
        if response.status >= 300:
            raise error_of_status(response.status, data)
        return data
