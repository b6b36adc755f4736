"""Versions of maps that wait for a review: proposed, listed, approved and refused over REST."""

from typing import Any

import httpx
import pytest

from endpoints.audit.event import AuditQuery
from endpoints.resources.services import Services
from tests.support.endpoints.problems import problem_of
from tests.support.storage.records import pgm
from tests.unit.endpoints.conftest import LogIn, Publish

REVIEWS = "/v1/maps/house/reviews"


@pytest.fixture
async def ann(log_in: LogIn, publish: Publish) -> dict[str, str]:
    """Publish ann's map of 4 × 3 free cells, which bob may read by name and everybody by '*'."""
    headers = await log_in("ann")
    await publish(headers, readers="bob,*")
    return headers


@pytest.fixture
async def waiting(ann: dict[str, str], log_in: LogIn, publish: Publish) -> dict[str, Any]:
    """Return bob's proposal, in which two cells are occupied and one is unknown."""
    pixels = bytearray(pgm())
    pixels[-3:] = bytes([0, 0, 205])
    answer = await publish(await log_in("bob"), image=bytes(pixels), review="true", message="a new wall")
    assert answer.status_code == 202, answer.text
    review: dict[str, Any] = answer.json()
    return review


async def test_a_version_published_with_review_waits_with_counts_of_its_changes(
    client: httpx.AsyncClient, ann: dict[str, str], waiting: dict[str, Any]
) -> None:
    current = (await client.get("/v1/maps/house", headers=ann)).json()
    assert (waiting["author"], waiting["message"], waiting["state"]) == ("bob", "a new wall", "waiting")
    assert (waiting["base"], waiting["outdated"]) == (current["version"], False)
    assert [waiting[kind] for kind in ("occupied", "free", "known", "unknown")] == [2, 0, 0, 1]
    assert waiting["rectangles"] == [{"column": 1, "row": 0, "width": 3, "height": 1}]
    listed = (await client.get(REVIEWS, headers=ann)).json()
    assert listed == {"items": [waiting], "next": None}
    assert (await client.get(f"{REVIEWS}/{waiting['number']}", headers=ann)).json() == waiting
    image = await client.get(f"/v1/maps/house/versions/{waiting['version']}/image", headers=ann)
    assert image.content.endswith(bytes([0, 0, 205]))


async def test_the_owner_approves_a_version(
    client: httpx.AsyncClient, ann: dict[str, str], waiting: dict[str, Any], services: Services
) -> None:
    approve = f"{REVIEWS}/{waiting['number']}/approve"
    head = (await client.post(approve, headers=ann, json={"why": "seen it"})).json()
    assert (head["version"], head["author"], head["owner"]) == (waiting["version"], "bob", "ann")
    (review,) = (await client.get(REVIEWS, headers=ann)).json()["items"]
    assert (review["state"], review["closed_by"], review["reason"]) == ("approved", "ann", "seen it")
    events = services.audit.read(AuditQuery(action="approve_review"))
    assert [(event.user, event.details["before"]) for event in events] == [("ann", waiting["base"])]


async def test_the_owner_refuses_a_version_with_a_reason(
    client: httpx.AsyncClient, ann: dict[str, str], waiting: dict[str, Any]
) -> None:
    refuse = f"{REVIEWS}/{waiting['number']}/refuse"
    problem_of(await client.post(refuse, headers=ann, json={"why": ""}), 422, "invalid-request")
    review = (await client.post(refuse, headers=ann, json={"why": "it was a person"})).json()
    assert (review["state"], review["reason"], review["parts"]) == ("refused", "it was a person", [])
    gone = await client.get(f"/v1/maps/house/versions/{waiting['version']}/image", headers=ann)
    problem_of(gone, 404, "not-found")
    problem_of(await client.post(f"{REVIEWS}/{waiting['number']}/approve", headers=ann, json={}), 409, "conflict")


async def test_a_version_made_from_another_than_the_current_one_is_approved_by_force_with_a_reason(
    client: httpx.AsyncClient, ann: dict[str, str], waiting: dict[str, Any], publish: Publish
) -> None:
    await publish(ann, image=pgm(value=205))
    approve = f"{REVIEWS}/{waiting['number']}/approve"
    assert (await client.get(REVIEWS, headers=ann)).json()["items"][0]["outdated"]
    problem_of(await client.post(approve, headers=ann, json={}), 409, "conflict")
    problem_of(await client.post(approve, headers=ann, json={"force": True}), 422, "invalid-parameter")
    problem_of(await client.post(approve, headers=ann, json={"force": 1, "why": "x"}), 422, "invalid-request")
    forced = await client.post(approve, headers=ann, json={"force": True, "why": "the other one was a mistake"})
    assert forced.json()["version"] == waiting["version"]


async def test_others_neither_propose_nor_decide(
    client: httpx.AsyncClient, ann: dict[str, str], waiting: dict[str, Any], log_in: LogIn, publish: Publish
) -> None:
    bob, eve = await log_in("bob"), await log_in("eve")
    for path, body in (("approve", {}), ("refuse", {"why": "no"})):
        answer = await client.post(f"{REVIEWS}/{waiting['number']}/{path}", headers=bob, json=body)
        problem_of(answer, 403, "not-permitted")
    problem_of(await publish(eve, image=pgm(value=7), review="true"), 403, "not-permitted")
    await client.patch("/v1/maps/house", headers=ann, json={"readers": []})
    for answer in (await publish(bob, image=pgm(value=7), review="true"), await client.get(REVIEWS, headers=bob)):
        problem_of(answer, 404, "not-found")


async def test_a_review_needs_a_map_other_files_and_a_valid_number(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    problem_of(await publish(ann, review="true"), 404, "not-found")
    await publish(ann)
    problem_of(await publish(ann, review="true"), 409, "conflict")
    problem_of(await publish(ann, review="perhaps"), 422, "invalid-parameter")
    problem_of(await client.get(f"{REVIEWS}/7", headers=ann), 404, "not-found")
    problem_of(await client.get(f"{REVIEWS}/0", headers=ann), 422, "invalid-request")


async def test_files_that_wait_count_for_the_owner(
    ann: dict[str, str], waiting: dict[str, Any], services: Services, client: httpx.AsyncClient
) -> None:
    used = services.usage.stored.of_user(services.store, services.map_store, "ann")
    await client.post(f"{REVIEWS}/{waiting['number']}/refuse", headers=ann, json={"why": "no"})
    assert services.usage.stored.of_user(services.store, services.map_store, "ann") == used - len(pgm())
