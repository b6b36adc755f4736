"""A client of the REST service, for a robot's owner and for the commands."""

import asyncio
import http.client
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import urlencode, urlsplit

import msgspec

from ppaas.errors import InvalidInput, NotAuthenticated, PPaaSError, Unavailable
from ppaas.wire.refusals import error_of_status
from robots.client.multipart_form import BLOCK, Content, Form
from robots.client.rest_paths import path_of
from robots.client.robot_file import RobotFile

MAX_PAGE = 500
"""Most items that the cloud gives at a time."""


class Login(msgspec.Struct, frozen=True):
    """A token, and when it ends [seconds since the epoch]."""

    token: str
    expires: float


@dataclass(frozen=True, slots=True)
class _Body:
    content_type: str
    data: bytes | Form

    @property
    def length(self) -> int:
        return self.data.length if isinstance(self.data, Form) else len(self.data)


_NOTHING = _Body("application/json", b"")


def _parse(data: bytes) -> Any:
    try:
        return msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise PPaaSError(f"the answer is not JSON, so it is not from this cloud: {error}") from error


def _json(value: Any, content_type: str = "application/json") -> _Body:
    try:
        return _Body(content_type, msgspec.json.encode(value))
    except UnicodeEncodeError as error:
        raise InvalidInput(f"there is something in it that is no text: {error.object!a}") from error


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
        try:
            parts = urlsplit(url)
            good = parts.scheme in ("http", "https") and parts.hostname and parts.port != 0
        except ValueError:
            good = False
        if not good or not url.isascii():
            raise InvalidInput(f"the cloud's URL must look like http://host:port, not {url!a}")
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

    async def upload_map(
        self,
        map_id: str,
        yaml: bytes | None = None,
        image: Content | None = None,
        readers: tuple[str, ...] = (),
        *,
        octomap: Content | None = None,
        if_match: str | None = None,
        **fields: str | None,
    ) -> dict[str, Any]:
        """Publish a map, or its new version; return what the cloud says of it.

        Parameters
        ----------
        map_id : str
            Of the map.
        yaml, image, octomap : bytes or Path, optional
            Its files: the first two, the last, or all.
        readers : tuple of str
            Who else may see it; ``*`` is everybody.
        if_match : str, optional
            The version that must be the present one; ``Conflict`` if another is.
        **fields : str, optional
            ``message``, why it is published; ``description``; ``rules``, whose tell free from occupied: ``map_server``
            or ``nav2``.
        """
        given = [("yaml", "map.yaml", yaml), ("image", "map.pgm", image), ("octomap", "map.bt", octomap)]
        said = [(name, value) for name, value in fields.items() if value is not None]
        try:
            form = Form(
                [("id", map_id), *(("readers", reader) for reader in readers), *said],
                [(name, file_name, data) for name, file_name, data in given if data is not None],
            )
        except OSError as error:
            raise InvalidInput(f"cannot read the map: {error}") from error
        answer: dict[str, Any] = _parse(
            await self._ask("POST", "/v1/maps", _Body(form.content_type, form), _expecting(if_match))
        )
        return answer

    async def roll_back_map(
        self, map_id: str, version: str, message: str = "", if_match: str | None = None
    ) -> dict[str, Any]:
        """Make a version that a map had the present one again; return what the cloud says of it."""
        body = _json({"version": version, "message": message})
        path = path_of("maps", map_id, "roll_back")
        answer: dict[str, Any] = _parse(await self._ask("POST", path, body, _expecting(if_match)))
        return answer

    async def put_robot(self, robot_id: str, robot: RobotFile) -> None:
        """Tell of a robot, or change what is known of it."""
        await self._ask("PUT", path_of("robots", robot_id), _Body("application/json", robot.encode()))

    async def put_urdf(self, robot_id: str, urdf: bytes) -> dict[str, Any]:
        """Give a robot its URDF, or another in place of its own; return what it tells."""
        answer: dict[str, Any] = _parse(
            await self._ask("PUT", path_of("robots", robot_id, "urdf"), _Body("application/xml", urdf))
        )
        return answer

    async def plan(
        self, map_id: str, start: Sequence[float], goal: Sequence[float], **options: float | str
    ) -> dict[str, Any]:
        """Have a path planned without a robot; options are ``planner``, ``tolerance`` [m] and ``timeout`` [s]."""
        path = path_of("maps", map_id, "plans")
        answer: dict[str, Any] = await self.post(path, {"start": list(start), "goal": list(goal), **options})
        return answer

    async def get(self, path: str) -> Any:
        """Return the JSON at a path such as ``/v1/users/me``."""
        return _parse(await self._ask("GET", path))

    async def fetch(self, path: str) -> bytes:
        """Return the file at a path."""
        return await self._ask("GET", path)

    async def fetch_to(self, path: str, file: Path) -> None:
        """Write the file at a path to the disk, block by block, in a folder that is made; it is there when it is whole.

        Raises
        ------
        InvalidInput
            It cannot be written.
        """
        aside = file.with_name(f".{file.name}.{secrets.token_hex(4)}")
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            with aside.open("xb") as kept:
                await self._ask("GET", path, into=kept)
            aside.replace(file)
        except OSError as error:
            raise InvalidInput(f"cannot write {file}: {error}") from error
        finally:
            aside.unlink(missing_ok=True)

    async def items(self, path: str, limit: int | None = None) -> list[Any]:
        """Return what is in the list at a path, page by page: all of it, or as many as the limit says."""
        found: list[Any] = []
        cursor: str | None = ""
        while cursor is not None and (limit is None or len(found) < limit):
            most = MAX_PAGE if limit is None else min(limit - len(found), MAX_PAGE)
            query = {"limit": most} | ({"cursor": cursor} if cursor else {})
            page = _parse(await self._ask("GET", f"{path}?{urlencode(query)}"))
            try:
                found += page["items"]
                cursor = page["next"]
            except (TypeError, KeyError) as error:
                raise PPaaSError(f"{self._netloc} answers, but {path} is no list of this cloud") from error
        return found

    async def patch(self, path: str, change: dict[str, Any]) -> Any:
        """Change some of what is at a path by a JSON merge patch (RFC 7396); return what it is then."""
        return _parse(await self._ask("PATCH", path, _json(change, "application/merge-patch+json")))

    async def post(self, path: str, value: Any) -> Any:
        """Send JSON to a path and return the answer's."""
        return _parse(await self._ask("POST", path, _json(value)))

    async def put(self, path: str, value: Any) -> Any:
        """Put JSON at a path and return the answer's."""
        return _parse(await self._ask("PUT", path, _json(value)))

    async def delete(self, path: str) -> None:
        """Delete what is at a path."""
        await self._ask("DELETE", path)

    async def _ask(
        self,
        method: str,
        path: str,
        body: _Body = _NOTHING,
        headers: dict[str, str] | None = None,
        into: BinaryIO | None = None,
    ) -> bytes:
        return await asyncio.to_thread(self._exchange, method, path, body, headers or {}, into)

    def _exchange(self, method: str, path: str, body: _Body, headers: dict[str, str], into: BinaryIO | None) -> bytes:
        kind = http.client.HTTPSConnection if self._https else http.client.HTTPConnection
        connection = kind(self._netloc, timeout=self._timeout)
        try:
            connection.request(method, path, body.data, self._headers(body) | headers)
            response = connection.getresponse()
            if into is None or response.status >= 300:
                data = response.read()
            else:
                data = b""
                _pour(response, into)
        except (OSError, http.client.HTTPException) as error:
            why = error or type(error).__name__
            raise Unavailable(f"cannot reach {self._netloc}: {why}; is the cloud up at {self._url}?") from error
        finally:
            connection.close()
        if response.status >= 300:
            raise error_of_status(response.status, data)
        return data

    def _headers(self, body: _Body) -> dict[str, str]:
        headers = {"Content-Type": body.content_type, "Accept": "application/json", "Content-Length": str(body.length)}
        if self.token is None:
            return headers
        if not (self.token.isascii() and self.token.isprintable()):
            raise NotAuthenticated("the token is none that a cloud gave: log in again")
        return headers | {"Authorization": f"Bearer {self.token}"}


def _expecting(version: str | None) -> dict[str, str]:
    return {} if version is None else {"If-Match": f'"{version}"'}


def _pour(response: http.client.HTTPResponse, into: BinaryIO) -> None:
    while block := response.read(BLOCK):
        try:
            into.write(block)
        except OSError as error:
            raise InvalidInput(f"cannot write {into.name}: {error}") from error
