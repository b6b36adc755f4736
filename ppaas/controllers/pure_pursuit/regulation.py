"""Speed regulation of pure pursuit: slower in curves, near obstacles, and towards the end of the path.

Macenski, Singh, Martín, Ginés, *Regulated Pure Pursuit for Robot Path Tracking* (2023), as implemented in Nav2.
"""

import math

from ppaas.controllers.pure_pursuit.parameters import PurePursuitParameters
from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION


def regulated_speed(parameters: PurePursuitParameters, curvature: float, cost: int, to_go: float) -> float:
    """Return the speed in either direction [m/s].

    Parameters
    ----------
    parameters : PurePursuitParameters
    curvature : float
        Curvature of the arc [1/m].
    cost : int
        Cost of the robot's cell.
    to_go : float
        Remaining distance to the end of the path [m].
    """
    p = parameters
    kept = min(_kept_in_curve(p, curvature), _kept_near_obstacle(p, cost))
    speed = max(p.max_vel_x * kept, p.regulated_linear_scaling_min_speed)
    if to_go < p.approach_velocity_scaling_dist:
        part = to_go / p.approach_velocity_scaling_dist
        speed = min(speed, max(p.max_vel_x * part, p.min_approach_linear_velocity))
    # Slow enough to stop at the end with half the braking allowed, and to turn along the arc.
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
