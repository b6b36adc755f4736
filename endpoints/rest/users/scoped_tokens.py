"""Route to create tokens for some robots only."""

from fastapi import APIRouter, Request, Response

from endpoints.accounts.tokens import IssuedToken
from endpoints.audit.notes import note_object
from endpoints.audit.redaction import TOKEN_SHOWN
from endpoints.rest.dependencies import Caller, Provided
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.strict_json import StrictRoute
from endpoints.rest.users.schemas import ScopedTokenRequest, TokenAnswer

router = APIRouter(prefix="/scoped-tokens", tags=["tokens"], route_class=StrictRoute)


@router.post("", status_code=201, response_model=TokenAnswer, responses=KNOWN | BODY | problems(403))
async def create_token(
    wanted: ScopedTokenRequest, request: Request, services: Provided, user: Caller, response: Response
) -> IssuedToken:
    """Create a token of the caller for some robots only. Its text is returned only here and never stored."""
    response.headers["Cache-Control"] = "no-store"
    token = await services.accounts.issue_scoped(user.id, wanted.scope, wanted.expires_in, wanted.name)
    note_object(request.scope, f"tokens/{token.id[:TOKEN_SHOWN]}")
    return token
