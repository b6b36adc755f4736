"""JSON schemas of the state of a building."""

from pydantic import BaseModel, Field

from endpoints.rest.schemas import ResponseBody
from ppaas.buildings.doors.states import DoorMode
from ppaas.buildings.journeys.records import JourneyState
from ppaas.buildings.journeys.records import Phase as JourneyPhase
from ppaas.buildings.lifts.states import DoorPosition, LiftMode, Motion, Phase

ROBOT = "Robot, `OWNER:ROBOT` if it is another user's; null if the caller may not see it"


class RideAnswer(ResponseBody):
    """Robot that waits for a lift, or is in it."""

    robot: str | None = Field(description=ROBOT)
    origin: str
    destination: str
    phase: Phase
    since: float = Field(description="Time of its request [s since the epoch]")


class LiftStateAnswer(ResponseBody):
    """State of a lift."""

    lift: str
    fault: str = Field(description="Why it does not serve robots now; empty if it does")
    floor: str = Field(description="Floor where its car is, or which it passed last; empty if that is not known")
    target: str = Field(description="Floor to which it is sent; empty if to none")
    door: DoorPosition
    motion: Motion
    mode: LiftMode = Field(description="`unknown` before its first report")
    session: str = Field(description="Session that it obeys; empty if it is free")
    rides: list[RideAnswer] = Field(description="The oldest first")


class DoorStateAnswer(ResponseBody):
    """State of a door that has a device."""

    floor: str
    door: str
    mode: DoorMode = Field(description="`unknown` before its first report")
    fault: str = Field(description="Why it opens for nobody now; empty if it does")
    robots: list[str | None] = Field(description=f"For which it is held open. {ROBOT}")


class JourneyAnswer(ResponseBody):
    """Robot on its way over floors, or at the end of it."""

    robot: str | None = Field(description=ROBOT)
    goal: str | None = Field(description="Id of its goal; null if the caller may not see the robot")
    on: str = Field(description="Floor where it is")
    floor: str = Field(description="Floor of its goal")
    phase: JourneyPhase
    leg: str = Field(description="Lift, door or way that it takes, or waits for; empty while it drives on a floor")
    state: JourneyState
    text: str = Field(description="Why it waits, or why it has ended")
    since: float = Field(description="[s since the epoch]")
    ended: float | None = Field(description="[s since the epoch]; null while it is under way")


class BuildingStateAnswer(BaseModel):
    """State of the lifts and doors of a building that have devices, and the journeys in it."""

    building: int = Field(description="Version of the building")
    lifts: list[LiftStateAnswer]
    doors: list[DoorStateAnswer]
    faults: list[str] = Field(description="Devices that cannot be used, and why")
    journeys: list[JourneyAnswer] = Field(description="The last ones that have ended, then those under way")
