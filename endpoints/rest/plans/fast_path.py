"""Fast path of path requests: answers valid ones before FastAPI routes them."""

import re
from collections import deque

import msgspec
from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from endpoints.accounts.authentication import bearer_of
from endpoints.accounts.tokens import ScopedUser
from endpoints.http.problems import problem_response, unexpected
from endpoints.resources.services import Services
from endpoints.rest.names import is_plugin_name
from endpoints.rest.plans.planning import plan_and_store
from endpoints.rest.plans.representations import PoseForm, Representation, preferred
from ppaas.errors import PPaaSError
from ppaas.plans.path_service import PathRequest
from storage.names import is_name

_decoder = msgspec.json.Decoder(PathRequest)
_FORMS = {b"": PoseForm.ROWS} | {f"poses={form}".encode(): form for form in PoseForm}
"""Forms of poses by the query of the request, of which other spellings are left to FastAPI."""

_QUOTED_KEYS = tuple(f'"{name}"'.encode() for name in PathRequest.__struct_fields__)


class PlanFastPath:
    """ASGI middleware that answers valid path requests itself; FastAPI takes a millisecond longer.

    It authenticates the caller before it reads the body. It passes every other request on from its first message:
    invalid ones, so that FastAPI reports what is wrong with them, and valid ones in an unusual form.

    Parameters
    ----------
    app : ASGI application
        Serves all other requests.
    prefix : str
        Prefix of the paths of the REST service.
    services : Services
        Services of the cloud.
    """

    def __init__(self, app: ASGIApp, prefix: str, services: Services) -> None:
        self._app = app
        self._path = re.compile(f"{re.escape(prefix)}/maps/([^/]+)/plans")
        self._services = services

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        token = path = None
        if scope["type"] == "http" and scope["method"] == "POST":
            path = self._path.fullmatch(scope["path"])
            token = _token(scope["headers"]) if path is not None else None
        if path is None or token is None or not is_name(path[1]) or scope["query_string"] not in _FORMS:
            await self._app(scope, receive, send)
            return
        messages = list[Message]()
        response = await self._answer(scope, path[1], token, receive, messages)
        if response is None:
            await self._app(scope, _replay(messages, receive), send)
        else:
            await response(scope, receive, send)

    async def _answer(
        self, scope: Scope, map_id: str, token: str, receive: Receive, messages: list[Message]
    ) -> Response | None:
        """Return the response to a request; None if FastAPI must serve it from the messages appended here."""
        try:
            user = await self._services.accounts.authenticate(token)
            # The route refuses what the scope of its token does not allow.
            if isinstance(user, ScopedUser):
                return None
            await self._services.cloud.set_limits(user.id, user.limits)
            request = await _read_request(receive, messages)
            if request is None:
                return None
            return await plan_and_store(self._services, user, map_id, request, _representation(scope))
        except HTTPException:  # of the body that arrives too slowly
            return None
        except PPaaSError as error:
            return problem_response(error)
        except Exception:  # noqa: BLE001  # logged; FastAPI's handler of unexpected errors is behind this middleware
            return unexpected(scope)


def _token(headers: list[tuple[bytes, bytes]]) -> str | None:
    """Return the bearer token of a JSON request; None if a header is repeated or has an unusual form."""
    by_name = dict(headers)
    if len(by_name) != len(headers) or by_name.get(b"content-type") != b"application/json":
        return None
    return bearer_of(by_name.get(b"authorization", b"").decode("latin-1"))


def _representation(scope: Scope) -> Representation:
    accept: bytes = next((value for name, value in scope["headers"] if name == b"accept"), b"")
    return Representation(preferred(accept.decode("latin-1")), _FORMS[scope["query_string"]])


async def _read_request(receive: Receive, messages: list[Message]) -> PathRequest | None:
    """Return the request in a body, None if FastAPI must serve it; append the messages received to ``messages``."""
    while not messages or messages[-1].get("more_body", False):
        messages.append(await receive())
        if messages[-1]["type"] == "http.disconnect":
            return None
    body = b"".join([message.get("body", b"") for message in messages])
    if b"\\" in body or any(body.count(key) > 1 for key in _QUOTED_KEYS):
        return None  # perhaps a repeated key, of which the decoder would take the last
    try:
        request = _decoder.decode(body)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
    if request.labels or request.parameters:  # their keys may be repeated, too
        return None
    return request if is_plugin_name(request.planner) else None


def _replay(messages: list[Message], receive: Receive) -> Receive:
    pending = deque(messages)

    async def replay() -> Message:
        return pending.popleft() if pending else await receive()

    return replay
