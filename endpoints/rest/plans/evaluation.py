"""How planners did on a map: from the history of planning."""

from typing import Annotated, Any

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field
from starlette.concurrency import run_in_threadpool

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId, Version
from endpoints.rest.openapi import KNOWN, problems
from ppaas.plans.evaluation import as_json, evaluate

router = APIRouter(prefix="/maps/{map_id}", tags=["maps"])


class PerformanceAnswer(BaseModel):
    """What became of requests for paths."""

    queries: int = Field(description="How many there were")
    success: float | None = Field(description="Part of them that got a path")
    computed: int = Field(description="Paths that were computed")
    reused: int = Field(description="Paths that were kept, and reused")
    stitched: int = Field(description="Paths that were kept, and stitched to start and goal")
    reuse_rate: float | None = Field(description="Part of the paths that was not computed")
    seconds: float | None = Field(description="Mean time to compute one [s]")
    typical_seconds: float | None = Field(description="Geometric mean of these times [s]")
    spread: float | None = Field(description="Factor by which they typically differ from that")
    compared: int = Field(description="Paths that were compared with the cheapest ones from cell to cell")
    over_cheapest: float | None = Field(description="By which part they were longer; below 0 if not from cell to cell")


class ComplexityAnswer(PerformanceAnswer):
    """What became of requests whose start and goal are so far apart."""

    cells: Annotated[list[float], Field(min_length=2, max_length=2, description="From the first up to the second")]


class EvaluatedPlanner(PerformanceAnswer):
    """How one planner did."""

    planner: str
    complexities: list[ComplexityAnswer] = Field(description="By the distance between start and goal in cells")


class LinkAnswer(BaseModel):
    """How fast kept paths came from the store of late."""

    link: str = Field(description="The machine that asked")
    round_trip: float = Field(description="Until an answer without a path is there [s]")
    bandwidth: float = Field(description="Of paths [bytes/s]")
    answers: int = Field(description="How many were measured")
    measured: float = Field(description="When the last one was [s since the epoch]")


class EvaluationAnswer(BaseModel):
    """How planners did on a map."""

    map: str
    version: str | None = Field(description="The one it is about; null for all")
    planners: list[EvaluatedPlanner] = Field(description="Those that were asked, by name")
    links: list[LinkAnswer]


OneVersion = Annotated[Version | None, Query(description="Only requests on this version of the map")]


@router.get("/evaluation", response_model=EvaluationAnswer, responses=KNOWN | problems(404))
async def evaluate_planners(
    map_id: MapId, services: Provided, user: Caller, version: OneVersion = None
) -> dict[str, Any]:
    """Tell how planners did on a map: what was asked of them, how long it took, and how often a kept path did."""
    await readable_head(services, user, map_id)
    rows = await run_in_threadpool(services.store.history, map_id, version)
    links = await run_in_threadpool(services.store.links)
    return {
        "map": map_id,
        "version": version,
        "planners": [as_json(each) for each in evaluate(rows)],
        "links": [{name: getattr(link, name) for name in link.__struct_fields__} for link in links],
    }
