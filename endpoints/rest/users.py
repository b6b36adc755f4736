"""Users: made, listed and removed by administrators."""

from fastapi import APIRouter
from starlette.concurrency import run_in_threadpool

from endpoints.rest.dependencies import Admin, Caller, Provided, robots_in
from endpoints.rest.schemas import NewUser, UserAnswer
from ppaas.errors import Conflict
from storage.records import User

router = APIRouter(prefix="/users", tags=["users"])


@router.post("", status_code=201, response_model=UserAnswer)
async def create_user(new: NewUser, services: Provided, _admin: Admin) -> User:
    """Make a user."""
    return await services.accounts.register(new.id, new.password, new.role)


@router.get("", response_model=list[UserAnswer])
async def list_users(services: Provided, _admin: Admin) -> list[User]:
    """List all users by id."""
    return await run_in_threadpool(services.store.users)


@router.get("/me", response_model=UserAnswer)
async def show_me(user: Caller) -> User:
    """Tell whose token this is."""
    return user


@router.delete("/{user_id}", status_code=204)
async def remove_user(user_id: str, services: Provided, admin: Admin) -> None:
    """Remove a user with all tokens and robots. One who owns maps or has a robot connected is kept."""
    if user_id == admin.id:
        raise Conflict("you cannot remove yourself: let another administrator do it")
    heads = await run_in_threadpool(services.map_store.maps)
    owned = [head.id for head in heads if head.owner == user_id]
    if owned:
        raise Conflict(f"the user {user_id!r} owns maps that others may use: remove them first: {', '.join(owned)}")
    connected = robots_in(services, user_id)
    if connected:
        raise Conflict(f"robots of {user_id!r} are connected: {', '.join(connected)}")
    await services.accounts.remove(user_id)
