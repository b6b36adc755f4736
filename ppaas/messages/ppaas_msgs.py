"""``ppaas_msgs``: types of this project that ROS has no type for."""

from msgspec import field

from ppaas.messages.base.message import Empty, Message, OwnMessage, ServiceType
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist


class ComputePathRequest(Message):
    """``ppaas_msgs/ComputePath`` request.

    Parameters
    ----------
    start, goal : Pose
        In the frame of the map.
    planner : str
        Name or ROS alias of a global planner; empty for the server's default planner.
    tolerance : float
        If the goal is blocked, plan to the nearest free position within this distance [m].
    timeout : float
        Time limit for planning [s].
    reuse : bool
        Whether a stored plan may be returned if it is available sooner than a computed one.
    parameters : str
        Parameters of the planner and the global costmap that differ from the usual ones, as a JSON object; empty for
        none. A robot plans with its file's parameters and refuses others.
    """

    start: Pose
    goal: Pose
    planner: str = ""
    tolerance: float = 0.0
    timeout: float = 5.0
    reuse: bool = True
    parameters: str = ""


class ComputePathResponse(OwnMessage):
    """``ppaas_msgs/ComputePath`` response.

    Parameters
    ----------
    poses : str
        Poses from start to goal in the frame of the map, as JSON: a list of rows [x, y, z [m], qx, qy, qz, qw]. They
        are encoded within the message, so that thousands of numbers are passed on without being parsed.
    cost : float
        Sum of the weights of all moves.
    length : float
        Length of the path [m].
    expanded : int
        Number of expanded cells.
    seconds : float
        Planning time [s].
    planner : str
        Name of the planner.
    plan_id : str
        Id under which the plan may be stored; equal plans have equal ids.
    origin : str
        ``computed``, or ``reused`` for a stored plan, or ``stitched`` for a stored plan with new ends.
    reused : str
        Id of the stored plan.
    conditions : str
        Conditions of the plan as JSON: the planner's parameters and what else a plan is stored with.
    """

    poses: str
    cost: float
    length: float
    expanded: int
    seconds: float
    planner: str
    plan_id: str = ""
    origin: str = "computed"
    reused: str = ""
    conditions: str = "{}"


ComputePath = ServiceType("ppaas_msgs/ComputePath", ComputePathRequest, ComputePathResponse)


class ComputeCostsRequest(Message):
    """``ppaas_msgs/ComputeCosts`` request.

    Parameters
    ----------
    starts, goals : list of Pose
        In the frame of the map; headings are ignored.
    timeout : float
        Time limit for the whole request [s].
    parameters : str
        ``allow_unknown`` and parameters of the global costmap, as a JSON object; empty for the usual ones.
    """

    starts: list[Pose]
    goals: list[Pose]
    timeout: float = 5.0
    parameters: str = ""


class ComputeCostsResponse(OwnMessage):
    """``ppaas_msgs/ComputeCosts`` response.

    Parameters
    ----------
    costs : str
        Costs of the cheapest paths as JSON: a row for each start with a number for each goal, null if there is no path.
    seconds : float
        Computing time [s].
    """

    costs: str
    seconds: float


ComputeCosts = ServiceType("ppaas_msgs/ComputeCosts", ComputeCostsRequest, ComputeCostsResponse)

# -- other robots on the same map --------------------------------------------------------------------------------------


class RobotState(OwnMessage):
    """``ppaas_msgs/RobotState``: a ``PoseWithCovarianceStamped`` with more fields, from a robot to others on its map.

    Parameters
    ----------
    pose : PoseWithCovariance
        In ``header.frame_id``.
    twist : Twist
        Velocity of the robot, in its own frame.
    radius : float
        Circumscribed radius of its footprint [m]; 0 if unknown.
    granted : bool
        Whether it drives by grants of the traffic node of its user, and has not left what it holds.
    """

    header: Header
    pose: PoseWithCovariance
    twist: Twist = field(default_factory=Twist)
    radius: float = 0.0
    granted: bool = False


class RobotStates(OwnMessage):
    """``ppaas_msgs/RobotStates``: the other robots on a map, with all fields of ``geometry_msgs/PoseArray``.

    Parameters
    ----------
    poses : list of Pose
        In ``header.frame_id``.
    twists : list of Twist
        Velocity of each robot, in its own frame; empty if unknown.
    radii : list of float
        Circumscribed radius of each robot [m], 0 if unknown; empty if all are unknown.
    granted : list of bool
        Whether each is of the same user and drives by grants of its traffic node; empty if none does.
    names : list of str
        Id of each robot of the same user, empty texts for other users' robots; empty if all are.
    """

    header: Header
    poses: list[Pose]
    twists: list[Twist] = field(default_factory=list)
    radii: list[float] = field(default_factory=list)
    granted: list[bool] = field(default_factory=list)
    names: list[str] = field(default_factory=list)


# -- the node monitor, which decides which nodes run on the robot ------------------------------------------------------


class NodeHome(OwnMessage):
    """``ppaas_msgs/NodeHome``: the current and the wanted home of a node.

    Parameters
    ----------
    node : str
        Name of the node.
    home : str
        ``cloud`` or ``robot``.
    wanted : str
        ``cloud`` or ``robot``, by the verdict of the node monitor.
    score : float
        From −1 (all criteria favour the robot) to 1 (all favour the cloud).
    reasons : list of str
        Reasons for the verdict, the most important first.
    """

    node: str
    home: str = "cloud"
    wanted: str = "cloud"
    score: float = 0.0
    reasons: list[str] = field(default_factory=list)


class NodeHomes(OwnMessage):
    """``ppaas_msgs/NodeHomes``: the homes of all nodes of a clone."""

    nodes: list[NodeHome]


ListNodes = ServiceType("ppaas_msgs/ListNodes", Empty, NodeHomes)


class TellRobotRequest(OwnMessage):
    """``ppaas_msgs/TellRobot`` request: a robot reports its processor and its link to the cloud.

    Parameters
    ----------
    cores : int
        Number of CPU cores.
    clock : float
        Clock rate [GHz].
    benchmark : float
        Speed of one core, relative to a Raspberry Pi 4.
    rtt : float
        Round-trip time of the link [s].
    bandwidth : float
        Bandwidth of the link [bytes/s].
    nodes : list of str
        Names of the nodes that the robot can run.
    """

    cores: int
    clock: float
    benchmark: float
    rtt: float
    bandwidth: float
    nodes: list[str] = field(default_factory=list)


class TellRobotResponse(OwnMessage):
    """``ppaas_msgs/TellRobot`` response.

    Parameters
    ----------
    config : str
        Configuration of the nodes as JSON: the arguments of a clone, without its map.
    power : float
        Computing power of the robot, in cores of a Raspberry Pi 4.
    """

    config: str
    power: float


TellRobot = ServiceType("ppaas_msgs/TellRobot", TellRobotRequest, TellRobotResponse)


class RunNodeRequest(OwnMessage):
    """``ppaas_msgs/RunNode`` request: run a node in the cloud or on the robot.

    Parameters
    ----------
    node : str
        Name of the node.
    home : str
        ``cloud`` or ``robot``; empty lets the node monitor decide.
    """

    node: str
    home: str = ""


RunNode = ServiceType("ppaas_msgs/RunNode", RunNodeRequest, NodeHome)


class TopicMessage(OwnMessage):
    """``ppaas_msgs/TopicMessage``: a message that was published on a topic.

    Parameters
    ----------
    topic : str
        Name of the topic.
    message : str
        The message as JSON.
    """

    topic: str
    message: str


class LogPart(OwnMessage):
    """``ppaas_msgs/LogPart``: entry of the log of a node, which grows, unlike its checkpoint.

    Parameters
    ----------
    number : int
        Place in the order of the entries.
    data : bytes
        The entry; base64 in JSON.
    """

    number: int
    data: bytes


class HoldNodeRequest(OwnMessage):
    """``ppaas_msgs/HoldNode`` request: the robot takes over a node, or renews its lease of the node.

    Parameters
    ----------
    node : str
        Name of the node.
    lease : int
        The lease from the response to the takeover; 0 takes the node over.
    state : str
        Checkpoint of the node, as JSON.
    seconds : float
        Mean processing time per message since the last request [s]; 0 if there was no message.
    rtt : float
        Round-trip time of the previous call [s]; 0 if unknown.
    heard : list of str
        Fingerprints of the must-arrive messages that the node received before this checkpoint.
    log : list of LogPart
        Entries of its log since the last request that was answered.
    obsolete : list of int
        Numbers of earlier entries that are to be removed.
    """

    node: str
    lease: int = 0
    state: str = ""
    seconds: float = 0.0
    rtt: float = 0.0
    heard: list[str] = field(default_factory=list)
    log: list[LogPart] = field(default_factory=list)
    obsolete: list[int] = field(default_factory=list)


class HoldNodeResponse(OwnMessage):
    """``ppaas_msgs/HoldNode`` response.

    Parameters
    ----------
    lease : int
        Number of the lease; 0 if the robot has lost the lease and the node runs in the cloud.
    state : str
        Checkpoint of the node if this request took it over; else empty.
    unheard : list of TopicMessage
        Must-arrive messages for the node that came since the takeover and are not in ``heard`` of any request so far.
        The robot may have received them in the meantime; it compares fingerprints.
    log : list of LogPart
        Log of the node if this request took it over; else empty.
    """

    lease: int
    state: str = ""
    unheard: list[TopicMessage] = field(default_factory=list)
    log: list[LogPart] = field(default_factory=list)


HoldNode = ServiceType("ppaas_msgs/HoldNode", HoldNodeRequest, HoldNodeResponse)


class GiveNodeRequest(OwnMessage):
    """``ppaas_msgs/GiveNode`` request: the robot gives a node back to the cloud.

    Parameters
    ----------
    node : str
        Name of the node.
    lease : int
        Lease of the robot; 0 if it could not take the node over.
    state : str
        Last checkpoint of the node; empty if it is the one of the previous request.
    failure : str
        Why the robot cannot run the node; empty if there was no failure.
    heard : list of str
        Fingerprints of the must-arrive messages that the node received before this checkpoint.
    log, obsolete : list
        Changes of its log, as in ``HoldNodeRequest``.
    """

    node: str
    lease: int
    state: str = ""
    failure: str = ""
    heard: list[str] = field(default_factory=list)
    log: list[LogPart] = field(default_factory=list)
    obsolete: list[int] = field(default_factory=list)


GiveNode = ServiceType("ppaas_msgs/GiveNode", GiveNodeRequest, NodeHome)


class ProbeLinkRequest(OwnMessage):
    """``ppaas_msgs/ProbeLink`` request: send this number of bytes, by which a robot measures its bandwidth."""

    bytes: int


class ProbeLinkResponse(OwnMessage):
    """``ppaas_msgs/ProbeLink`` response."""

    data: str


ProbeLink = ServiceType("ppaas_msgs/ProbeLink", ProbeLinkRequest, ProbeLinkResponse)
SERVICES = (ComputePath, ComputeCosts, ListNodes, TellRobot, RunNode, HoldNode, GiveNode, ProbeLink)
