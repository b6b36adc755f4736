"""Logging in."""

from fastapi import APIRouter, Response

from endpoints.accounts import Login
from endpoints.rest.dependencies import Provided
from endpoints.rest.schemas import Credentials, TokenAnswer

router = APIRouter(prefix="/tokens", tags=["tokens"])


@router.post("", status_code=201, response_model=TokenAnswer)
async def log_in(credentials: Credentials, services: Provided, response: Response) -> Login:
    """Give a token to who knows the password. It is told only now, and never kept in the clear."""
    response.headers["Cache-Control"] = "no-store"
    return await services.accounts.sign_in(credentials.user, credentials.password)
