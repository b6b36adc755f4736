"""Routes of tokens: log in and out, list and revoke them, tokens for some robots only, tickets for WebSockets."""

from fastapi import APIRouter, Request, Response
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.authentication import address_of, note_caller
from endpoints.accounts.socket_tickets import LIFETIME
from endpoints.accounts.tokens import IssuedToken
from endpoints.audit.requests import TOKEN_SHOWN, note_object
from endpoints.rest.dependencies import AnyCaller, Caller, Paged, Provided, check_unscoped, used_token
from endpoints.rest.names import TokenId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.strict_json import StrictRoute
from endpoints.rest.users.schemas import (
    Credentials,
    ScopeAnswer,
    ScopedTokenRequest,
    TicketAnswer,
    TokenAnswer,
    TokenSummary,
)
from ppaas.errors import NotAuthenticated, TooManyAttempts
from storage.records import Token

router = APIRouter(tags=["tokens"], route_class=StrictRoute)

PATH = "/tokens"
"""Path of the tokens of a user, where users log in."""

CURRENT = "current"
"""Name of the token of the request itself; no token id equals it."""


UNKNOWN = "(unknown)"
"""Name of all users who do not exist, in the audit log."""


@router.post(PATH, status_code=201, response_model=TokenAnswer, responses=problems(401, 429) | BODY)
async def log_in(credentials: Credentials, services: Provided, request: Request, response: Response) -> IssuedToken:
    """Create a token for a user and password. Its text is returned only here and never stored."""
    response.headers["Cache-Control"] = "no-store"
    try:
        login = await services.accounts.sign_in(credentials.user, credentials.password, address_of(request))
    except (NotAuthenticated, TooManyAttempts):
        known = await services.accounts.is_known(credentials.user)
        # Some people enter their password as their name.
        note_object(request.scope, f"users/{credentials.user if known else UNKNOWN}")
        raise
    note_caller(request.scope, credentials.user, login.id)
    note_object(request.scope, f"users/{credentials.user}")
    return login


@router.get(PATH, response_model=Page[TokenSummary], responses=KNOWN)
async def list_tokens(request: Request, services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the caller's tokens by id."""
    used = used_token(request)
    after = paging.key(str, "")
    found = await run_in_threadpool(services.store.tokens, user.id, after=after, limit=paging.fetch_limit)
    return paging.page([_summary(token, used) for token in found], lambda token: token.id)


@router.delete(f"{PATH}/{{token}}", status_code=204, responses=KNOWN | problems(404))
async def revoke_token(token: TokenId, request: Request, services: Provided, user: AnyCaller) -> None:
    """Revoke a token of the caller; `current` logs out, which is all that a token with a scope may do."""
    if token != CURRENT:
        check_unscoped(user)
    await services.accounts.revoke(user.id, used_token(request) if token == CURRENT else token)


def _summary(token: Token, used: str) -> TokenSummary:
    return TokenSummary(
        id=token.hash,
        name=token.name,
        scope=None if token.scope is None else ScopeAnswer.model_validate(token.scope),
        created=token.created,
        expires=token.expires,
        current=token.hash == used,
    )


@router.post("/scoped-tokens", status_code=201, response_model=TokenAnswer, responses=KNOWN | BODY | problems(403))
async def create_token(
    wanted: ScopedTokenRequest, request: Request, services: Provided, user: Caller, response: Response
) -> IssuedToken:
    """Create a token of the caller for some robots only. Its text is returned only here and never stored."""
    response.headers["Cache-Control"] = "no-store"
    token = await services.accounts.issue_scoped(user.id, wanted.scope, wanted.expires_in, wanted.name)
    note_object(request.scope, f"tokens/{token.id[:TOKEN_SHOWN]}")
    return token


@router.post("/tickets", status_code=201, response_model=TicketAnswer, responses=KNOWN)
async def issue_ticket(request: Request, services: Provided, user: AnyCaller) -> dict[str, object]:
    """Create a ticket, which stands for the token of this request in one handshake of a WebSocket (`?ticket=`)."""
    ticket = await services.accounts.issue_ticket(user.id, used_token(request))
    return {"ticket": ticket, "expires_in": LIFETIME}
