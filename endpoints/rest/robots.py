"""Robots of the caller."""

from fastapi import APIRouter
from starlette.concurrency import run_in_threadpool

from endpoints.rest.dependencies import Caller, Provided, readable_head, robots_in
from endpoints.rest.schemas import RobotAnswer, RobotFile, triple
from ppaas.errors import Conflict
from storage.records import RobotRecord

router = APIRouter(prefix="/robots", tags=["robots"])


@router.put("/{robot_id}", response_model=RobotAnswer)
async def put_robot(robot_id: str, file: RobotFile, services: Provided, user: Caller) -> RobotRecord:
    """Keep a robot or change it; one that is connected takes the change up when it connects again."""
    await readable_head(services, user, file.map)
    fields = file.model_dump() | {"initial_pose": triple(file.initial_pose)}
    record = RobotRecord(id=robot_id, user=user.id, **fields)
    await run_in_threadpool(services.store.put_robot, record)
    return record


@router.get("", response_model=list[RobotAnswer])
async def list_robots(services: Provided, user: Caller) -> list[RobotRecord]:
    """List the caller's robots by id."""
    return await run_in_threadpool(services.store.robots, user.id)


@router.get("/{robot_id}", response_model=RobotAnswer)
async def show_robot(robot_id: str, services: Provided, user: Caller) -> RobotRecord:
    """Describe a robot of the caller."""
    return await run_in_threadpool(services.store.robot, user.id, robot_id)


@router.delete("/{robot_id}", status_code=204)
async def remove_robot(robot_id: str, services: Provided, user: Caller) -> None:
    """Forget a robot and what its clone had learned; one that is connected is kept."""
    if robot_id in robots_in(services, user.id):
        raise Conflict(f"robot {robot_id!r} is connected: let it disconnect first")
    await run_in_threadpool(services.store.remove_robot, user.id, robot_id)
