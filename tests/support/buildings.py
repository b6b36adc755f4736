"""Layouts of buildings for tests, and a lift behind an HTTP server that is not ours."""

import json
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.types import Receive, Scope, Send

from ppaas.buildings.building import Building, DoorSettings, Floor, LiftSettings
from ppaas.buildings.doors.simulated import SimulatedDoor
from ppaas.buildings.doors.states import DoorRequest
from ppaas.buildings.layout import BuildingLayout, DoorPlace, Landing
from ppaas.buildings.lifts.simulated import LiftModel, SimulatedLift
from ppaas.buildings.lifts.states import EndSession, LiftRequest
from ppaas.clock import epoch

FLOORS = ("L1", "L2", "L3")
LEVELS = {"L1": 0.0, "L2": 1.0, "L3": 2.0}
QUICK = LiftModel(speed=10.0, acceleration=50.0, doors=0.1)


def layout(lift: str = "", door: str = "") -> BuildingLayout:
    """Return the layout of a building of low floors with a quick lift and a quick door, and the URLs of both."""
    building = Building(
        floors=tuple(Floor(name=name, map=name, elevation=height) for name, height in LEVELS.items()),
        lifts=(LiftSettings(lift="A", robots=2, speed=10.0, doors=0.1, device=lift),),
        doors=(DoorSettings(floor="L1", door="main", opens=0.1, device=door),),
    )
    landings = tuple(_landing(floor) for floor in FLOORS)
    main = DoorPlace("L1", "main", ((5.0, 0.0), (6.0, 0.0)))
    return BuildingLayout(building, {"A": landings}, {}, (main, *(each.door for each in landings)), (), ())


def _landing(floor: str) -> Landing:
    door = DoorPlace(floor, "lift door", ((0.0, 0.0), (1.0, 0.0)), "A")
    car = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    return Landing("A", floor, door, (0.5, 0.5, -1.57), car, (0.5, -0.9, 1.57))


class LiftServer:
    """Gateway of a lift (``/lift``) and a door (``/door``), as docs/lifts.md describes it."""

    def __init__(self) -> None:
        self.lift = SimulatedLift("A", {"1": 0.0, "2": 1.0, "3": 2.0}, epoch(), QUICK)
        self.door = SimulatedDoor("", "", epoch(), 0.1)
        self.answer: Response | None = None
        self.orders: list[dict[str, Any]] = []

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        request = Request(scope, receive)
        found = self.answer
        if found is None and request.method == "POST":
            self._take(request.url.path, json.loads(await request.body()))
            found = Response(status_code=204)
        elif found is None:
            found = JSONResponse(self._state(request.url.path))
        await found(scope, receive, send)

    def _take(self, path: str, order: dict[str, Any]) -> None:
        self.orders.append(order)
        if path == "/door":
            self.door.request(DoorRequest("", "", order["session"], order["mode"]), epoch())
        elif order.get("end"):
            self.lift.end(EndSession("A", order["session"]), epoch())
        else:
            self.lift.request(LiftRequest("A", order["session"], order["floor"]), epoch())

    def _state(self, path: str) -> dict[str, Any]:
        if path == "/door":
            return {"mode": self.door.state(epoch()).mode}
        state = self.lift.state(epoch())
        names = ("floor", "door", "motion", "mode", "session", "floors")
        return {name: getattr(state, name) for name in names}
