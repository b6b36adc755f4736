"""Route of tickets for the WebSockets of browsers."""

from fastapi import APIRouter, Request

from endpoints.accounts.socket_tickets import LIFETIME
from endpoints.rest.dependencies import AnyCaller, Provided, used_token
from endpoints.rest.openapi import KNOWN
from endpoints.rest.strict_json import StrictRoute
from endpoints.rest.users.schemas import TicketAnswer

router = APIRouter(prefix="/tickets", tags=["tokens"], route_class=StrictRoute)


@router.post("", status_code=201, response_model=TicketAnswer, responses=KNOWN)
async def issue_ticket(request: Request, services: Provided, user: AnyCaller) -> dict[str, object]:
    """Create a ticket, which stands for the token of this request in one handshake of a WebSocket (`?ticket=`)."""
    ticket = await services.accounts.issue_ticket(user.id, used_token(request))
    return {"ticket": ticket, "expires_in": LIFETIME}
