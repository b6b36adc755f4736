"""Routes of logins with the identity provider of a cloud: of browsers, devices and programs.

Each answers with an ordinary token of the cloud, so that nothing else has to know how somebody has logged in.
"""

from collections.abc import Awaitable
from typing import TYPE_CHECKING, Annotated, Any
from urllib.parse import parse_qs

import msgspec
from fastapi import APIRouter, HTTPException, Query, Request, Response
from starlette.responses import JSONResponse

from endpoints.accounts.authentication import note_caller
from endpoints.audit.requests import note_details, note_object
from endpoints.resources import removal
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Provided
from endpoints.rest.openapi import BODY, problems
from endpoints.rest.strict_json import StrictRoute, media_type_of
from endpoints.rest.users.oidc_schemas import (
    AccessToken,
    CodeLogin,
    DeviceCodeAnswer,
    DeviceLogin,
    LoginPendingAnswer,
    LoginStartAnswer,
    ProvidedToken,
    ProviderAnswer,
)
from endpoints.rest.users.tokens import UNKNOWN
from ppaas.errors import InvalidInput, MalformedMessage, NotAuthenticated, NotFound

if TYPE_CHECKING:
    from endpoints.oidc.logins import OidcLogins, Vouched

router = APIRouter(prefix="/oidc", tags=["tokens"], route_class=StrictRoute)

_LOGIN = problems(401, 403, 404, 409) | BODY

PATHS = tuple(
    f"{router.prefix}/{name}" for name in ("logins", "codes", "devices", "device-tokens", "access-tokens", "logouts")
)
"""Paths of logins and logouts."""

MOST_FIELDS = 16
"""Largest number of fields of a form."""

FORM = "application/x-www-form-urlencoded"
_LOGOUT_TOKEN: dict[str, Any] = {
    "required": True,
    "content": {
        FORM: {
            "schema": {
                "type": "object",
                "required": ["logout_token"],
                "properties": {"logout_token": {"type": "string"}},
            }
        }
    },
}


@router.get("", response_model=ProviderAnswer)
async def show_provider(services: Provided) -> ProviderAnswer:
    """Show the identity provider with which people may log in, if the cloud has one; without a token."""
    return ProviderAnswer(name=None if services.oidc is None else services.oidc.name)


@router.post("/logins", status_code=201, response_model=LoginStartAnswer, responses=problems(404))
async def begin_login(
    services: Provided,
    response: Response,
    again: Annotated[bool, Query(description="have the provider ask who it is, for another account there")] = False,
) -> object:
    """Begin the login of a browser, which goes to the provider next."""
    _keep_secret(response)
    return await _provider(services).begin(again=again)


@router.post("/codes", status_code=201, response_model=ProvidedToken, responses=_LOGIN)
async def log_in_by_code(given: CodeLogin, services: Provided, request: Request, response: Response) -> ProvidedToken:
    """Create a token for a browser that the provider has sent back. Its text is returned only here and never stored."""
    _keep_secret(response)
    found = _provider(services).by_code(given.code, given.verifier, given.nonce, given.iss)
    return await _log_in(found, services, request)


@router.post("/devices", status_code=201, response_model=DeviceCodeAnswer, responses=problems(401, 404))
async def begin_device_login(services: Provided, response: Response) -> object:
    """Begin the login of a device without a browser, such as a command line: its person logs in anywhere else."""
    _keep_secret(response)
    code, verifier = await _provider(services).begin_device()
    return msgspec.structs.asdict(code) | {"verifier": verifier}


@router.post(
    "/device-tokens",
    status_code=201,
    response_model=ProvidedToken,
    responses=_LOGIN | {202: {"model": LoginPendingAnswer, "description": "Nobody has logged in yet: ask again"}},
)
async def log_in_by_device(given: DeviceLogin, services: Provided, request: Request, response: Response) -> object:
    """Create a token for a device whose person has logged in. Its text is returned only here and never stored."""
    from endpoints.oidc.provider import LoginPending  # noqa: PLC0415 - of an extra

    _keep_secret(response)
    provider = _provider(services)
    try:
        return await _log_in(provider.by_device(given.device_code, given.verifier), services, request)
    except LoginPending as pending:
        return JSONResponse({"slower": pending.slower}, status_code=202, headers={"Cache-Control": "no-store"})


@router.post("/access-tokens", status_code=201, response_model=ProvidedToken, responses=_LOGIN)
async def log_in_by_access_token(
    given: AccessToken, services: Provided, request: Request, response: Response
) -> ProvidedToken:
    """Create a token for a program that has an access token for this cloud; it expires with that one."""
    _keep_secret(response)
    return await _log_in(_provider(services).by_access_token(given.access_token), services, request)


@router.post(
    "/logouts",
    status_code=200,
    response_class=Response,
    responses={200: {"description": "The sessions have ended"}} | problems(404) | BODY,
    openapi_extra={"requestBody": _LOGOUT_TOKEN},
)
async def end_provider_sessions(services: Provided, request: Request) -> Response:
    """End the sessions of which the identity provider reports the logout (OpenID Connect Back-Channel Logout 1.0)."""
    provider = _provider(services)
    try:
        found = await provider.logout(await _logout_token(request))
    except NotAuthenticated as error:
        raise InvalidInput(str(error)) from error  # 400, as the specification wants it
    note_details(request.scope, subject=found.subject, session=found.session is not None)
    ended = await services.accounts.identities.sign_out(found.issuer, found.subject, found.session, before=found.before)
    note_details(request.scope, tokens=ended)
    return Response(status_code=200, headers={"Cache-Control": "no-store"})


async def _logout_token(request: Request) -> str:
    if media_type_of(request) != FORM:
        raise HTTPException(415, f"send a form with the header 'Content-Type: {FORM}'")
    try:
        form = parse_qs((await request.body()).decode("ascii"), max_num_fields=MOST_FIELDS)
    except ValueError as error:  # also of characters beyond ASCII
        raise MalformedMessage(f"the body is no form: {error}") from error
    given = form.get("logout_token", [])
    if len(given) != 1:
        raise InvalidInput("the form must have one logout_token")
    return given[0]


def _provider(services: Services) -> "OidcLogins":
    if services.oidc is None:
        raise NotFound("login", "oidc", advice="this cloud has no identity provider (ppaas up --oidc-issuer)")
    return services.oidc


def _keep_secret(response: Response) -> None:
    response.headers["Cache-Control"] = "no-store"


async def _log_in(vouching: "Awaitable[Vouched]", services: Services, request: Request) -> ProvidedToken:
    """Return a new token of the person for whom the provider vouches, who becomes a user if there is none yet."""
    note_object(request.scope, f"users/{UNKNOWN}")
    vouched = await vouching
    person, identities = vouched.person, services.accounts.identities
    note_details(request.scope, subject=person.identity.subject, name=person.name)
    user = await identities.find(person.identity, person.name)
    if user is None:
        await removal.make_user_free(services, person.name)
        user = await identities.create(person.identity, person.name, person.role)
        note_details(request.scope, created=True)
    note_object(request.scope, f"users/{user.id}")
    token = await identities.sign_in(user, person.role, vouched.lifetime, vouched.session)
    note_caller(request.scope, user.id, token.id)
    return ProvidedToken(
        id=token.id, token=token.token, expires=token.expires, user=user.id, logout_url=vouched.logout_url
    )
