"""Tickets over REST."""

import httpx

from endpoints.accounts.tokens import token_id
from endpoints.services.services import Services
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn


async def test_a_ticket_stands_for_the_token_of_the_request(
    client: httpx.AsyncClient, services: Services, log_in: LogIn
) -> None:
    header = await log_in("ann")
    answer = await client.post("/v1/tickets", headers=header)
    assert answer.status_code == 201
    assert answer.headers["cache-control"] == "no-store"
    assert answer.json()["expires_in"] == 30.0
    token = header["Authorization"].split()[1]
    assert await services.accounts.redeem_ticket(answer.json()["ticket"]) == token_id(token)


async def test_a_ticket_needs_a_token(client: httpx.AsyncClient) -> None:
    problem_of(await client.post("/v1/tickets"), 401, "not-authenticated")
