"""Routes of users: administrators create, list, change, limit and remove them; users change their own password."""

from typing import Annotated

from fastapi import APIRouter, Body, Query, Request
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.accounts import ME, Regroup
from endpoints.accounts.authentication import address_of
from endpoints.accounts.usage import owned_maps, robot_count
from endpoints.audit.requests import note_object
from endpoints.resources import removal
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Admin, Caller, Paged, Provided, used_token
from endpoints.rest.names import UserId
from endpoints.rest.openapi import ADMIN, BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute
from endpoints.rest.users.schemas import (
    IdentityAnswer,
    LimitsAnswer,
    NewUser,
    QuotaAnswer,
    UserAnswer,
    UserChange,
    UserDetail,
    distinct,
)
from engine.control.views import UserUsage
from engine.master.quotas import QUOTAS
from ppaas.errors import Conflict, InvalidParameter, NotAuthenticated, NotPermitted
from storage.records import User
from storage.sharing_records import ProvidedIdentity

router = APIRouter(prefix="/users", tags=["users"], route_class=StrictRoute)


@router.post("", status_code=201, response_model=UserAnswer, responses=ADMIN | BODY | problems(409))
async def create_user(new: NewUser, request: Request, services: Provided, _admin: Admin) -> User:
    """Create a user."""
    note_object(request.scope, f"users/{new.id}")
    await removal.make_user_free(services, new.id)
    return await services.accounts.register(new.id, new.password, new.role, groups=distinct(new.groups))


@router.get("", response_model=Page[UserAnswer], responses=ADMIN)
async def list_users(services: Provided, _admin: Admin, paging: Paged) -> dict[str, object]:
    """List all users by id."""
    found = await run_in_threadpool(services.store.users, after=paging.key(str, ""), limit=paging.fetch_limit)
    return paging.page(found, lambda user: user.id)


@router.get("/{user_id}", response_model=UserDetail, responses=ADMIN | problems(404))
async def show_user(user_id: UserId, services: Provided, user: Caller) -> UserDetail:
    """Show a user with limits, quota and usage; administrators may show other users too."""
    found = await run_in_threadpool(services.store.user, _target_user(user_id, user))
    await services.cloud.set_limits(found.id, found.limits)
    return await _detail(services, found)


@router.patch("/{user_id}", response_model=UserDetail, responses=ADMIN | BODY | problems(404, 409, 429))
async def change_user(
    user_id: UserId,
    change: Annotated[UserChange, Body(media_type=MERGE_PATCH)],
    request: Request,
    services: Provided,
    user: Caller,
) -> UserDetail:
    """Change a password, a role, or the limits of a user.

    To change your own password, give the current one. Administrators change the passwords and roles of others, and the
    limits and groups of all. With a new password all tokens of the user are revoked except the token of this request.
    A user who has more than a new limit allows keeps it, but gets no more.
    """
    target = _target_user(user_id, user)
    await _check_may_change(services, user, target, change, address_of(request))
    used = used_token(request)
    if "groups" in change.model_fields_set:
        await removal.end_groups(services, target, distinct(change.groups or []))
    changed = await services.accounts.change(
        target,
        role=change.role,
        password=change.password,
        keep_token=used,
        limits=_limits(change),
        regroup=_regroup(change),
    )
    if "identity" in change.model_fields_set:
        changed = await services.accounts.identities.link(target, _identity(change))
    if "rapyuta_password" in change.model_fields_set:
        changed = await services.accounts.rapyuta.set(target, change.rapyuta_password)
    await services.cloud.set_limits(changed.id, changed.limits)
    return await _detail(services, changed)


@router.delete("/{user_id}/sessions", status_code=204, responses=KNOWN | problems(403, 404))
async def end_sessions(user_id: UserId, services: Provided, user: Caller) -> None:
    """Log a user out everywhere: revoke all tokens and disconnect all robots. Administrators may do it for others."""
    target = _target_user(user_id, user)
    await services.accounts.revoke_all(target)
    ended = NotAuthenticated("all sessions of this user were ended: log in again")
    await services.cloud.users.end_places(target, ended)


@router.delete("/{user_id}", status_code=204, responses=ADMIN | problems(404, 409))
async def remove_user(
    user_id: UserId,
    services: Provided,
    admin: Admin,
    force: Annotated[bool, Query(description="also disconnect the robots of the user")] = False,
) -> None:
    """Remove a user with all tokens and robots; refused (409) if the user owns maps or has a connected robot.

    With `force`, connected robots are disconnected first. Maps that the user may read, robots that are shared with the
    user, and groups of which the user is the only member end too: a later user of the same id gets nothing of them.
    A removal that is interrupted is finished later; until then the id is taken.
    """
    if user_id in (admin.id, ME):
        raise Conflict("you cannot remove yourself: ask another administrator")
    owned = await run_in_threadpool(owned_maps, services.map_store, user_id)
    if owned:
        raise Conflict(f"user {user_id!r} owns maps; remove them first: {', '.join(owned)}")
    connected = [one.robot for one in await services.cloud.containers.views(user_id) if one.connected and one.robot]
    if connected and not force:
        raise Conflict(
            f"user {user_id!r} has connected robots; disconnect them first, or force the removal: "
            f"{', '.join(connected)}"
        )
    await removal.remove_user(services, user_id)


async def _detail(services: Services, user: User) -> UserDetail:
    runs = await services.cloud.users.usage(user.id)
    used = await run_in_threadpool(_used, services, user, runs)
    return UserDetail(
        id=user.id,
        role=user.role,
        groups=list(user.groups),
        limits=LimitsAnswer.model_validate(user.limits),
        identity=None if user.identity is None else IdentityAnswer.model_validate(user.identity),
        rapyuta=bool(user.rapyuta_hash),
        quota=QuotaAnswer.model_validate(services.cloud.quotas.of(user.id)),
        used=used,
    )


def _used(services: Services, user: User, runs: UserUsage) -> QuotaAnswer:
    maps = services.usage.stored.maps_of(services.map_store, user.id)
    return QuotaAnswer(
        containers=runs.containers,
        cores=runs.cores,
        robots=robot_count(services.store, user.id),
        maps=len(maps),
        plans_per_minute=runs.paths,
        stored_bytes=services.usage.stored.of_user(services.store, services.map_store, user.id),
        versions_per_map=max((len(one.versions) for one in maps), default=0),
    )


def _limits(change: UserChange) -> dict[str, float | None]:
    """Return the limits to change, by name; all of them if ``limits`` is null."""
    if change.limits is not None:
        return change.limits.model_dump(exclude_unset=True)
    return dict.fromkeys(QUOTAS) if "limits" in change.model_fields_set else {}


def _identity(change: UserChange) -> ProvidedIdentity | None:
    given = change.identity
    return None if given is None else ProvidedIdentity(given.issuer, given.subject)


def _regroup(change: UserChange) -> Regroup | None:
    """Return a function that returns the new groups; None if they stay."""
    if "groups" not in change.model_fields_set:
        return None
    return lambda _: distinct(change.groups or [])


def _target_user(user_id: str, caller: User) -> str:
    """Return the id of the user in a path; ``NotPermitted`` if it is another user and the caller is no admin."""
    target = caller.id if user_id == ME else user_id
    if target != caller.id and caller.role != "admin":
        raise NotPermitted("only an administrator may see or change other users")
    return target


async def _check_may_change(services: Services, caller: User, target: str, change: UserChange, address: str) -> None:
    if change.role is not None and caller.role != "admin":
        raise NotPermitted("only an administrator may change roles")
    if "limits" in change.model_fields_set and caller.role != "admin":
        raise NotPermitted("only an administrator may change limits")
    if "rapyuta_password" in change.model_fields_set and caller.role != "admin":
        raise NotPermitted("only an administrator may set or remove the password for robots of Rapyuta")
    if "identity" in change.model_fields_set and caller.role != "admin":
        raise NotPermitted("only an administrator may link a user to an identity")
    if "groups" in change.model_fields_set and caller.role != "admin":
        raise NotPermitted("only an administrator may change groups")
    if change.role not in (None, caller.role) and target == caller.id:
        raise Conflict("you cannot change your own role: ask another administrator")
    if change.password is not None and target == caller.id:
        if change.old_password is None:
            raise InvalidParameter("old_password is required to change your own password: give the current password")
        await services.accounts.check_password(target, change.old_password, address)
