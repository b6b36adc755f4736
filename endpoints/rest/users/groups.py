"""Routes of groups of users: administrators choose the members; robots are shared with groups."""

from collections import defaultdict
from contextlib import suppress
from functools import partial

from fastapi import APIRouter, Response
from pydantic import Field
from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Admin, Caller, Paged, Provided
from endpoints.rest.names import GroupId, Name
from endpoints.rest.openapi import ADMIN, BODY, KNOWN, Responses, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import RequestBody, ResponseBody
from endpoints.rest.strict_json import StrictRoute
from endpoints.rest.users.schemas import MAX_GROUPS, distinct
from endpoints.sharing.named_users import check_users
from endpoints.sharing.shared_robots import end_shares
from ppaas.errors import InvalidParameter, NotFound
from storage.sharing_records import GROUP

router = APIRouter(prefix="/groups", tags=["groups"], route_class=StrictRoute)

MAX_MEMBERS = 1000
"""Largest number of members that one request gives a group."""


class GroupFile(RequestBody):
    """Members of a group."""

    members: list[Name] = Field(max_length=MAX_MEMBERS, examples=[["ann", "bob"]])


class GroupAnswer(ResponseBody):
    """Group of users."""

    id: str
    members: list[str] = Field(description="Ids of the users, sorted")


_NEW: Responses = {201: {"model": GroupAnswer, "description": "The group is new"}}


@router.get("", response_model=Page[GroupAnswer], responses=ADMIN)
async def list_groups(services: Provided, _admin: Admin, paging: Paged) -> dict[str, object]:
    """List all groups by id, with their members."""
    groups = await run_in_threadpool(_groups, services)
    after = paging.key(str, "")
    found = [GroupAnswer(id=name, members=groups[name]) for name in sorted(groups) if name > after]
    return paging.page(found, lambda group: group.id)


@router.get("/{group_id}", response_model=GroupAnswer, responses=KNOWN | problems(404))
async def show_group(group_id: GroupId, services: Provided, user: Caller) -> GroupAnswer:
    """Show the members of a group, to administrators and to its members."""
    if user.role != "admin" and group_id not in user.groups:
        raise NotFound("group", group_id)
    return GroupAnswer(id=group_id, members=await run_in_threadpool(_members, services, group_id))


@router.put("/{group_id}", response_model=GroupAnswer, responses=_NEW | ADMIN | BODY | problems(404))
async def put_group(
    group_id: GroupId, file: GroupFile, services: Provided, _admin: Admin, response: Response
) -> GroupAnswer:
    """Choose the members of a group, which is new if nobody was in it. Rights and open sockets follow at once."""
    if not file.members:
        raise InvalidParameter(f"a group has at least one member: to remove {group_id!r}, delete it")
    groups = await run_in_threadpool(_groups, services)
    members, before = distinct(file.members), set(groups.get(group_id, ()))
    joining = await run_in_threadpool(check_users, services.store, sorted(set(members) - before))
    for user in joining:  # raises before any of them is changed
        _joined(user.groups, user.id, group_id)
    for member in sorted(set(members) - before):
        await services.accounts.change(member, regroup=partial(_joined, user=member, group=group_id))
    await _leave(services, group_id, before - set(members))
    response.status_code = 200 if before else 201
    return GroupAnswer(id=group_id, members=list(members))


@router.delete("/{group_id}", status_code=204, responses=ADMIN | problems(404))
async def remove_group(group_id: GroupId, services: Provided, _admin: Admin) -> None:
    """Remove a group; robots are not shared with it any more."""
    members = await run_in_threadpool(_members, services, group_id)
    for robot in await run_in_threadpool(end_shares, services.store, GROUP + group_id):
        services.shares.forget_robot(robot.user, robot.id)
    await _leave(services, group_id, set(members))


def _joined(known: tuple[str, ...], user: str, group: str) -> tuple[str, ...]:
    """Return the groups of a user who joins one; ``InvalidParameter`` if these are too many."""
    groups = distinct([*known, group])
    if len(groups) > MAX_GROUPS:
        raise InvalidParameter(f"user {user!r} is in {MAX_GROUPS} groups, the largest number")
    return groups


async def _leave(services: Services, group: str, members: set[str]) -> None:
    for member in sorted(members):
        with suppress(NotFound):  # removed meanwhile
            await services.accounts.change(member, regroup=lambda known: tuple(one for one in known if one != group))


def _groups(services: Services) -> dict[str, list[str]]:
    found: defaultdict[str, list[str]] = defaultdict(list)
    for user in services.store.users():
        for group in () if user.leaving else user.groups:
            found[group].append(user.id)
    return found


def _members(services: Services, group: str) -> list[str]:
    members = _groups(services).get(group)
    if members is None:
        raise NotFound("group", group)
    return members
