"""States and visualizations of an AGV, checked against the published schemas while it does everything it can."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.agv.agv import Abilities, Agv
from ppaas.wire.vda5050.agv.commands import Drive, DriveResult, RobotPose
from ppaas.wire.vda5050.agv.report import MAX_POINTS, Telemetry, state_of, visualization_of
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.fields import Velocity
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.orders import InstantActions
from ppaas.wire.vda5050.states import PowerSupply
from ppaas.wire.vda5050.topics import AgvAddress, Version
from tests.support.vda5050.orders import MAP, action, order
from tests.support.vda5050.schemas import problems

PATH = [(0.01 * index, 0.0) for index in range(500)]
TELEMETRY = Telemetry(PowerSupply(state_of_charge=50.0, charging=False), Velocity(vx=0.2, omega=0.0), PATH, "3")


def check(agv: Agv, version: Version) -> None:
    headers = HeaderCounter(version, AgvAddress.of(version, "ppaas", "tb1"))
    for topic, message in (
        (topics.STATE, state_of(agv, MAP, TELEMETRY)),
        (topics.VISUALIZATION, visualization_of(agv, MAP, TELEMETRY, 0)),
    ):
        assert problems(version, topic, encode(topic, headers.next(topic, 0.0), message, version)) == []


def new_agv(version: Version) -> Agv:
    agv = Agv(version, Abilities(MAP, frozenset({"beep"})))
    agv.link(connected=True)
    agv.robot_at(RobotPose(0.0, 0.0, 0.0, 0.1))
    return agv


def test_a_driving_agv_tells_its_path_and_the_rest_of_its_order() -> None:
    agv = new_agv(Version.V3_0)
    agv.take_order(order(0, 1, 2))
    state = state_of(agv, MAP, TELEMETRY)
    assert (state.driving, state.new_base_request, len(state.node_states), len(state.edge_states)) == (True, True, 2, 2)
    assert state.planned_path is not None and state.planned_path.traversed_nodes == ["n1"]
    line = state.planned_path.trajectory
    assert len(line.control_points) == MAX_POINTS and (line.control_points[-1].x, line.control_points[-1].y) == PATH[-1]
    assert line.knot_vector is not None and len(line.knot_vector) == MAX_POINTS + 2
    position = state.mobile_robot_position
    assert position is not None and position.localized and position.localization_score == pytest.approx(0.9)


def test_a_robot_that_is_not_connected_is_not_localized() -> None:
    agv = new_agv(Version.V2_1)
    agv.link(connected=False)
    state = state_of(agv, MAP, TELEMETRY)
    assert state.mobile_robot_position is not None and not state.mobile_robot_position.localized
    assert state.operating_mode == "SERVICE"


def test_a_robot_that_others_move_drives() -> None:
    agv = new_agv(Version.V2_1)
    agv.take_change()
    agv.robot_moves(moving=True)
    assert agv.take_change() and state_of(agv, MAP, TELEMETRY).driving
    agv.robot_moves(moving=False)
    assert agv.take_change() and not state_of(agv, MAP, TELEMETRY).driving


def test_a_robot_that_reached_its_last_node_stands() -> None:
    agv = new_agv(Version.V2_1)
    agv.take_order(order(0, 1))
    agv.robot_moves(moving=True)
    (drive,) = agv.take_commands()
    assert isinstance(drive, Drive)
    agv.drive_ended(drive.number, DriveResult.REACHED)
    assert not state_of(agv, MAP, TELEMETRY).driving


steps = st.lists(
    st.one_of(
        st.builds(
            order,
            st.integers(0, 3),
            st.integers(0, 4),
            st.none() | st.integers(0, 6),
            update=st.integers(0, 4),
            order_id=st.sampled_from(["o1", "o2"]),
        ),
        st.builds(RobotPose, st.floats(-1, 5), st.floats(-1, 1), st.just(0.0)),
        st.sampled_from(DriveResult),
        st.booleans(),
        st.builds(
            lambda name, number, blocking: InstantActions(actions=[action(name, f"i{number}", blocking)]),
            st.sampled_from(["startPause", "stopPause", "cancelOrder", "stateRequest", "beep", "x"]),
            st.integers(0, 20),
            st.sampled_from(["NONE", "SOFT", "HARD"]),
        ),
    ),
    max_size=25,
)


@given(st.sampled_from(Version), steps)
def test_whatever_happens_the_state_is_valid_and_the_base_is_kept(version: Version, happened: list[object]) -> None:
    agv = new_agv(version)
    number, taken = 0, []
    for event in happened:
        before = agv.orders.last_sequence
        if isinstance(event, RobotPose):
            agv.robot_at(event)
        elif isinstance(event, DriveResult):
            agv.drive_ended(number, event)
        elif isinstance(event, bool):
            agv.link(connected=event)
        elif isinstance(event, InstantActions):
            agv.take_instant_actions(event)
        else:
            agv.take_order(event)  # type: ignore[arg-type]
            taken.append(agv.orders.order_id)
        for command in agv.take_commands():
            if isinstance(command, Drive):
                number = command.number
                target = agv.orders.target
                assert target is not None and target.released  # the horizon is never entered
        assert agv.orders.last_sequence >= before or len(set(taken)) > 1
        assert len(agv.orders.nodes) == len(agv.orders.edges)
        assert not (agv.driving and agv.paused)
    check(agv, version)
