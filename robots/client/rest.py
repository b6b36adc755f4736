"""REST client for users and for the command line."""

import asyncio
import http.client
import logging
import secrets
import ssl
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import urlencode

import msgspec

from ppaas.clock import monotonic
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, PPaaSError, Starting, Unavailable
from ppaas.wire.refusals import error_of_status, untrusted
from robots.client.cloud_url import CloudUrl, bearer, check_redirect, path_of
from robots.client.robot_file import RobotFile
from robots.client.uploads import BLOCK, Content, Form, exchange

logger = logging.getLogger(__name__)

MAX_PAGE = 500
"""Largest page of a list."""

UPLOAD_TIMEOUT = 300.0
"""Least time limit of an upload of a map [s]; a cloud checks an octree and a pose graph for at most 120 s each."""


START_PATIENCE = 900.0
"""Time for which a request is repeated while the cloud is starting, or compiles kernels that the request needs [s]."""

RETRY = 2.0
"""Time between two attempts meanwhile [s]."""


class Login(msgspec.Struct, frozen=True):
    """A token and its time of expiry [seconds since the epoch]."""

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
        raise PPaaSError(f"the response is not JSON; check that the URL is that of a PPaaS cloud: {error}") from error


def _json(value: Any, content_type: str = "application/json") -> _Body:
    try:
        return _Body(content_type, msgspec.json.encode(value))
    except UnicodeEncodeError as error:
        raise InvalidInput(f"{error.object!a} is not valid Unicode text") from error


class RestClient:
    """Client of the cloud's REST service. Each request opens its own connection and runs in a thread.

    Parameters
    ----------
    url : str
        ``http://host:port`` or ``https://host:port``, with a path if a proxy serves the cloud below one.
    token : str, optional
        Token of an earlier ``login``.
    timeout : float
        Time limit of one request [s].

    Raises
    ------
    InvalidInput
        The URL has another form.
    """

    def __init__(self, url: str, token: str | None = None, timeout: float = 30.0) -> None:
        parts = CloudUrl.parse(url)
        self._url = url
        self._https = parts.secure
        self._netloc = parts.netloc
        self._path = parts.path
        self._timeout = timeout
        self.token = token

    def with_timeout(self, timeout: float) -> "RestClient":
        """Return a client with the same token and another time limit of a request [s]."""
        return RestClient(self._url, self.token, timeout)

    async def login(self, user: str, password: str) -> Login:
        """Obtain a token and use it for all later requests.

        Raises
        ------
        PPaaSError
            The error that the cloud returned; ``Unavailable`` if it cannot be reached. All methods raise these.
        """
        data = await self._request("POST", "/v1/tokens", _json({"user": user, "password": password}))
        try:
            login = from_json(data, Login)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise PPaaSError(f"{self._netloc} did not answer like a PPaaS cloud: {error}") from error
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
        posegraph: Content | None = None,
        zones: Content | None = None,
        if_match: str | None = None,
        **fields: str | None,
    ) -> dict[str, Any]:
        """Publish a map or a new version of it; return its description.

        Parameters
        ----------
        map_id : str
            Id of the map.
        yaml, image, octomap, posegraph, zones : bytes or Path, optional
            Files of the map: YAML and image, an octomap, or all three; a pose graph and zones with YAML and image.
        readers : tuple of str
            Other users who may use the map; ``*`` is everybody.
        if_match : str, optional
            Version that must be the current one; ``Conflict`` if it is not.
        **fields : str, optional
            ``message``: why the map is published; ``description``; ``rules``: how pixels become free or occupied,
            ``map_server`` or ``nav2``.
        """
        files = [
            ("yaml", "map.yaml", yaml), ("image", "map.pgm", image), ("octomap", "map.bt", octomap),
            ("posegraph", "map.posegraph", posegraph), ("zones", "map.geojson", zones),
        ]  # fmt: skip
        texts = [(name, value) for name, value in fields.items() if value is not None]
        try:
            form = Form(
                [("id", map_id), *(("readers", reader) for reader in readers), *texts],
                [(name, file_name, data) for name, file_name, data in files if data is not None],
            )
        except OSError as error:
            raise InvalidInput(f"cannot read the map: {error}") from error
        patient = self.with_timeout(max(self._timeout, UPLOAD_TIMEOUT))
        answer: dict[str, Any] = _parse(
            await patient._request("POST", "/v1/maps", _Body(form.content_type, form), _if_match(if_match))
        )
        return answer

    async def roll_back_map(
        self, map_id: str, version: str, message: str = "", if_match: str | None = None
    ) -> dict[str, Any]:
        """Make an earlier version of a map the current one; return its description."""
        body = _json({"version": version, "message": message})
        path = path_of("maps", map_id, "roll_back")
        answer: dict[str, Any] = _parse(await self._request("POST", path, body, _if_match(if_match)))
        return answer

    async def put_zones(
        self, map_id: str, geojson: bytes, message: str = "", if_match: str | None = None
    ) -> dict[str, Any]:
        """Set or replace the zones of a map; return the description of the version that has them."""
        body = _Body("application/geo+json", geojson)
        answer: dict[str, Any] = _parse(await self._request("PUT", _zones(map_id, message), body, _if_match(if_match)))
        return answer

    async def check_zones(self, map_id: str, geojson: bytes) -> dict[str, Any]:
        """Check zones as if they were put, and change nothing; return their number and warnings."""
        path = path_of("maps", map_id, "zones", "check")
        answer: dict[str, Any] = _parse(await self._request("POST", path, _Body("application/geo+json", geojson)))
        return answer

    async def remove_zones(self, map_id: str, message: str = "", if_match: str | None = None) -> None:
        """Remove the zones of a map."""
        await self._request("DELETE", _zones(map_id, message), headers=_if_match(if_match))

    async def put_building(
        self, building_id: str, building: bytes, message: str = "", if_match: str | None = None
    ) -> dict[str, Any]:
        """Put a building, or a new version of it; return its description with warnings."""
        path = path_of("buildings", building_id) + (f"?{urlencode({'message': message})}" if message else "")
        body = _Body("application/json", building)
        answer: dict[str, Any] = _parse(await self._request("PUT", path, body, _if_match(if_match)))
        return answer

    async def check_building(self, building_id: str, building: bytes) -> dict[str, Any]:
        """Check a building as if it were put, and change nothing; return what was found on its maps, and warnings."""
        path = path_of("buildings", building_id, "check")
        answer: dict[str, Any] = _parse(await self._request("POST", path, _Body("application/json", building)))
        return answer

    async def remove_building(self, building_id: str, if_match: str | None = None) -> None:
        """Remove a building with all its versions; its maps stay."""
        await self._request("DELETE", path_of("buildings", building_id), headers=_if_match(if_match))

    async def plan_in_building(
        self, building_id: str, start: Mapping[str, Any], goal: Mapping[str, Any], **options: Any
    ) -> dict[str, Any]:
        """Request a route over the floors of a building; ``options`` are other members, such as ``alternatives``.

        Start and goal have ``floor``, ``x``, ``y`` [m] and, optionally, ``yaw`` [rad] in the frame of its map.
        """
        body = {"start": dict(start), "goal": dict(goal), **options}
        answer: dict[str, Any] = await self.post(path_of("buildings", building_id, "plans"), body)
        return answer

    async def put_robot(self, robot_id: str, robot: RobotFile) -> None:
        """Register a robot, or replace its robot file."""
        await self._request("PUT", path_of("robots", robot_id), _Body("application/json", robot.encode()))

    async def put_urdf(self, robot_id: str, urdf: bytes) -> dict[str, Any]:
        """Set or replace the URDF of a robot; return the description derived from it."""
        answer: dict[str, Any] = _parse(
            await self._request("PUT", path_of("robots", robot_id, "urdf"), _Body("application/xml", urdf))
        )
        return answer

    async def plan(
        self,
        map_id: str,
        start: Sequence[float],
        goal: Sequence[float],
        *,
        parameters: Mapping[str, Any] | None = None,
        **options: float | str,
    ) -> dict[str, Any]:
        """Request a path on a map.

        Parameters
        ----------
        map_id : str
            Id of the map.
        start, goal : sequence of float
            x, y [m] and, optionally, yaw [rad] in the frame of the map.
        parameters : mapping, optional
            Parameters of the planner and the global costmap, as ``{"allow_unknown": False}``.
        **options : float or str, optional
            ``planner``, ``tolerance`` [m] and ``timeout`` [s].
        """
        body: dict[str, Any] = {"start": list(start), "goal": list(goal), **options}
        if parameters:
            body["parameters"] = dict(parameters)
        answer: dict[str, Any] = await self.post(path_of("maps", map_id, "plans"), body)
        return answer

    async def get(self, path: str) -> Any:
        """Return the JSON at a path such as ``/v1/users/me``."""
        return _parse(await self._request("GET", path))

    async def fetch(self, path: str) -> bytes:
        """Download the file at a path."""
        return await self._request("GET", path)

    async def fetch_to(self, path: str, file: Path) -> None:
        """Download the file at a path to the disk, block by block. Creates the folder; the file appears when complete.

        Raises
        ------
        InvalidInput
            The file cannot be written.
        """
        partial = file.with_name(f".{file.name}.{secrets.token_hex(4)}")
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            with partial.open("xb") as output:
                await self._request("GET", path, into=output)
            partial.replace(file)
        except OSError as error:
            raise InvalidInput(f"cannot write {file}: {error}") from error
        finally:
            partial.unlink(missing_ok=True)

    async def items(self, path: str, limit: int | None = None, **filters: str | float) -> list[Any]:
        """Return the items of the list at a path, fetched page by page: all, or the first ``limit``.

        Filters are further query parameters of the list.
        """
        found: list[Any] = []
        cursor: str | None = ""
        while cursor is not None and (limit is None or len(found) < limit):
            page_size = MAX_PAGE if limit is None else min(limit - len(found), MAX_PAGE)
            query = filters | {"limit": page_size} | ({"cursor": cursor} if cursor else {})
            page = _parse(await self._request("GET", f"{path}?{urlencode(query)}"))
            try:
                found += page["items"]
                cursor = page["next"]
            except (TypeError, KeyError) as error:
                raise PPaaSError(
                    f"{self._netloc} did not answer with a list at {path}; check that the URL is that of a PPaaS cloud"
                ) from error
        return found

    async def patch(self, path: str, change: dict[str, Any]) -> Any:
        """Change the resource at a path by a JSON merge patch (RFC 7396); return the changed resource."""
        return _parse(await self._request("PATCH", path, _json(change, "application/merge-patch+json")))

    async def post(self, path: str, value: Any) -> Any:
        """Post JSON to a path; return the JSON of the response, None if it has no content."""
        answer = await self._request("POST", path, _json(value))
        return _parse(answer) if answer else None

    async def put(self, path: str, value: Any) -> Any:
        """Put JSON at a path; return the JSON of the response."""
        return _parse(await self._request("PUT", path, _json(value)))

    async def delete(self, path: str) -> None:
        """Delete the resource at a path."""
        await self._request("DELETE", path)

    async def _request(
        self,
        method: str,
        path: str,
        body: _Body = _NOTHING,
        headers: dict[str, str] | None = None,
        into: BinaryIO | None = None,
    ) -> bytes:
        """Send a request, and again while the cloud refuses it because it is starting: it has done nothing then."""
        until, told = monotonic() + START_PATIENCE, ""
        while True:
            try:
                return await asyncio.to_thread(self._exchange, method, path, body, headers or {}, into)
            except Starting as error:
                if monotonic() > until:
                    raise
                if str(error) != told:
                    told = str(error)
                    logger.warning("waiting: %s", told)
            await asyncio.sleep(RETRY)

    def _exchange(self, method: str, path: str, body: _Body, headers: dict[str, str], into: BinaryIO | None) -> bytes:
        kind = http.client.HTTPSConnection if self._https else http.client.HTTPConnection
        connection = kind(self._netloc, timeout=self._timeout)
        try:
            response = exchange(connection, method, self._path + path, body.data, self._headers(body) | headers)
            if into is None or response.status >= 300:
                data = response.read()
            else:
                data = b""
                _copy(response, into)
        except TimeoutError as error:
            raise Unavailable(
                f"no answer from {self._netloc} within {self._timeout:g} s: it is busy or not reachable; try again, "
                f"and check that a cloud runs at {self._url}"
            ) from error
        except ssl.SSLCertVerificationError as error:
            raise Unavailable(f"cannot reach {self._netloc}: {untrusted(error.verify_message)}") from error
        except (OSError, http.client.HTTPException) as error:
            reason = error or type(error).__name__
            raise Unavailable(
                f"cannot reach {self._netloc}: {reason}; check that a cloud runs at {self._url}"
            ) from error
        finally:
            connection.close()
        check_redirect(self._url, response.status, response.headers.get("Location"))
        if response.status >= 300:
            raise error_of_status(response.status, data)
        return data

    def _headers(self, body: _Body) -> dict[str, str]:
        headers = {"Content-Type": body.content_type, "Accept": "application/json", "Content-Length": str(body.length)}
        return headers if self.token is None else headers | bearer(self.token)


def _if_match(version: str | None) -> dict[str, str]:
    return {} if version is None else {"If-Match": f'"{version}"'}


def _zones(map_id: str, message: str) -> str:
    return f"{path_of('maps', map_id, 'zones')}?{urlencode({'message': message})}"


def _copy(response: http.client.HTTPResponse, into: BinaryIO) -> None:
    while block := response.read(BLOCK):
        try:
            into.write(block)
        except OSError as error:
            raise InvalidInput(f"cannot write {into.name}: {error}") from error
