"""Report on a robot: what its container says of it with each heartbeat, for lists of many robots."""

import msgspec


class StateReport(msgspec.Struct, frozen=True, omit_defaults=True):
    """State of a robot, as its clone and its client know it.

    Parameters
    ----------
    pose : tuple of float, optional
        Last pose: x [m], y [m], yaw [rad] in the frame of the map.
    pose_at : float, optional
        Time at which it came [s since the epoch].
    localization : str
        Reason why the pose is not renewed; empty if it is.
    goal : int, optional
        Status of the last goal, with the numbers of ``actionlib_msgs/GoalStatus``; None before the first.
    goal_text : str
        Reason for a wait, or for the end of the goal.
    left : float, optional
        Length of the path to the goal [m]; None if it is not known.
    frontiers : int, optional
        Number of frontiers left, while the robot explores.
    battery : float, optional
        Charge of the battery, from 0 to 1; None if the robot does not report it.
    software : str
        Software of the robot's client, as the client names it; empty if it does not.
    docked : str
        At which dock it stands, or why it is not charged there; empty elsewhere.
    confirmations : int
        How often somebody at the robot has confirmed its task since its container began.
    """

    pose: tuple[float, float, float] | None = None
    pose_at: float | None = None
    localization: str = ""
    goal: int | None = None
    goal_text: str = ""
    left: float | None = None
    frontiers: int | None = None
    battery: float | None = None
    software: str = ""
    docked: str = ""
    confirmations: int = 0
