"""How fast regulated pure pursuit drives: slower in curves, near obstacles, and towards the end of the path.

After Macenski, Singh, Martín and Ginés, "Regulated pure pursuit for robot path tracking" (2023), as Nav2 has it.
"""

import math

from ppaas.controllers.pure_pursuit.parameters import PurePursuitParameters
from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION


def regulated_speed(parameters: PurePursuitParameters, curvature: float, cost: int, to_go: float) -> float:
    """Return how fast to drive, in either direction [m/s].

    Parameters
    ----------
    parameters : PurePursuitParameters
    curvature : float
        Of the arc [1/m].
    cost : int
        Of the cell the robot is in.
    to_go : float
        Way to the end of the path [m].
    """
    p = parameters
    kept = min(_kept_in_curve(p, curvature), _kept_near_obstacle(p, cost))
    speed = max(p.max_vel_x * kept, p.regulated_linear_scaling_min_speed)
    if to_go < p.approach_velocity_scaling_dist:
        part = to_go / p.approach_velocity_scaling_dist
        speed = min(speed, max(p.max_vel_x * part, p.min_approach_linear_velocity))
    # No faster than it can stop from with half of its braking, nor than it can turn.
    stoppable = max(math.sqrt(p.acc_lim_x * max(to_go, 0.0)), p.min_approach_linear_velocity)
    turnable = p.max_vel_theta / abs(curvature) if curvature else math.inf
    return min(speed, p.max_vel_x, stoppable, turnable)


def _kept_in_curve(p: PurePursuitParameters, curvature: float) -> float:
    if not p.use_regulated_linear_velocity_scaling:
        return 1.0
    tightness = abs(curvature) * p.regulated_linear_scaling_min_radius
    return 1.0 / tightness if tightness > 1.0 else 1.0


def _kept_near_obstacle(p: PurePursuitParameters, cost: int) -> float:
    if not p.use_cost_regulated_linear_velocity_scaling or cost in {FREE_SPACE, NO_INFORMATION}:
        return 1.0
    graded = min(cost, INSCRIBED_INFLATED_OBSTACLE - 1) / (INSCRIBED_INFLATED_OBSTACLE - 1)
    distance = p.robot_radius - math.log(graded) / p.inflation_cost_scaling_factor
    return min(1.0, p.cost_scaling_gain * distance / p.cost_scaling_dist) if distance < p.cost_scaling_dist else 1.0
