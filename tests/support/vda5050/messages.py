"""Messages of VDA 5050 with all that they may have, one a topic."""

from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.factsheets import (
    AgvAction,
    AgvActionParameter,
    Envelope2d,
    Factsheet,
    MobileRobotGeometry,
    OptionalParameter,
    PhysicalParameters,
    ProtocolFeatures,
    ProtocolLimits,
    StringLengths,
    Timing,
    TypeSpecification,
    WheelDefinition,
    WheelPosition,
)
from ppaas.wire.vda5050.fields import (
    ControlPoint,
    Fields,
    IntermediatePath,
    PathPoint,
    PlannedPath,
    Point,
    Position,
    Reference,
    Trajectory,
    Velocity,
)
from ppaas.wire.vda5050.orders import (
    Action,
    ActionParameter,
    Corridor,
    Deviation,
    Edge,
    InstantActions,
    Node,
    NodePosition,
    Order,
)
from ppaas.wire.vda5050.states import (
    ActionState,
    BoundingBoxReference,
    Connection,
    Dimensions,
    EdgeRequest,
    EdgeState,
    Error,
    Information,
    Load,
    MapState,
    NodeState,
    PowerSupply,
    SafetyState,
    State,
    Visualization,
    ZoneRequest,
    ZoneSetState,
)
from ppaas.wire.vda5050.zones import Response, Responses, Zone, ZoneAction, Zones, ZoneSet

LINE = Trajectory(
    degree=1,
    knot_vector=[0.0, 0.0, 1.0, 1.0],
    control_points=[ControlPoint(x=0.0, y=0.0, weight=1.0), ControlPoint(x=2.0, y=0.0)],
)
PATH = PlannedPath(trajectory=LINE, traversed_nodes=["n2"])
AHEAD = IntermediatePath(polyline=[PathPoint(x=0.0, y=0.0, theta=0.0, eta="2026-01-31T11:40:03.123Z")])
POSITION = Position(x=1.0, y=2.0, theta=0.5, map_id="hall", localized=True, localization_score=0.9, deviation_range=0.1)
VELOCITY = Velocity(vx=0.3, vy=0.0, omega=-0.1)
ACTION = Action(
    action_type="beep",
    action_id="a1",
    blocking_type="HARD",
    action_descriptor="a sound",
    action_parameters=[ActionParameter(key="seconds", value=1.5), ActionParameter(key="tones", value=["c", "d"])],
)
ORDER = Order(
    order_id="o1",
    order_update_id=0,
    nodes=[
        Node(
            node_id="n1",
            sequence_id=0,
            released=True,
            node_position=NodePosition(
                x=0.0,
                y=0.0,
                map_id="hall",
                theta=0.0,
                allowed_deviation_xy=Deviation(a=0.3, b=0.3, theta=0.0),
                allowed_deviation_theta=0.5,
            ),
            actions=[ACTION],
        ),
        Node(node_id="n2", sequence_id=2, released=False, node_descriptor="end", actions=[]),
    ],
    edges=[
        Edge(
            edge_id="e1",
            sequence_id=1,
            released=False,
            start_node_id="n1",
            end_node_id="n2",
            maximum_speed=0.5,
            orientation=0.0,
            orientation_type="TANGENTIAL",
            trajectory=LINE,
            corridor=Corridor(left_width=0.5, right_width=0.5, corridor_reference_point="KINEMATIC_CENTER"),
            actions=[],
        )
    ],
)
STATE = State(
    order_id="o1",
    order_update_id=0,
    last_node_id="n1",
    last_node_sequence_id=0,
    driving=True,
    operating_mode="AUTOMATIC",
    paused=False,
    new_base_request=True,
    distance_since_last_node=0.4,
    node_states=[
        NodeState(
            node_id="n2",
            sequence_id=2,
            released=False,
            node_position=NodePosition(x=2.0, y=0.0, map_id="hall"),
        )
    ],
    edge_states=[EdgeState(edge_id="e1", sequence_id=1, released=False, trajectory=LINE)],
    action_states=[ActionState(action_id="a1", action_status="FINISHED", action_type="beep", action_result="beeped")],
    instant_action_states=[ActionState(action_id="i1", action_status="FAILED", action_type="logReport")],
    power_supply=PowerSupply(
        state_of_charge=80.0, charging=False, battery_voltage=12.1, battery_health=99, range=900.0
    ),
    errors=[
        Error(
            error_type="orderError",
            error_level="WARNING",
            error_references=[Reference(reference_key="orderId", reference_value="o1")],
            error_description="the order is not valid",
            error_hint="send another one",
        )
    ],
    information=[Information(info_type="plan", info_level="DEBUG", info_descriptor="computed")],
    safety_state=SafetyState(active_emergency_stop="NONE", field_violation=False),
    maps=[MapState(map_id="hall", map_version="3", map_status="ENABLED", map_descriptor="the hall")],
    zone_sets=[ZoneSetState(zone_set_id="z1", map_id="hall", zone_set_status="ENABLED")],
    mobile_robot_position=POSITION,
    velocity=VELOCITY,
    planned_path=PATH,
    intermediate_path=AHEAD,
    loads=[
        Load(
            load_id="l1",
            bounding_box_reference=BoundingBoxReference(x=0.0, y=0.0, z=0.2),
            load_dimensions=Dimensions(length=0.4, width=0.3),
            weight=2.0,
        )
    ],
    zone_requests=[
        ZoneRequest(request_id="r1", request_type="ACCESS", zone_id="a", zone_set_id="z1", request_status="REQUESTED")
    ],
    edge_requests=[
        EdgeRequest(request_id="r2", request_type="CORRIDOR", edge_id="e1", sequence_id=1, request_status="GRANTED")
    ],
)
FACTSHEET = Factsheet(
    type_specification=TypeSpecification(
        series_name="turtlebot3",
        mobile_robot_kinematics="DIFFERENTIAL",
        mobile_robot_class="CARRIER",
        maximum_load_mass=15.0,
        localization_types=["NATURAL"],
        navigation_types=["FREELY_NAVIGATING"],
        supported_zones=["BLOCKED", "SPEED_LIMIT"],
    ),
    physical_parameters=PhysicalParameters(
        minimum_speed=0.05,
        maximum_speed=0.5,
        maximum_acceleration=1.0,
        maximum_deceleration=1.0,
        minimum_height=0.2,
        maximum_height=0.2,
        width=0.2,
        length=0.2,
    ),
    protocol_limits=ProtocolLimits(
        maximum_string_lengths=StringLengths(maximum_message_length=1_048_576, id_numerical_only=False),
        maximum_array_lengths={"order.nodes": 1000},
        timing=Timing(minimum_order_interval=0.1, minimum_state_interval=0.1, default_state_interval=30.0),
    ),
    protocol_features=ProtocolFeatures(
        optional_parameters=[OptionalParameter(parameter="order.nodes.nodePosition", support="REQUIRED")],
        mobile_robot_actions=[
            AgvAction(
                action_type="initPosition",
                action_scopes=["INSTANT"],
                action_parameters=[AgvActionParameter(key="x", value_data_type="NUMBER", is_optional=False)],
                action_result="none",
                blocking_types=["NONE"],
                pause_allowed=False,
                cancel_allowed=False,
            )
        ],
    ),
    mobile_robot_geometry=MobileRobotGeometry(
        wheel_definitions=[
            WheelDefinition(
                type="DRIVE",
                is_active_driven=True,
                is_active_steered=False,
                position=WheelPosition(x=0.0, y=0.1),
                diameter=0.07,
                width=0.02,
            )
        ],
        envelopes2d=[Envelope2d(envelope2d_id="footprint", vertices=[Point(x=0.1, y=0.1), Point(x=-0.1, y=0.0)])],
    ),
    load_specification={"loadPositions": []},
)
ZONE_SET = ZoneSet(
    zone_set=Zones(
        map_id="hall",
        zone_set_id="z1",
        zones=[
            Zone(
                zone_id="a",
                zone_type="SPEED_LIMIT",
                vertices=[Point(x=0.0, y=0.0), Point(x=1.0, y=0.0), Point(x=0.0, y=1.0)],
                maximum_speed=0.2,
            ),
            Zone(
                zone_id="b",
                zone_type="ACTION",
                vertices=[Point(x=0.0, y=0.0), Point(x=1.0, y=0.0), Point(x=0.0, y=1.0)],
                entry_actions=[ZoneAction(action_type="beep", blocking_type="NONE")],
                during_actions=[],
                exit_actions=[],
            ),
        ],
    )
)

MESSAGES: dict[str, Fields] = {
    topics.ORDER: ORDER,
    topics.INSTANT_ACTIONS: InstantActions(
        actions=[Action(action_type="cancelOrder", action_id="i1", blocking_type="NONE")]
    ),
    topics.STATE: STATE,
    topics.CONNECTION: Connection(connection_state="ONLINE"),
    topics.FACTSHEET: FACTSHEET,
    topics.VISUALIZATION: Visualization(
        reference_state_header_id=4,
        mobile_robot_position=POSITION,
        velocity=VELOCITY,
        planned_path=PATH,
        intermediate_path=AHEAD,
    ),
    topics.RESPONSES: Responses(responses=[Response(request_id="r1", grant_type="GRANTED")]),
    topics.ZONE_SET: ZONE_SET,
}
"""Messages by the last level of their topic."""
