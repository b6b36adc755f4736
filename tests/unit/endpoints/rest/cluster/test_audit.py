"""The audit log over REST."""

import httpx
import pytest

from endpoints.audit.event import AuditEvent
from endpoints.resources.services import Services
from tests.unit.endpoints.conftest import LogIn


@pytest.fixture
def recorded(services: Services) -> None:
    """Record an event of ann each second, put and remove in turn; every third is refused."""
    for number in range(30):
        services.audit.record(
            AuditEvent(
                time=float(number),
                user="ann",
                token="0123456789ab",
                address="10.0.0.1",
                action=("put_robot", "remove_robot")[number % 2],
                object=f"robots/{number}",
                outcome="refused" if number % 3 == 2 else "ok",
                reason="conflict" if number % 3 == 2 else None,
            )
        )


@pytest.mark.usefixtures("recorded")
async def test_an_administrator_reads_events_newest_first_page_by_page(
    client: httpx.AsyncClient, log_in: LogIn
) -> None:
    admin, found, cursor = await log_in("admin"), list[str](), ""
    while cursor is not None:
        page = (await client.get(f"/v1/audit?limit=7&user=ann{cursor}", headers=admin)).json()
        found += [event["object"] for event in page["items"]]
        cursor = page["next"] and f"&cursor={page['next']}"
    assert found == [f"robots/{number}" for number in reversed(range(30))]


@pytest.mark.usefixtures("recorded")
@pytest.mark.parametrize(
    ("query", "numbers"),
    [
        ("action=remove_robot&after=25", [29, 27, 25]),
        ("outcome=refused&after=20", [29, 26, 23, 20]),
        ("user=bob", []),
        ("object=robots/7", [7]),
        ("object=robots&after=28", [29, 28]),
        ("after=1e12", []),
    ],
)
async def test_events_are_found_by_user_action_outcome_and_time(
    client: httpx.AsyncClient, log_in: LogIn, query: str, numbers: list[int]
) -> None:
    page = (await client.get(f"/v1/audit?{query}", headers=await log_in("admin"))).json()
    assert [event["object"] for event in page["items"] if event["user"] == "ann"] == [f"robots/{n}" for n in numbers]


@pytest.mark.usefixtures("recorded")
async def test_every_member_of_an_event_is_shown(client: httpx.AsyncClient, log_in: LogIn) -> None:
    page = (await client.get("/v1/audit?limit=1&outcome=refused", headers=await log_in("admin"))).json()
    assert page["items"][0] == {
        "number": 30,
        "time": 29.0,
        "user": "ann",
        "token": "0123456789ab",
        "address": "10.0.0.1",
        "action": "remove_robot",
        "object": "robots/29",
        "outcome": "refused",
        "status": None,
        "reason": "conflict",
        "details": {},
        "repeats": 0,
    }


async def test_other_users_may_not_read_it(client: httpx.AsyncClient, log_in: LogIn) -> None:
    assert (await client.get("/v1/audit", headers=await log_in("ann"))).status_code == 403
    assert (await client.get("/v1/audit")).status_code == 401


@pytest.mark.parametrize("query", ["after=soon", "after=nan", "outcome=maybe", "users=ann", "cursor=%21"])
async def test_an_invalid_query_is_a_problem(client: httpx.AsyncClient, log_in: LogIn, query: str) -> None:
    answer = await client.get(f"/v1/audit?{query}", headers=await log_in("admin"))
    assert answer.status_code == 422
