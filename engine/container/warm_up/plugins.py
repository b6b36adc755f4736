"""Robot of the warm-up, and its plug-ins."""

from engine.specs.containers import RobotConfig
from ppaas.controllers.registry import CONTROLLERS
from ppaas.navigation.parameters import MoveBaseParameters, recovery_behaviors
from ppaas.planners.registry import PLANNERS
from ppaas.recoveries.registry import RECOVERIES

MODEL = "turtlebot2"
PARAMETERS = {
    "move_base": {"controller_frequency": 250.0},
    "dwa": {"acc_lim_x": 20.0, "acc_lim_theta": 40.0, "xy_goal_tolerance": 0.2, "yaw_goal_tolerance": 1.0},
}
"""Parameters with which the robot runs many control cycles and reaches its goal within a short time."""

ROBOT = RobotConfig("warm-up", MODEL, (0.0, 0.0, 0.0), "dijkstra", "dwa", PARAMETERS)


def load_plugins() -> None:
    """Load the plug-ins of a robot with default settings."""
    PLANNERS.load(ROBOT.base_global_planner)
    CONTROLLERS.load(ROBOT.base_local_planner)
    for behavior in recovery_behaviors(MoveBaseParameters()):
        RECOVERIES.load(behavior.type)
