"""Users: made, listed, changed and removed by administrators; everybody changes the own password."""

from fastapi import APIRouter, Request
from starlette.concurrency import run_in_threadpool

from endpoints.accounts import ME, token_id
from endpoints.auth import token_of
from endpoints.rest.dependencies import Admin, Caller, Paged, Provided, robots_in
from endpoints.rest.names import UserId
from endpoints.rest.openapi import ADMIN, BODY, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import NewUser, UserAnswer, UserChange
from endpoints.rest.strict_json import StrictRoute
from endpoints.services import Services
from ppaas.errors import Conflict, InvalidParameter, NotPermitted
from storage.records import User

router = APIRouter(prefix="/users", tags=["users"], route_class=StrictRoute)


@router.post("", status_code=201, response_model=UserAnswer, responses=ADMIN | BODY | problems(409))
async def create_user(new: NewUser, services: Provided, _admin: Admin) -> User:
    """Make a user."""
    return await services.accounts.register(new.id, new.password, new.role)


@router.get("", response_model=Page[UserAnswer], responses=ADMIN)
async def list_users(services: Provided, _admin: Admin, paging: Paged) -> dict[str, object]:
    """List all users by id."""
    found = await run_in_threadpool(services.store.users, after=paging.key(str, ""), limit=paging.most)
    return paging.page(found, lambda user: user.id)


@router.get("/{user_id}", response_model=UserAnswer, responses=ADMIN | problems(404))
async def show_user(user_id: UserId, services: Provided, user: Caller) -> User:
    """Show a user; an administrator may look at others too."""
    return await run_in_threadpool(services.store.user, _whom(user_id, user))


@router.patch("/{user_id}", response_model=UserAnswer, responses=ADMIN | BODY | problems(404, 409))
async def change_user(user_id: UserId, change: UserChange, request: Request, services: Provided, user: Caller) -> User:
    """Change a password or a role.

    Who changes the own password gives the old one; an administrator changes that of others, and their role. All
    tokens of the user end with the old password, but for the one that this request came with.
    """
    whom = _whom(user_id, user)
    await _check_may_change(services, user, whom, change)
    used = token_id(token_of(request))
    return await services.accounts.change(whom, role=change.role, password=change.password, keep_token=used)


@router.delete("/{user_id}", status_code=204, responses=ADMIN | problems(404, 409))
async def remove_user(user_id: UserId, services: Provided, admin: Admin) -> None:
    """Remove a user with all tokens and robots. One who owns maps or has a robot connected is kept."""
    if user_id in (admin.id, ME):
        raise Conflict("you cannot remove yourself: let another administrator do it")
    heads = await run_in_threadpool(services.map_store.maps)
    owned = [head.id for head in heads if head.owner == user_id]
    if owned:
        raise Conflict(f"the user {user_id!r} owns maps that others may use: remove them first: {', '.join(owned)}")
    connected = robots_in(services, user_id)
    if connected:
        raise Conflict(f"robots of {user_id!r} are connected: {', '.join(connected)}")
    await services.accounts.remove(user_id)


def _whom(user_id: str, caller: User) -> str:
    """Return who is meant; ``NotPermitted`` where it is another and the caller no administrator."""
    whom = caller.id if user_id == ME else user_id
    if whom != caller.id and caller.role != "admin":
        raise NotPermitted("only an administrator may see or change other users")
    return whom


async def _check_may_change(services: Services, caller: User, whom: str, change: UserChange) -> None:
    if change.role is not None and caller.role != "admin":
        raise NotPermitted("only an administrator gives roles")
    if change.role not in (None, caller.role) and whom == caller.id:
        raise Conflict("you cannot give up your own role: let another administrator do it")
    if change.password is not None and whom == caller.id:
        if change.old_password is None:
            raise InvalidParameter("old_password: give the password that you have now")
        await services.accounts.check_password(whom, change.old_password)
