"""The robot of the warm-up, and the plug-ins that it has."""

from engine.specs.containers import RobotConfig
from ppaas.controllers.registry import CONTROLLERS
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.navigation.recovery_sequence import recovery_behaviors
from ppaas.planners.registry import PLANNERS
from ppaas.recoveries.registry import RECOVERIES

MODEL = "turtlebot2"
PARAMETERS = {
    "move_base": {"controller_frequency": 250.0},
    "dwa": {"acc_lim_x": 20.0, "acc_lim_theta": 40.0, "xy_goal_tolerance": 0.2, "yaw_goal_tolerance": 1.0},
}
"""Many cycles in a short time, and soon there."""

ROBOT = RobotConfig("warm-up", MODEL, (0.0, 0.0, 0.0), "dijkstra", "dwa", PARAMETERS)


def load_plugins() -> None:
    """Load what a robot has plugged in that asks for nothing else."""
    PLANNERS.load(ROBOT.base_global_planner)
    CONTROLLERS.load(ROBOT.base_local_planner)
    for behavior in recovery_behaviors(MoveBaseParameters()):
        RECOVERIES.load(behavior.type)
