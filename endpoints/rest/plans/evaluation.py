"""Evaluation of planners on a map, from the history of path requests."""

from typing import Annotated, Any

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field
from starlette.concurrency import run_in_threadpool

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId, Version
from endpoints.rest.openapi import KNOWN, problems
from ppaas.plans.history import as_json, evaluate

router = APIRouter(prefix="/maps/{map_id}", tags=["maps"])


class PerformanceAnswer(BaseModel):
    """Outcome of path requests."""

    queries: int = Field(description="Number of requests")
    success: float | None = Field(description="Fraction that got a path")
    computed: int = Field(description="Number of computed paths")
    reused: int = Field(description="Number of stored paths returned unchanged")
    stitched: int = Field(description="Number of stored paths stitched to start and goal")
    reuse_rate: float | None = Field(description="Fraction of the paths that was not computed")
    seconds: float | None = Field(description="Mean time to compute a path [s]")
    typical_seconds: float | None = Field(description="Geometric mean of the computing times [s]")
    spread: float | None = Field(description="Geometric standard deviation of the computing times, a factor")
    compared: int = Field(description="Number of paths compared with the cheapest path from cell to cell")
    over_cheapest: float | None = Field(
        description="Fraction by which they were longer than the cheapest; negative if a path is not bound to cells"
    )


class ComplexityAnswer(PerformanceAnswer):
    """Outcome of path requests by the distance between start and goal."""

    cells: Annotated[
        list[float], Field(min_length=2, max_length=2, description="Range of distances, lower bound included")
    ]


class EvaluatedPlanner(PerformanceAnswer):
    """Evaluation of one planner."""

    planner: str
    complexities: list[ComplexityAnswer] = Field(description="Outcome by distance between start and goal [cells]")


class LinkAnswer(BaseModel):
    """Recent speed of loading stored paths over one link to the store."""

    link: str = Field(description="Machine at the near end of the link")
    round_trip: float = Field(description="Time until an answer without a path arrives [s]")
    bandwidth: float = Field(description="Transfer rate of paths [bytes/s]")
    answers: int = Field(description="Number of measured answers")
    measured: float = Field(description="Time of the last measurement [s since the epoch]")


class EvaluationAnswer(BaseModel):
    """Evaluation of the planners used on a map."""

    map: str
    version: str | None = Field(description="Evaluated map version; null for all versions")
    planners: list[EvaluatedPlanner] = Field(description="Planners that were used, by name")
    links: list[LinkAnswer]


OneVersion = Annotated[Version | None, Query(description="Evaluate only requests on this map version")]


@router.get("/evaluation", response_model=EvaluationAnswer, responses=KNOWN | problems(404))
async def evaluate_planners(
    map_id: MapId, services: Provided, user: Caller, version: OneVersion = None
) -> dict[str, Any]:
    """Return how planners performed on a map: success, computing time, and reuse of stored paths."""
    await readable_head(services, user, map_id)
    rows = await run_in_threadpool(services.store.history, map_id, version)
    links = await run_in_threadpool(services.store.links)
    return {
        "map": map_id,
        "version": version,
        "planners": [as_json(each) for each in evaluate(rows)],
        "links": [{name: getattr(link, name) for name in link.__struct_fields__} for link in links],
    }
