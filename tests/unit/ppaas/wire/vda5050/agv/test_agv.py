"""AGV as a state machine: orders, updates, actions, pauses, failures."""

import math

import msgspec
import pytest

from ppaas.wire.vda5050.agv.agv import Abilities, Agv
from ppaas.wire.vda5050.agv.commands import (
    Command,
    Drive,
    DriveResult,
    Execute,
    LimitSpeed,
    Localize,
    RobotPose,
    SendFactsheet,
    Stop,
    UseZones,
)
from ppaas.wire.vda5050.agv.zone_book import SUPPORTED
from ppaas.wire.vda5050.fields import Point, Trajectory
from ppaas.wire.vda5050.orders import Deviation, InstantActions, Order
from ppaas.wire.vda5050.topics import Version
from ppaas.wire.vda5050.zones import Zone, Zones, ZoneSet
from tests.support.vda5050.orders import MAP, action, edge, node, order


def agv_at(x: float = 0.0, version: Version = Version.V2_1) -> Agv:
    agv = Agv(version, Abilities(MAP, frozenset({"beep"}), SUPPORTED))
    agv.link(connected=True)
    agv.robot_at(RobotPose(x, 0.0, 0.0))
    return agv


def drives(commands: list[Command]) -> list[tuple[float, float]]:
    return [(one.x, one.y) for one in commands if isinstance(one, Drive)]


def arrive(agv: Agv, drive: Command) -> None:
    assert isinstance(drive, Drive)
    agv.robot_at(RobotPose(drive.x, drive.y, drive.theta))
    agv.drive_ended(drive.number, DriveResult.REACHED)


def instant(agv: Agv, *actions: object) -> None:
    agv.take_instant_actions(InstantActions(actions=list(actions)))  # type: ignore[arg-type]


def kinds(agv: Agv) -> list[str]:
    return [error.error_type for error in agv.errors]


def statuses(agv: Agv) -> dict[str, str]:
    return {one.action_id: one.action_status for one in [*agv.actions.states(), *agv.instants.states()]}


# -- orders ------------------------------------------------------------------------------------------------------------


def test_an_order_is_driven_from_node_to_node() -> None:
    agv = agv_at()
    agv.take_order(order(0, 2))
    (first,) = agv.take_commands()
    assert (drives([first]), agv.driving, agv.orders.last_node) == ([(1.0, 0.0)], True, "n0")
    assert [one.node_id for one in agv.orders.node_states()] == ["n1", "n2"]
    agv.robot_at(RobotPose(0.8, 0.0, 0.0))
    (second,) = agv.take_commands()
    assert (drives([second]), agv.orders.last_node) == ([(2.0, 0.0)], "n1")
    agv.robot_at(RobotPose(1.9, 0.0, 0.0))
    assert agv.orders.last_node == "n1"
    arrive(agv, second)
    assert agv.idle and not agv.driving and agv.take_commands() == []
    assert (agv.orders.last_node, agv.orders.last_sequence, agv.orders.order_id) == ("n2", 4, "o1")


def test_the_end_of_a_replaced_drive_is_ignored() -> None:
    agv = agv_at()
    agv.take_order(order(0, 2))
    (first,) = agv.take_commands()
    agv.robot_at(RobotPose(0.9, 0.0, 0.0))
    assert isinstance(first, Drive)
    agv.drive_ended(first.number, DriveResult.FAILED, "replaced")
    assert agv.driving and agv.errors == []


def test_an_ellipse_of_deviation_is_turned() -> None:
    agv = agv_at()
    wanted = order(0, 2)
    position = wanted.nodes[1].node_position
    assert position is not None
    position.allowed_deviation_xy = Deviation(a=1.0, b=0.1, theta=math.pi / 2)
    agv.take_order(wanted)
    agv.take_commands()
    agv.robot_at(RobotPose(0.4, 0.0, 0.0))
    assert agv.orders.last_node == "n0"
    agv.robot_at(RobotPose(1.0, 0.9, 0.0))
    assert agv.orders.last_node == "n1"


def test_a_robot_stops_at_the_end_of_the_base_and_goes_on_by_an_update() -> None:
    agv = agv_at()
    agv.take_order(order(0, 1, 2))
    assert agv.orders.at_end_of_base
    arrive(agv, agv.take_commands()[0])
    assert not agv.driving and not agv.idle and agv.take_commands() == []
    agv.take_order(order(1, 3, update=1))
    assert drives(agv.take_commands()) == [(2.0, 0.0)]
    assert (agv.orders.update_id, agv.orders.nodes[-1].released) == (1, True)


def test_an_update_before_the_end_of_the_base_does_not_stop_the_robot() -> None:
    agv = agv_at()
    agv.take_order(order(0, 1))
    agv.take_commands()
    agv.take_order(order(1, 2, update=1))
    assert agv.take_commands() == [] and agv.driving
    agv.robot_at(RobotPose(0.9, 0.0, 0.0))
    assert drives(agv.take_commands()) == [(2.0, 0.0)]


def test_an_order_that_is_done_may_be_extended() -> None:
    agv = agv_at()
    agv.take_order(order(0, 1))
    arrive(agv, agv.take_commands()[0])
    assert agv.idle
    agv.take_order(order(1, 2, update=5))
    assert drives(agv.take_commands()) == [(2.0, 0.0)]


def test_repeated_orders_are_ignored_also_when_others_were_taken_since() -> None:
    agv = agv_at()
    agv.take_order(order(0, 1))
    arrive(agv, agv.take_commands()[0])
    agv.take_order(order(1, 2, order_id="o2"))
    arrive(agv, agv.take_commands()[0])
    agv.robot_at(RobotPose(0.0, 0.0, 0.0))
    agv.take_order(order(0, 1))
    assert (agv.take_commands(), agv.errors, agv.orders.order_id) == ([], [], "o2")


@pytest.mark.parametrize(
    ("wanted", "kind"),
    [
        (order(0, 1, order_id="o2"), "OTHER_ORDER_ACTIVE"),
        (order(2, 3, update=2), "OUTDATED_ORDER_UPDATE"),
        (order(2, 4, update=3), "SAME_ORDER_UPDATE_ID"),
        (order(1, 4, update=4), "VALIDATION_FAILURE"),
        (order(4, 5, update=4), "VALIDATION_FAILURE"),
    ],
)
def test_orders_that_do_not_continue_the_base_are_refused(wanted: Order, kind: str) -> None:
    agv = agv_at()
    agv.take_order(order(0, 2, update=3))
    agv.take_commands()
    agv.take_order(wanted)
    assert (kinds(agv), agv.take_commands(), agv.driving) == ([kind], [], True)
    assert (agv.orders.order_id, agv.orders.update_id) == ("o1", 3)


def changed(**fields: object) -> Order:
    return msgspec.structs.replace(order(0, 2), **fields)


NOWHERE = msgspec.structs.replace(node(2), node_position=None)


@pytest.mark.parametrize(
    ("wanted", "kind"),
    [
        (changed(order_id=""), "VALIDATION_FAILURE"),
        (changed(nodes=[]), "VALIDATION_FAILURE"),
        (changed(edges=[]), "VALIDATION_FAILURE"),
        (changed(nodes=[node(0), node(1, released=False), node(2)]), "VALIDATION_FAILURE"),
        (changed(nodes=[node(0), node(2), node(1)]), "VALIDATION_FAILURE"),
        (changed(nodes=[node(0, released=False), node(1), node(2)]), "VALIDATION_FAILURE"),
        (changed(edges=[edge(0), msgspec.structs.replace(edge(1), end_node_id="n7")]), "VALIDATION_FAILURE"),
        (changed(edges=[edge(0, speed=-1.0), edge(1)]), "VALIDATION_FAILURE"),
        (changed(nodes=[node(0), node(1), node(2, map_id="yard")]), "UNKNOWN_MAP_ID"),
        (changed(nodes=[node(0), node(1), node(2, actions=[action("pick", "a1")])]), "INVALID_ORDER_ACTION"),
        (
            changed(nodes=[node(0), node(1, actions=[action("beep", "a")]), node(2, actions=[action("beep", "a")])]),
            "VALIDATION_FAILURE",
        ),
        (
            changed(edges=[edge(0), msgspec.structs.replace(edge(1), trajectory=Trajectory(control_points=[]))]),
            "UNSUPPORTED_PARAMETER",
        ),
        (
            changed(nodes=[node(0), node(1), msgspec.structs.replace(node(2), node_position=None)]),
            "UNSUPPORTED_PARAMETER",
        ),
        (order(3, 4), "START_NODE_OUT_OF_RANGE"),
    ],
)
def test_orders_that_are_wrong_in_themselves_are_refused(wanted: Order, kind: str) -> None:
    agv = agv_at()
    agv.take_order(wanted)
    assert (kinds(agv), agv.take_commands(), agv.idle, agv.orders.order_id) == ([kind], [], True, "")
    agv.take_order(order(0, 1))
    assert agv.errors == []


def test_a_robot_that_is_not_localized_takes_no_order() -> None:
    agv = agv_at()
    agv.robot_at(None)
    agv.take_order(order(0, 1))
    assert kinds(agv) == ["MOBILE_ROBOT_NOT_AVAILABLE", "LOCALIZATION_ERROR"]


def test_version_3_begins_orders_at_update_0() -> None:
    agv = agv_at(version=Version.V3_0)
    agv.take_order(order(0, 1, update=1))
    assert kinds(agv) == ["VALIDATION_FAILURE"]


# -- failures ----------------------------------------------------------------------------------------------------------


def test_a_node_that_is_not_reached_is_reported_until_the_order_ends() -> None:
    agv = agv_at()
    agv.take_order(order(0, 1))
    (drive,) = agv.take_commands()
    assert isinstance(drive, Drive)
    agv.drive_ended(drive.number, DriveResult.FAILED, "no path")
    (error,) = agv.errors
    assert (error.error_type, error.error_level, error.error_description) == ("NODE_UNREACHABLE", "CRITICAL", "no path")
    assert not agv.driving and not agv.idle
    instant(agv, action("stopPause", "again"))
    assert drives(agv.take_commands()) == [(1.0, 0.0)] and agv.errors == []


def test_a_lost_drive_begins_again_when_the_robot_is_back() -> None:
    agv = agv_at()
    agv.take_order(order(0, 1))
    (drive,) = agv.take_commands()
    assert isinstance(drive, Drive)
    agv.link(connected=False)
    agv.drive_ended(drive.number, DriveResult.LOST)
    assert (agv.take_commands(), kinds(agv)) == ([], ["MOBILE_ROBOT_NOT_AVAILABLE"])
    agv.link(connected=True)
    assert drives(agv.take_commands()) == [(1.0, 0.0)]


# -- actions -----------------------------------------------------------------------------------------------------------


def with_actions(*blocking: str) -> Order:
    actions = [action("beep", f"a{index}", one) for index, one in enumerate(blocking)]  # type: ignore[arg-type]
    return changed(nodes=[node(0, actions=actions), node(1), node(2)])


def started(commands: list[Command]) -> list[str]:
    return [one.action.action_id for one in commands if isinstance(one, Execute)]


def test_actions_that_allow_it_run_while_the_robot_drives() -> None:
    agv = agv_at()
    agv.take_order(with_actions("NONE", "NONE"))
    commands = agv.take_commands()
    assert started(commands) == ["a0", "a1"] and len(drives(commands)) == 1


@pytest.mark.parametrize("blocking", ["SOFT", "HARD"])
def test_the_robot_stands_while_an_action_blocks(blocking: str) -> None:
    agv = agv_at()
    agv.take_order(with_actions(blocking))
    commands = agv.take_commands()
    assert started(commands) == ["a0"] and drives(commands) == []
    agv.action_ended("a0", ok=True, result="beeped")
    assert len(drives(agv.take_commands())) == 1
    assert statuses(agv) == {"a0": "FINISHED"}


def test_hard_actions_run_alone_and_in_order() -> None:
    agv = agv_at()
    agv.take_order(with_actions("SOFT", "NONE", "HARD", "NONE"))
    assert started(agv.take_commands()) == ["a0", "a1"]
    agv.action_ended("a0", ok=True)
    assert started(agv.take_commands()) == []
    agv.action_ended("a1", ok=False, result="silence")
    assert started(agv.take_commands()) == ["a2"]
    agv.action_ended("a2", ok=True)
    commands = agv.take_commands()
    assert started(commands) == ["a3"] and len(drives(commands)) == 1
    assert statuses(agv) == {"a0": "FINISHED", "a1": "FAILED", "a2": "FINISHED", "a3": "RUNNING"}


def test_actions_of_an_edge_begin_when_it_is_entered() -> None:
    agv = agv_at()
    edges = [edge(0), edge(1, speed=0.2, actions=[action("beep", "a", "HARD")])]
    agv.take_order(changed(edges=edges))
    assert started(agv.take_commands()) == []
    agv.robot_at(RobotPose(0.9, 0.0, 0.0))
    commands = agv.take_commands()
    assert started(commands) == ["a"] and Stop() in commands and drives(commands) == []
    agv.action_ended("a", ok=True)
    assert drives(agv.take_commands()) == [(2.0, 0.0)]


def test_edges_limit_the_speed_until_they_are_left() -> None:
    agv = agv_at()
    agv.take_order(changed(edges=[edge(0, speed=0.2), edge(1)]))
    assert agv.take_commands()[0] == LimitSpeed(0.2)
    agv.robot_at(RobotPose(0.9, 0.0, 0.0))
    assert agv.take_commands()[0] == LimitSpeed(0.0)


def test_the_decision_node_of_an_update_does_not_repeat_its_actions() -> None:
    agv = agv_at()
    wanted = order(0, 1)
    wanted.nodes[1].actions = [action("beep", "a", "HARD")]
    agv.take_order(wanted)
    arrive(agv, agv.take_commands()[0])
    assert started(agv.take_commands()) == ["a"]
    agv.action_ended("a", ok=True)
    update = order(1, 2, update=1)
    update.nodes[0].actions = wanted.nodes[1].actions
    agv.take_order(update)
    commands = agv.take_commands()
    assert started(commands) == [] and drives(commands) == [(2.0, 0.0)]


# -- instant actions ---------------------------------------------------------------------------------------------------


def test_a_paused_robot_stands_and_goes_on() -> None:
    agv = agv_at()
    agv.take_order(order(0, 1))
    agv.take_commands()
    instant(agv, action("startPause", "i1"))
    assert (agv.take_commands(), agv.paused, agv.driving) == ([Stop()], True, False)
    instant(agv, action("startPause", "i1"), action("stopPause", "i2"))
    assert drives(agv.take_commands()) == [(1.0, 0.0)] and not agv.paused
    assert statuses(agv) == {"i1": "FINISHED", "i2": "FINISHED"}


def test_cancelling_waits_for_actions_that_run() -> None:
    agv = agv_at()
    wanted = with_actions("NONE")
    wanted.nodes[2].actions = [action("beep", "later")]
    agv.take_order(wanted)
    agv.take_commands()
    instant(agv, action("cancelOrder", "i"))
    assert agv.take_commands() == [Stop()]
    assert statuses(agv) == {"a0": "RUNNING", "later": "FAILED", "i": "RUNNING"}
    assert agv.orders.node_states() == [] and not agv.idle
    agv.action_ended("a0", ok=True)
    assert statuses(agv) == {"a0": "FINISHED", "later": "FAILED", "i": "FINISHED"} and agv.idle
    agv.take_order(order(2, 3, update=1))
    assert kinds(agv) == ["ORDER_UPDATE_FOLLOWING_CANCEL"]


def test_no_order_is_no_order_to_cancel() -> None:
    agv = agv_at()
    instant(agv, action("cancelOrder", "i1"))
    agv.take_order(order(0, 1))
    instant(agv, action("cancelOrder", "i2", orderId="o7"))
    assert kinds(agv) == ["NO_ORDER_TO_CANCEL"] * 2
    assert statuses(agv) == {"i1": "FAILED", "i2": "FAILED"} and agv.driving


def test_the_factsheet_and_the_state_are_sent_on_request() -> None:
    agv = agv_at()
    agv.take_change()
    instant(agv, action("stateRequest", "i1"), action("factsheetRequest", "i2"))
    assert agv.take_change() and agv.take_commands() == [SendFactsheet()]


@pytest.mark.parametrize(("version", "name"), [(Version.V2_0, "initPosition"), (Version.V3_0, "initializePosition")])
def test_a_position_is_set(version: Version, name: str) -> None:
    agv = agv_at(version=version)
    instant(agv, action(name, "i", x=1, y=2.5, theta=7.0, mapId=MAP, lastNodeId="n9"))
    (command,) = agv.take_commands()
    assert isinstance(command, Localize)
    assert (command.x, command.y, command.theta) == (1.0, 2.5, pytest.approx(7.0 - 2 * math.pi))
    assert agv.orders.last_node == "n9"


@pytest.mark.parametrize(
    "parameters",
    [{}, {"x": "1", "y": 2, "theta": 0, "mapId": MAP}, {"x": 1, "y": 2, "theta": 0, "mapId": "yard"}],
)
def test_other_positions_are_refused(parameters: dict[str, object]) -> None:
    agv = agv_at()
    instant(agv, action("initPosition", "i", **parameters))
    assert (agv.take_commands(), kinds(agv), statuses(agv)) == ([], ["INVALID_INSTANT_ACTION"], {"i": "FAILED"})


@pytest.mark.parametrize("name", ["logReport", "explode", "enableZoneSet", "initializePosition"])
def test_unknown_instant_actions_fail(name: str) -> None:
    agv = agv_at()
    instant(agv, action(name, "i"))
    assert (kinds(agv), statuses(agv)) == (["INVALID_INSTANT_ACTION"], {"i": "FAILED"})
    instant(agv, action("stateRequest", "i2"))
    assert agv.errors == []


def test_instant_actions_of_the_robot_are_executed() -> None:
    agv = agv_at()
    instant(agv, action("beep", "i"))
    assert started(agv.take_commands()) == ["i"]
    agv.action_ended("i", ok=False, result="silence")
    assert statuses(agv) == {"i": "FAILED"}


# -- zones -------------------------------------------------------------------------------------------------------------


def zone_set(zone_type: str, *, map_id: str = MAP, zone_set_id: str = "z") -> ZoneSet:
    corners = [Point(x=0.0, y=0.0), Point(x=1.0, y=0.0), Point(x=0.0, y=1.0)]
    zone = Zone(zone_id="a", zone_type=zone_type, vertices=corners)  # type: ignore[arg-type]
    return ZoneSet(zone_set=Zones(map_id=map_id, zone_set_id=zone_set_id, zones=[zone]))


def test_a_set_of_zones_is_used_once_it_is_enabled() -> None:
    agv = agv_at(version=Version.V3_0)
    agv.take_zone_set(zone_set("BLOCKED"))
    assert [one.zone_set_status for one in agv.zones.states()] == ["DISABLED"]
    instant(agv, action("enableZoneSet", "i", zoneSetId="z"))
    assert agv.take_commands() == [UseZones("z")] and statuses(agv) == {"i": "RUNNING"}
    agv.zones_used("z")
    assert [one.zone_set_status for one in agv.zones.states()] == ["ENABLED"] and statuses(agv) == {"i": "FINISHED"}
    instant(agv, action("deleteZoneSet", "i2", zoneSetId="z"))
    assert statuses(agv)["i2"] == "FAILED" and kinds(agv) == ["INVALID_ZONE_SET"]


def test_a_zone_whose_outline_crosses_itself_is_refused_with_the_place() -> None:
    agv = agv_at(version=Version.V3_0)
    corners = [Point(x=x, y=y) for x, y in ((0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0))]
    zone = Zone(zone_id="spill", zone_type="BLOCKED", vertices=corners)
    agv.take_zone_set(ZoneSet(zone_set=Zones(map_id=MAP, zone_set_id="z", zones=[zone])))
    assert kinds(agv) == ["INVALID_ZONE_SET"] and agv.zones.states() == []
    assert "zone 'spill': its outline crosses itself at (1, 1)" in str(agv.errors)


def test_zones_that_cannot_be_respected_are_refused() -> None:
    agv = agv_at(version=Version.V3_0)
    for message in (zone_set("RELEASE"), zone_set("SPEED_LIMIT"), zone_set("BLOCKED", map_id="yard")):
        agv.take_zone_set(message)
    agv.take_zone_set(zone_set("BLOCKED"))
    agv.take_zone_set(zone_set("BLOCKED"))
    assert kinds(agv) == ["INVALID_ZONE_SET", "INVALID_ZONE_SET", "UNKNOWN_MAP_ID"]
    instant(agv, action("enableZoneSet", "i", zoneSetId="none"))
    assert statuses(agv) == {"i": "FAILED"}
