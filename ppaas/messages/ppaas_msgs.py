"""``ppaas_msgs``: what ROS has no type for."""

from msgspec import field

from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist
from ppaas.messages.message import Empty, Message, ServiceType
from ppaas.messages.std_msgs import Header


class ComputePathRequest(Message):
    """``ppaas_msgs/ComputePath`` request.

    Parameters
    ----------
    start, goal : Pose
        In the frame of the map.
    planner : str
        Name or ROS alias of a global planner; empty for the one that the server was made with.
    tolerance : float
        If the goal is blocked, a free place within this distance will do [m].
    timeout : float
        Longest time to plan [s].
    reuse : bool
        Whether a plan that is kept will do where it comes sooner than one that is computed.
    """

    start: Pose
    goal: Pose
    planner: str = ""
    tolerance: float = 0.0
    timeout: float = 5.0
    reuse: bool = True


class ComputePathResponse(Message):
    """``ppaas_msgs/ComputePath`` response.

    Parameters
    ----------
    poses : str
        From start to goal, in the frame of the map: JSON, a list of rows [x, y, z [m], qx, qy, qz, qw]. It is text
        within the message, so that thousands of numbers are handed on as they were written.
    cost : float
        Sum of the weights of the moves.
    length : float
        Along the poses [m].
    expanded : int
        Cells that were settled.
    seconds : float
        Time it took.
    planner : str
        Who planned.
    plan_id : str
        By which the plan may be kept: of the same plan the same.
    origin : str
        Whether it was ``computed``, or a plan that is kept was ``reused``, or ``stitched`` to the ends.
    reused : str
        Id of that plan.
    conditions : str
        Under which it was made: JSON, the parameters of the planner and what else a plan is kept with.
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
        In the frame of the map; headings do not count.
    timeout : float
        Longest time for all of it [s].
    """

    starts: list[Pose]
    goals: list[Pose]
    timeout: float = 5.0


class ComputeCostsResponse(Message):
    """``ppaas_msgs/ComputeCosts`` response.

    Parameters
    ----------
    costs : str
        What the cheapest path costs: JSON, a row for each start, a number in it for each goal, null where no way leads.
    seconds : float
        Time it took.
    """

    costs: str
    seconds: float


ComputeCosts = ServiceType("ppaas_msgs/ComputeCosts", ComputeCostsRequest, ComputeCostsResponse)

# -- robots of the same map --------------------------------------------------------------------------------------------


class RobotState(Message):
    """``ppaas_msgs/RobotState``: what a robot tells those of its map.

    It has all of ``geometry_msgs/PoseWithCovarianceStamped``.

    Parameters
    ----------
    pose : PoseWithCovariance
        In ``header.frame_id``.
    twist : Twist
        How fast it drives, in its own frame.
    radius : float
        Of the disc that holds it [m]; 0 if that is not known.
    """

    header: Header
    pose: PoseWithCovariance
    twist: Twist = field(default_factory=Twist)
    radius: float = 0.0


class RobotStates(Message):
    """``ppaas_msgs/RobotStates``: the other robots of a map.

    It has all of ``geometry_msgs/PoseArray``.

    Parameters
    ----------
    poses : list of Pose
        In ``header.frame_id``.
    twists : list of Twist
        How fast each drives, in its own frame; empty if that is not known.
    radii : list of float
        Of the discs that hold them [m], 0 of one that is not known; empty if none is.
    """

    header: Header
    poses: list[Pose]
    twists: list[Twist] = field(default_factory=list)
    radii: list[float] = field(default_factory=list)


# -- the node monitor: which of its nodes a robot runs itself ----------------------------------------------------------


class NodeHome(Message):
    """``ppaas_msgs/NodeHome``: where a node runs, and where the node monitor wants it.

    Parameters
    ----------
    node : str
        Its name.
    home : str
        ``cloud`` or ``robot``.
    wanted : str
        The same, as the verdict says.
    score : float
        From −1, all speaks for the robot, to 1, all speaks for the cloud.
    reasons : list of str
        What the verdict rests on, what counts most first.
    """

    node: str
    home: str = "cloud"
    wanted: str = "cloud"
    score: float = 0.0
    reasons: list[str] = field(default_factory=list)


class NodeHomes(Message):
    """``ppaas_msgs/NodeHomes``: all nodes of a robot's clone."""

    nodes: list[NodeHome]


ListNodes = ServiceType("ppaas_msgs/ListNodes", Empty, NodeHomes)


class TellRobotRequest(Message):
    """``ppaas_msgs/TellRobot`` request: what a robot has to run nodes on, and how it reaches the cloud.

    Parameters
    ----------
    cores : int
        Of its processor.
    clock : float
        [GHz].
    benchmark : float
        How fast one core is, where a Raspberry Pi 4 is 1.
    rtt : float
        There and back over its link [s].
    bandwidth : float
        Of its link [bytes/s].
    nodes : list of str
        Names of the nodes that it can run.
    """

    cores: int
    clock: float
    benchmark: float
    rtt: float
    bandwidth: float
    nodes: list[str] = field(default_factory=list)


class TellRobotResponse(Message):
    """``ppaas_msgs/TellRobot`` response.

    Parameters
    ----------
    config : str
        What its nodes are made of: JSON, the arguments of a clone but its map.
    power : float
        What the robot is worth, in cores of a Raspberry Pi 4.
    """

    config: str
    power: float


TellRobot = ServiceType("ppaas_msgs/TellRobot", TellRobotRequest, TellRobotResponse)


class RunNodeRequest(Message):
    """``ppaas_msgs/RunNode`` request: run a node, wherever it does best.

    Parameters
    ----------
    node : str
        Its name.
    home : str
        ``cloud`` or ``robot`` to have it there; empty for where the node monitor finds best.
    """

    node: str
    home: str = ""


RunNode = ServiceType("ppaas_msgs/RunNode", RunNodeRequest, NodeHome)


class TopicMessage(Message):
    """``ppaas_msgs/TopicMessage``: what was published on a topic.

    Parameters
    ----------
    topic : str
        Its name.
    message : str
        As JSON.
    """

    topic: str
    message: str


class HoldNodeRequest(Message):
    """``ppaas_msgs/HoldNode`` request: the robot takes a node over, or says that it still runs it.

    Parameters
    ----------
    node : str
        Its name.
    lease : int
        What the answer said when the node was taken over; 0 takes it over.
    state : str
        Its checkpoint: JSON.
    seconds : float
        What it took for each thing that it was told since the last time, in the mean [s]; 0 if it was told nothing.
    rtt : float
        There and back over the link, as the call before took [s]; 0 if it is not known.
    heard : list of str
        Fingerprints of what must arrive, and had reached the node before that state.
    """

    node: str
    lease: int = 0
    state: str = ""
    seconds: float = 0.0
    rtt: float = 0.0
    heard: list[str] = field(default_factory=list)


class HoldNodeResponse(Message):
    """``ppaas_msgs/HoldNode`` response.

    Parameters
    ----------
    lease : int
        0: the node is no longer the robot's, and runs in the cloud.
    state : str
        The node's checkpoint where it was taken over; else empty.
    unheard : list of TopicMessage
        What must arrive at the node, came since it was taken over, and is not in ``heard`` of any request so far. The
        robot may have it by now: it goes by the fingerprints.
    """

    lease: int
    state: str = ""
    unheard: list[TopicMessage] = field(default_factory=list)


HoldNode = ServiceType("ppaas_msgs/HoldNode", HoldNodeRequest, HoldNodeResponse)


class GiveNodeRequest(Message):
    """``ppaas_msgs/GiveNode`` request: the robot runs a node no more.

    Parameters
    ----------
    node : str
        Its name.
    lease : int
        Under which the robot had it; 0 if it could not take it over.
    state : str
        Its last checkpoint; empty for the one told before.
    failure : str
        Why it could not be run there; empty if it only goes back.
    heard : list of str
        Fingerprints of what must arrive, and had reached the node before that state.
    """

    node: str
    lease: int
    state: str = ""
    failure: str = ""
    heard: list[str] = field(default_factory=list)


GiveNode = ServiceType("ppaas_msgs/GiveNode", GiveNodeRequest, NodeHome)


class ProbeLinkRequest(Message):
    """``ppaas_msgs/ProbeLink`` request: send so many bytes, by which a robot measures its link."""

    bytes: int


class ProbeLinkResponse(Message):
    """``ppaas_msgs/ProbeLink`` response."""

    data: str


ProbeLink = ServiceType("ppaas_msgs/ProbeLink", ProbeLinkRequest, ProbeLinkResponse)

SERVICES = (ComputePath, ComputeCosts, ListNodes, TellRobot, RunNode, HoldNode, GiveNode, ProbeLink)
