"""Routes of the shares of a robot: with whom it is shared, and for what."""

from typing import Any, Self

from fastapi import APIRouter, Response
from pydantic import ConfigDict, Field, model_validator
from starlette.concurrency import run_in_threadpool

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Administered, Caller, Looked, Paged, Provided
from endpoints.rest.names import Grantee
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import RequestBody, ResponseBody, TopicGlobs
from endpoints.rest.strict_json import StrictRoute
from endpoints.sharing.named_users import check_grantee
from endpoints.sharing.shared_robots import ReachedRobot, changed_shares
from ppaas.errors import InvalidParameter, NotFound
from storage.sharing_records import ALL, Share, ShareRole

router = APIRouter(prefix="/robots/{robot_id}/shares", tags=["robots"], route_class=StrictRoute)

MAX_SHARES = 256
"""Largest number of users and groups with whom a robot is shared."""


class ShareFile(RequestBody):
    """Rights that a share of a robot gives."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"role": "drive", "publish": ["cmd_vel"]}]})

    role: ShareRole = Field(
        description="`look`: subscribe, and read its state; `drive`: also publish, call services and send goals; "
        "`administer`: also change, share and delete it, and connect as the robot"
    )
    publish: TopicGlobs | None = Field(
        default=None,
        description="Globs of topics to publish, services to call and actions to send goals to; default: all for "
        "`drive` and `administer`, none for `look`",
    )
    subscribe: TopicGlobs = Field(
        default=["*"], description="Globs of topics to subscribe to, and of services that only read"
    )

    @model_validator(mode="after")
    def _fits_the_role(self) -> Self:
        if self.role == "look" and self.publish:
            raise ValueError("role 'look' publishes nothing: leave out 'publish', or give the role 'drive'")
        if self.role == "administer" and (self.publish not in (None, ["*"]) or self.subscribe != ["*"]):
            raise ValueError("role 'administer' has all topics: leave out 'publish' and 'subscribe', or give 'drive'")
        return self

    def share_with(self, grantee: str) -> Share:
        """Return the share of a user or a group."""
        publish = () if self.role == "look" else ALL if self.publish is None else tuple(self.publish)
        return Share(grantee, self.role, publish, tuple(self.subscribe))


class ShareAnswer(ResponseBody):
    """Share of a robot with a user or a group."""

    to: str = Field(description="Id of a user, or `group:` and the name of a group")
    role: ShareRole
    publish: list[str]
    subscribe: list[str]


@router.get("", response_model=Page[ShareAnswer], responses=KNOWN | problems(403, 404))
async def list_shares(robot: Administered, paging: Paged) -> dict[str, Any]:
    """List with whom a robot is shared, and for what."""
    after = paging.key(str, "")
    shares = sorted((share for share in robot.record.shares if share.to > after), key=lambda share: share.to)
    return paging.page(shares, lambda share: share.to)


@router.put(
    "/{grantee}",
    response_model=ShareAnswer,
    responses={201: {"model": ShareAnswer, "description": "It was not shared with them"}}
    | KNOWN
    | BODY
    | problems(403, 404, 409),
)
async def share_robot(
    robot: Administered, grantee: Grantee, file: ShareFile, services: Provided, _user: Caller, response: Response
) -> Share:
    """Share a robot with a user or a group, or change what it is shared for. Their open sockets follow at once.

    Both must exist: a share with a misspelled name would be used by the next user of that name.
    """
    if grantee == robot.user:
        raise InvalidParameter(f"robot {robot.id!r} belongs to {grantee!r}: share it with others")
    if all(one.to != grantee for one in robot.record.shares):
        await run_in_threadpool(check_grantee, services.store, grantee)
    share = file.share_with(grantee)

    def added(shares: tuple[Share, ...]) -> tuple[Share, ...]:
        others = tuple(one for one in shares if one.to != grantee)
        if len(others) >= MAX_SHARES:
            raise InvalidParameter(f"a robot is shared with at most {MAX_SHARES}: share it with a group")
        response.status_code = 201 if len(others) == len(shares) else 200
        return *others, share

    await run_in_threadpool(changed_shares, services.store, robot.record, added)
    services.shares.forget_robot(robot.user, robot.id)
    return share


@router.delete("/{grantee}", status_code=204, responses=KNOWN | problems(403, 404, 409))
async def unshare_robot(robot: Looked, grantee: Grantee, services: Provided, user: Caller) -> None:
    """Share a robot no more with a user or a group, whose sockets are closed. Users may end their own shares."""
    if grantee != user.id:
        robot.access.check_role("administer")
    await _unshare(services, robot, grantee)


async def _unshare(services: Services, robot: ReachedRobot, grantee: str) -> None:
    def removed(shares: tuple[Share, ...]) -> tuple[Share, ...]:
        others = tuple(one for one in shares if one.to != grantee)
        if len(others) == len(shares):
            raise NotFound("share with", grantee)
        return others

    await run_in_threadpool(changed_shares, services.store, robot.record, removed)
    services.shares.forget_robot(robot.user, robot.id)
