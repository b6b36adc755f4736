"""One AGV as a robot of the cloud."""

import asyncio
import logging
import math
from collections.abc import Mapping, Sequence
from typing import Any

from ppaas.clock import epoch, monotonic
from ppaas.errors import NotFound, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Time
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.fields import Position, Velocity
from ppaas.wire.vda5050.headers import MessageHeader
from ppaas.wire.vda5050.master.instructions import (
    Complaint,
    Instruction,
    PathEnded,
    Progress,
    SendActions,
    SendOrder,
    SendZones,
    init_position,
    instant_action,
    knows_place,
    standing,
)
from ppaas.wire.vda5050.master.master_control import AgvPath, MasterControl
from ppaas.wire.vda5050.states import Connection, State, Visualization
from ppaas.zones.zone import Zone
from robots.bridges.agv.agv_side import AgvSide, IgnoredMessage
from robots.bridges.agv.cloud_side import CloudCallbacks, CloudSide, diagnostics
from robots.bridges.agv.options import FleetOptions, settings_of
from robots.bridges.agv.registration import AgvRegistry, differences
from robots.bridges.agv.zones import ZoneSide
from robots.bridges.core.notices import Notices, without_numbers

logger = logging.getLogger(__name__)

FORWARDED = ("startPause", "stopPause", "stateRequest", "factsheetRequest", "cancelOrder")
"""Types of instant actions that operators may send."""

POSE_PERIOD, REPEAT = 0.1, 1.2
"""Least time between two poses, and time after which the pose of an AGV that stands is repeated [s]."""

DIAGNOSTICS_PERIOD = 5.0
"""Time between two diagnostics, unless something changes [s]."""

SHEET_PATIENCE = 3.0
"""Time for which a factsheet is waited for [s]."""

LEAVE_AFTER = 3.0
"""Time for which the connection of the AGV or of the broker is broken after which its robot leaves the cloud [s]. The
robot of an AGV that says that it goes offline leaves at once."""

MAX_TEXTS = 30
"""Largest number of different texts about left out messages of an AGV that are logged."""

STATE_AGE = 45.0
"""Age of the newest state from which an AGV counts as lost [s]: it is to send one every 30 s at least."""

RETRY = 10.0
"""Time after which a robot that the cloud refused is tried again [s]."""


class AgvRobot:
    """Joins an AGV with its robot, by a master control.

    Parameters
    ----------
    agv : AgvSide
    url, token : str
        URL of the cloud, and token of the account.
    registry : AgvRegistry
        Robots of the account.
    options : FleetOptions
    """

    def __init__(self, agv: AgvSide, url: str, token: str, *, registry: AgvRegistry, options: FleetOptions) -> None:
        self._agv, self._options, self._registry = agv, options, registry
        self._url, self._token = url, token
        self._control = MasterControl(options.settings)
        self._cloud: CloudSide | None = None
        self._zones = ZoneSide(agv.name)
        self._map = ""
        self._sheet: Factsheet | None = None
        self._sheet_came = asyncio.Event()
        self._there, self._left = asyncio.Event(), asyncio.Event()
        self._away_since: float | None = None
        self._position: Position | None = None
        self._velocity: Velocity | None = None
        self._pose_at = self._told_at = self._connection_at = self._state_at = -math.inf
        self._complaint, self._left_out_count = "", 0
        self._file: Mapping[str, Any] | None = None
        self._differences: tuple[str, ...] = ()
        self._notices = Notices(MAX_TEXTS)
        self._told: tuple[str, ...] = ()

    # -- from the AGV --------------------------------------------------------------------------------------------------

    def take(self, topic: str, header: MessageHeader, body: Any, *, retained: bool) -> None:
        """Take a message of the AGV."""
        if self._control.connection != "ONLINE":
            self._agv.begin_again()
        if (left_out := self._agv.left_out(topic, header)) is not None:
            self._leave_out(topic, left_out)
            return
        now = monotonic()
        match body:
            case Connection():
                self._take_connection(body, now)
            case State():
                self._take_state(body, now, retained=retained)
            case Visualization():
                self._take_position(body.mobile_robot_position, body.velocity, now)
            case Factsheet():
                self._sheet = body
                if body.physical_parameters is None:
                    self._notices.warn(f"AGV {self._agv.name} sends a factsheet without a size: give it by --radius")
                self._compare()
                self._control.settings = settings_of(body, self._options.settings)
                self._sheet_came.set()

    def refuse(self, topic: str, error: PPaaSError) -> None:
        """Take it that the AGV sent a message that cannot be read."""
        if topic == topics.FACTSHEET and self._sheet is None:
            self._registry.unreadable[self._agv.address] = str(error)
        self._leave_out(topic, IgnoredMessage(str(error), is_loss=True))

    def _leave_out(self, topic: str, left_out: IgnoredMessage) -> None:
        self._left_out_count += 1
        self._notices.warn(f"AGV {self._agv.name}: a message is left out: {left_out.reason}")
        if topic == topics.STATE and left_out.is_loss:
            text = f"states of the AGV are left out: {left_out.reason}"
            if without_numbers(text) != without_numbers(self._control.left_out):
                self._control.left_out = text

    def _take_connection(self, body: Connection, now: float) -> None:
        if body.connection_state != self._control.connection:
            logger.info("AGV %s is %s", self._agv.name, body.connection_state)
        self._connection_at = now
        is_back = body.connection_state == "ONLINE" and self._control.connection != "ONLINE"
        self._away_since = None if body.connection_state == "ONLINE" else self._away_since or now
        self._do(self._control.take_connection(body.connection_state, now))
        if body.connection_state in ("OFFLINE", "HIBERNATING"):
            self._leave()
        if is_back:
            self._note_there()
            self._zones.control.begin_again()
            self._agv.send_actions(instant_action("stateRequest", epoch()))
            if self._sheet is None:
                self._agv.send_actions(instant_action("factsheetRequest", epoch()))

    def _take_state(self, state: State, now: float, *, retained: bool) -> None:
        if self._control.connection != "ONLINE" and not retained and now - self._connection_at > REPEAT:
            self._take_connection(Connection(connection_state="ONLINE"), now)
        self._state_at, self._control.left_out = now, self._on_other_map(state.mobile_robot_position)
        self._take_position(state.mobile_robot_position, state.velocity, now)
        self._do(self._control.take_state(state, now))
        if self._control.connection == "ONLINE":
            self._do(self._zones.control.advance(state, now))

    def _take_position(self, position: Position | None, velocity: Velocity | None, now: float) -> None:
        if position is None:
            return
        self._position, self._velocity = position, velocity
        self._note_there()
        if now - self._pose_at >= POSE_PERIOD:
            self._publish_pose(now)

    def _note_there(self) -> None:
        """Mark the AGV as present if it is online and knows its pose."""
        position = self._position
        if self._control.connection == "ONLINE" and position is not None and position.localized:
            self._there.set()

    def _leave(self) -> None:
        """Disconnect the robot from the cloud until the AGV is back."""
        self._there.clear()
        self._left.set()

    def broker_lost(self) -> None:
        """Note that the broker is away, and with it the AGV."""
        now = monotonic()
        self._away_since = self._away_since or now
        self._do(self._control.take_connection("CONNECTION_BROKEN", now))

    # -- from the cloud ------------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Connect the AGV as its robot whenever it is there, until cancelled."""
        while True:
            await self._there.wait()
            try:
                await self._be_robot()
            except PPaaSError as error:
                logger.error("AGV %s is not connected as a robot: %s", self._agv.name, error)
                await asyncio.sleep(RETRY)

    async def _be_robot(self) -> None:
        """Connect, and stay until the AGV has left, or has been away for `LEAVE_AFTER`."""
        self._left.clear()
        if not self._there.is_set():
            return  # it has left just now
        if self._sheet is None:
            await self._wait_for_sheet()
        assert self._position is not None
        async with self._registry.robot(self._agv.address, self._position.map_id, self._sheet) as known:
            robot, self._map = str(known["id"]), str(known["map"])
            self._control.left_out = self._control.left_out or self._on_other_map(self._position)
            self._file = known
            self._compare()
            requests = CloudCallbacks(self._follow, self._cancel, self._initial_pose, self._action, self._renewed)
            cloud = CloudSide(self._url, self._token, robot, requests)
            async with cloud.link:
                await cloud.subscribe()
                self._cloud = cloud
                logger.info("AGV %s is robot %s", self._agv.name, robot)
                try:
                    await self._stay(cloud, robot)
                finally:
                    self._cloud, self._told = None, ()

    def _compare(self) -> None:
        self._differences = () if self._file is None else differences(self._file, self._sheet)
        for text in self._differences:
            self._notices.tell(f"AGV {self._agv.name}: {text}")

    async def _stay(self, cloud: CloudSide, robot: str) -> None:
        ends = [asyncio.create_task(cloud.link.closed()), asyncio.create_task(self._left.wait())]
        try:
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
            if ends[0].done():
                ends[0].result()
        finally:
            for end in ends:
                end.cancel()
        await cloud.say_farewell()
        logger.info("AGV %s is away: robot %s leaves", self._agv.name, robot)

    async def _wait_for_sheet(self) -> None:
        try:
            async with asyncio.timeout(SHEET_PATIENCE):
                await self._sheet_came.wait()
        except TimeoutError:
            why = self._registry.unreadable.get(self._agv.address)
            what = f"a factsheet that cannot be read ({why})" if why else "no factsheet"
            logger.warning("AGV %s sends %s: give its size by --radius", self._agv.name, what)

    def _follow(self, path: AgvPath) -> None:
        self._do(self._control.follow(path, monotonic()))

    def _cancel(self, path: str) -> None:
        self._do(self._control.cancel(path, monotonic()))

    def _renewed(self) -> None:
        self._control.ask_again(monotonic())

    def _initial_pose(self, pose: Pose2D) -> None:
        if self._position is not None and self._control.state is not None:
            last = self._control.state.last_node_id
            self._agv.send_actions(init_position(pose, self._position.map_id, last, epoch()))

    def _action(self, kind: str) -> None:
        if kind not in FORWARDED:
            raise NotFound("instant action", kind, FORWARDED)
        self._agv.send_actions(instant_action(kind, epoch()))

    @property
    def map(self) -> str:
        """Map of the robot in the cloud; empty until the AGV has been connected as the robot."""
        return self._map

    def use_zones(self, zones: Sequence[Zone]) -> None:
        """Take the zones in force on the map; the AGV gets them while it is on that map."""
        position = self._position
        if position is not None and self._options.map_of(position.map_id) == self._map:
            self._zones.take(zones, position.map_id, self._sheet, self._agv.version)

    # -- both ways -----------------------------------------------------------------------------------------------------

    def tick(self) -> None:
        """Do what is due: send again, repeat the pose of an AGV that stands, publish its diagnostics."""
        now = monotonic()
        if self._control.connection == "ONLINE" and now - self._state_at > STATE_AGE and not self._control.stale:
            self._control.left_out = f"the AGV has sent no state that counts for {STATE_AGE:g} s"
        self._do(self._control.tick(now))
        if self._away_since is not None and now - self._away_since > LEAVE_AFTER:
            self._leave()
        state = self._control.state
        if now - self._pose_at >= REPEAT and state is not None and not state.driving:
            self._publish_pose(now)
        self._tell(now)

    def _do(self, instructions: list[Instruction]) -> None:
        for each in instructions:
            match each:
                case SendOrder():
                    self._agv.send_order(each.order)
                case SendActions():
                    self._agv.send_actions(each.actions)
                case SendZones():
                    self._agv.send_zones(each.zones)
                case Complaint():
                    self._complain(each.text)
                case Progress() if self._cloud is not None:
                    self._cloud.progress(each)
                case PathEnded():
                    self._end(each)

    def _end(self, end: PathEnded) -> None:
        logger.info("AGV %s: path %s ended: %s", self._agv.name, end.path, end.reason or "reached")
        if self._cloud is not None:
            self._cloud.ended(end)

    def _complain(self, text: str) -> None:
        if without_numbers(text) != without_numbers(self._complaint):
            logger.warning("AGV %s: %s", self._agv.name, text)
        self._complaint = text

    def _publish_pose(self, now: float) -> None:
        position = self._position
        if self._cloud is None or position is None or self._why_unusable():
            return
        self._pose_at = now
        self._cloud.pose(Pose2D(position.x, position.y, position.theta), self._velocity, position.deviation_range)

    def _why_unusable(self) -> str:
        """Return why the AGV has no pose in the robot's map; empty if it has one."""
        state, position = self._control.state, self._position
        if stale := self._control.stale:
            return stale
        if state is None or position is None:
            return "the AGV has sent no state with a position"
        if not position.localized or not knows_place(state):
            return standing(state) or "the AGV does not know where it is"
        if not Pose2D(position.x, position.y).is_near():
            return f"the AGV sends the position ({position.x:.3g}, {position.y:.3g}) m, which is none"
        return self._on_other_map(position)

    def _on_other_map(self, position: Position | None) -> str:
        """Return that the AGV is on another map than its robot; empty if it is not, or has no robot yet."""
        if position is None or not self._map or self._options.map_of(position.map_id) == self._map:
            return ""
        own, other = position.map_id[:60], self._map
        return f"the AGV is on map {own!r}, and its robot on {other!r}: say --map {own}={other} if they are one"

    def _facts(self, now: float) -> dict[str, str]:
        """Return what an operator wants to know of the AGV besides its state."""
        age = now - self._state_at
        return {
            "connection": self._control.connection or "unknown",
            "version": self._agv.version.value,
            "newest state": f"{age:.0f} s ago" if math.isfinite(age) else "none",
            "messages left out": str(self._left_out_count),
        }

    def _tell(self, now: float) -> None:
        """Publish localization and diagnostics, when they change and from time to time."""
        if self._cloud is None:
            return
        state = self._control.state
        errors = () if state is None else tuple(error.error_type for error in state.errors)
        told = (self._why_unusable(), self._complaint, "" if state is None else standing(state), *errors)
        if told == self._told and now - self._told_at < DIAGNOSTICS_PERIOD:
            return
        if told[:1] != self._told[:1]:
            self._cloud.localization(told[0])
        self._told, self._told_at = told, now
        stamp = Time.of(epoch())
        facts = self._facts(now)
        message = diagnostics(
            self._agv.name, state, told[0], stamp, facts=facts, complaint=self._complaint, notes=self._differences
        )
        self._cloud.diagnostics(message)
