"""Routes of plans over the floors of a building, and of the times from each of many starts to each of many goals."""

import logging
import math
from functools import partial
from typing import Any

import numpy as np
from fastapi import APIRouter
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.responses import JSONResponse, Response

from endpoints.resources.services import Services
from endpoints.rest.buildings.access import layout_for, readable_building
from endpoints.rest.buildings.plan_schemas import (
    BuildingCostAnswer,
    BuildingCostFile,
    BuildingPlanAnswer,
    BuildingPlanFile,
    FloorPlace,
)
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import BuildingAddress
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.plans.planning import check_timeout, plan_record
from endpoints.rest.plans.representations import short
from endpoints.rest.strict_json import StrictRoute
from engine.control.planning.building_requests import BuildingRoute, BuildingScene, BuildingSpot, FloorPath
from engine.control.planning.buildings import BuildingPlanning
from engine.specs.containers import MapVersion
from ppaas.buildings.planning.legs import Leg
from ppaas.buildings.planning.sessions import Session
from ppaas.buildings.planning.times import Traveller
from ppaas.errors import InvalidBuilding, NotFound, PPaaSError
from ppaas.plans.path_service import DEFAULT_TIMEOUT
from storage.buildings.records import BuildingRecord
from storage.records import User

logger = logging.getLogger(__name__)

router = APIRouter(prefix="/buildings/{building_id}", tags=["buildings"], route_class=StrictRoute)

DECIMALS = 3
"""Decimals of metres and seconds."""


@router.post("/plans", response_model=BuildingPlanAnswer, responses=KNOWN | BODY | problems(404, 409, 429))
async def plan_in_building(
    building_id: BuildingAddress, file: BuildingPlanFile, services: Provided, user: Caller
) -> Response:
    """Plan from a place on a floor to a place on any floor, by lifts, ways and doors; the paths are stored.

    A container plans on each floor that is driven on; lengths on the others are computed once per map version.
    """
    scene, version = await _scene(services, user, building_id, file)
    session = None if file.session is None else Session(**file.session.model_dump())
    planning = BuildingPlanning(services.cloud.planning, services.floor_lengths)
    routes = await planning.plan(
        user.id, scene, _spot(file.start), _spot(file.goal), count=1 + file.alternatives, session=session
    )
    paths = [path for path in routes[0].paths if path is not None]
    stored = services.plan_writer.accepts
    shown = [_route(route, stored=stored) for route in routes]
    answer = {**shown[0], "building": version, "alternatives": shown[1:]}
    return JSONResponse(answer, background=BackgroundTask(_store, services, user, paths) if stored else None)


@router.post("/costs", response_model=BuildingCostAnswer, responses=KNOWN | BODY | problems(404, 409, 429))
async def compute_building_costs(
    building_id: BuildingAddress, file: BuildingCostFile, services: Provided, user: Caller
) -> dict[str, Any]:
    """Return the time from each start to each goal, on any floors, by lifts, ways and doors."""
    scene, version = await _scene(services, user, building_id, file)
    planning = BuildingPlanning(services.cloud.planning, services.floor_lengths)
    starts, goals = ([_spot(place) for place in places] for places in (file.starts, file.goals))
    seconds = await planning.costs(user.id, scene, starts, goals)
    rows = [[each if math.isfinite(each) else None for each in row] for row in seconds.round(DECIMALS).tolist()]
    return {"seconds": rows, "building": version}


async def _scene(
    services: Services, user: User, address: str, file: BuildingPlanFile | BuildingCostFile
) -> tuple[BuildingScene, int]:
    """Return what a request plans on, and the version of the building."""
    timeout = DEFAULT_TIMEOUT if file.timeout is None else file.timeout
    check_timeout(timeout, services.limits)
    record = await run_in_threadpool(readable_building, services.store, user, address)
    await services.cloud.count_paths(user.id, 1)
    layout = await run_in_threadpool(layout_for, services, user, record.building)
    maps = dict[str, MapVersion]()
    for floor in record.building.floors:
        try:
            head = await readable_head(services, user, floor.map)
        except NotFound:
            continue
        maps[floor.name] = MapVersion(head.id, head.version)
    known = {(door.floor, door.door) for door in layout.doors}
    closed = frozenset((door.floor, door.door) for door in file.closed)
    for floor_name, door in sorted(closed - known):
        raise InvalidBuilding(f"floor {floor_name!r} has no door {door!r}")
    robot = file.robot
    traveller = Traveller(robot.speed, robot.labels, robot.stairs, frozenset(file.avoid))
    reuse = file.reuse if isinstance(file, BuildingPlanFile) else True
    scene = BuildingScene(
        layout, maps, traveller, closed, file.parameters, file.labels, timeout, reuse, await _waits(services, record)
    )
    return scene, record.present.number


async def _waits(services: Services, record: BuildingRecord) -> dict[tuple[str, str], float]:
    """Return the waits for lifts that the master expects now; none if it does not say, and means are taken."""
    if services.journeys is None:
        return {}
    try:
        found = await services.journeys.lift_waits(*record.key)
    except PPaaSError as error:
        logger.info("a plan in building %s takes the mean waits for lifts: %s", record.id, error)
        return {}
    return {(wait.lift, wait.floor): wait.seconds for wait in found}


def _spot(place: FloorPlace) -> BuildingSpot:
    return BuildingSpot(place.floor, place.x, place.y, place.yaw)


def _route(route: BuildingRoute, *, stored: bool) -> dict[str, Any]:
    paths = route.paths or [None] * len(route.legs)
    return {
        "seconds": round(route.seconds, DECIMALS),
        "length": round(sum(leg.length for leg in route.legs), DECIMALS),
        "takes": list(route.names),
        "legs": [_leg(leg, path, stored=stored) for leg, path in zip(route.legs, paths, strict=True)],
    }


def _leg(leg: Leg, path: FloorPath | None, *, stored: bool) -> dict[str, Any]:
    answer = {
        "kind": leg.kind, "name": leg.name, "floor": leg.floor, "to_floor": leg.to_floor,
        "start": np.round(leg.start, 6).tolist(), "goal": np.round(leg.goal, 6).tolist(),
        "length": round(leg.length, DECIMALS), "seconds": round(leg.seconds, DECIMALS),
        "map": "", "version": "", "plan_id": "", "poses": [],
    }  # fmt: skip
    if path is None:
        return answer
    found = path.answer
    is_kept = stored or found.plan_id == found.reused
    return answer | {
        "map": found.map, "version": found.version, "plan_id": found.plan_id if is_kept else "",
        "poses": short(path.poses).round(6).tolist(),
    }  # fmt: skip


async def _store(services: Services, user: User, paths: list[FloorPath]) -> None:
    """Store the paths that are not stored already."""
    for path in paths:
        if path.answer.plan_id != path.answer.reused:
            record = partial(plan_record, user, path.request, path.answer, path.poses)
            await services.plan_writer.write(services.store, record)
