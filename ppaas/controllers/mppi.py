"""Model predictive path integral control: averages hundreds of random command sequences, weighted by their costs.

Williams, Aldrich, Theodorou, *Model Predictive Path Integral Control: From Theory to Parallel Computation* (2017),
with parameters named as in Nav2's MPPI controller.
"""

import math
from collections import deque
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.kernels.clearance import clearance
from ppaas.controllers.kernels.mppi import Base, Critics, Terrain, fill_blocked, roll_out_parallel, roll_out_serial
from ppaas.controllers.motion import advance, in_force
from ppaas.controllers.mppi_parameters import MppiParameters
from ppaas.controllers.obstacles import distance_to_lethal
from ppaas.controllers.path_follower import PathFollower
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.kernel_threads import limit_threads
from ppaas.parameters import read_parameters
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.weights import FACTOR, NEUTRAL, passable

# -- random deviations of the command sequences ------------------------------------------------------------------------

MEMORY = 0.8
"""Correlation of successive deviations, since motors cannot follow white noise."""


def draw(parameters: MppiParameters) -> NDArray[np.float64]:
    """Return deviations (batch_size, time_steps, 2) of forward and turning speed [m/s, rad/s]; the first is zero.

    Each deviation has a mirror image that turns the other way, so that the controller prefers no side.
    """
    p = parameters
    half = (p.batch_size + 1) // 2
    white = np.random.default_rng(p.seed).standard_normal((half, p.time_steps, 2))
    deviations = white.copy()
    for step in range(1, p.time_steps):
        deviations[:, step] = MEMORY * deviations[:, step - 1] + np.sqrt(1.0 - MEMORY**2) * white[:, step]
    deviations *= (p.vx_std, p.wz_std)
    both = np.empty((2 * half, p.time_steps, 2))
    both[0::2] = deviations
    both[1::2] = deviations * (1.0, -1.0)
    both[0] = 0.0
    return both[: p.batch_size]


# -- terrain of the rollouts -------------------------------------------------------------------------------------------

HIGHEST = INSCRIBED_INFLATED_OBSTACLE - 1
"""Highest cost of a cell that a robot may enter."""

FAR = 1e3
"""Travel time of cells from which no path leads to the goal [s]."""


def terrain_of(request: ControlRequest, path: FollowedPath, parameters: MppiParameters) -> Terrain:
    """Return the terrain of this cycle.

    Travel times are for the cheapest path, at full speed, to the last free point of the plan within the costmap;
    cells near obstacles cost more, as for global planners.

    Raises
    ------
    NoValidControl
        No point of the plan is free, or no path leads there from the robot.
    """
    costmap = _with_way_out(request.costmap, request.pose, parameters.robot_radius)
    resolution = costmap.info.resolution
    field = CostField(costmap, _end(request.costmap, path, parameters), allow_unknown=parameters.allow_unknown)
    field.grow()
    seconds = (field.values() * (resolution / (NEUTRAL * parameters.max_vel_x))).astype(np.float32)
    here = costmap.info.cell_of(request.pose.x, request.pose.y)
    if here is None or not math.isfinite(seconds[here]):
        raise NoValidControl("no path leads along the plan within the local costmap; plan again or recover")
    worst = resolution * (NEUTRAL + FACTOR * HIGHEST) / (NEUTRAL * parameters.max_vel_x)
    fill_blocked(seconds, worst, FAR)
    distance = distance_to_lethal(costmap, allow_unknown=parameters.allow_unknown)
    return Terrain(distance, seconds, resolution, _movers(request, parameters.command_delay))


def _with_way_out(costmap: Costmap, pose: Pose2D, radius: float) -> Costmap:
    """Return the costmap, with inscribed cells around the robot opened if it stands in one, so that it can leave."""
    here = costmap.info.cell_of(pose.x, pose.y)
    if here is None:
        raise NoValidControl("the robot is outside its local costmap; stop until localization is corrected")
    if costmap.data[here] != INSCRIBED_INFLATED_OBSTACLE:
        return costmap
    data = costmap.data.copy()
    reach = math.ceil(2.0 * radius / costmap.info.resolution)
    around = data[max(here[0] - reach, 0) : here[0] + reach + 1, max(here[1] - reach, 0) : here[1] + reach + 1]
    around[around == INSCRIBED_INFLATED_OBSTACLE] = HIGHEST
    return Costmap(data, costmap.info)


def _movers(request: ControlRequest, delay: float) -> NDArray[np.float64]:
    """Return moving obstacles (m, 5) at the time of the next command: x, y, vx, vy, radius in the grid's frame."""
    frame = request.costmap.info.origin.inverse()
    turn = Pose2D(0.0, 0.0, frame.theta)
    rows = np.empty((len(request.movers), 5))
    for row, mover in zip(rows, request.movers, strict=True):
        position, velocity = frame @ Pose2D(*mover.after(delay)[:2]), turn @ Pose2D(mover.vx, mover.vy)
        row[:] = position.x, position.y, velocity.x, velocity.y, mover.radius
    return rows


def _end(costmap: Costmap, path: FollowedPath, parameters: MppiParameters) -> NDArray[np.int64]:
    """Return row, column of the last free cell of the plan within the costmap, as one row."""
    points, _ = path.ahead(math.inf, costmap)
    cells = costmap.info.to_cells(points)
    cells = cells[((cells >= 0) & (cells < costmap.info.shape)).all(axis=1)]
    free = passable(parameters.allow_unknown)[costmap.data[cells[:, 0], cells[:, 1]]]
    if not free.any():
        raise NoValidControl("no point of the plan is free within the local costmap; plan again or recover")
    return cells[free][-1:]


# -- the controller ----------------------------------------------------------------------------------------------------

Floats = NDArray[np.float64]

ROUNDING = 1e-4
"""Slack of a clearance, so that a robot that does not move keeps it in spite of rounding [m]."""


class PathIntegral(PathFollower):
    """Drives a differential drive of any outline along a plan, as fast as nearby obstacles allow.

    Each cycle starts from the command sequence of the last one. Random variations of it are rolled out from the pose
    to which the commands sent so far will bring the robot, and their mean, weighted by cost, becomes the new sequence.
    Its first command is sent. Within the tolerance of the goal it stops and turns as `dwa` does.

    Parameters
    ----------
    **parameters
        The fields of `MppiParameters`.
    """

    name: ClassVar[str] = "mppi"
    purpose: ClassVar[str] = "Path integral: drives fast through narrow places, by the robot's outline and its motors."
    predicts: ClassVar[bool] = True

    def __init__(self, **parameters: Any) -> None:
        self.parameters = read_parameters(MppiParameters, self.name, parameters)
        p = self.parameters
        super().__init__(p)
        self._noise = draw(p)
        # Stopping and turning in place to either side are always tried too.
        self._plain = np.array((((0.0, 0.0),), ((0.0, p.max_vel_theta),), ((0.0, -p.max_vel_theta),)))
        self._sequence: Floats = np.zeros((p.time_steps, 2))
        self._sent: deque[Velocity] = deque([Velocity()], maxlen=64)

    @property
    def known_delay(self) -> float:
        """The parameters ``command_delay`` and ``motor_lag`` [s]."""
        return self.parameters.command_delay + self.parameters.motor_lag

    def compute_velocity(self, request: ControlRequest) -> Velocity:
        """Return the velocity for this cycle.

        Raises
        ------
        NoValidControl
            Every sequence would collide, or no path leads on: the caller must stop.
        InvalidInput
            No plan was set, or the pose, the velocity or the period is not finite.
        """
        path = self._plan()
        request.check()
        try:
            velocity = self._choose(path, request)
        except NoValidControl:
            self._sequence[:] = 0.0
            self._sent.append(Velocity())
            raise
        self._sent.append(velocity)
        return velocity

    def _choose(self, path: FollowedPath, request: ControlRequest) -> Velocity:
        p, period = self.parameters, request.period
        late = 2.0 * period + p.command_delay + p.motor_lag
        commanded = in_force(self._sent[-1], request.velocity, p, late)
        if self._arrival.arrive(request.pose, path.end):
            self._sequence[:] = 0.0
            return self._arrival.settle(request, path.end, commanded)
        path.locate(request.pose)
        terrain = terrain_of(request, path, p)
        start = self._start(request, commanded)
        self._improve(request, terrain, start, self._fastest(request, path, start))
        linear, angular = self._first(period)
        if self._stands(request.velocity, linear, angular):
            # Commands that are too slow for the base are optimal only near the goal, or if no path leads on.
            if self._arrival.rest(request.pose, path.end):
                return self._arrival.settle(request, path.end, commanded)
            raise NoValidControl(
                f"no command leads on from x={request.pose.x:.3f} y={request.pose.y:.3f}; plan again or recover"
            )
        return Velocity(linear, angular)

    def _fastest(self, request: ControlRequest, path: FollowedPath, start: Floats) -> float:
        """Return the speed above which the robot could not brake before the end of the plan [m/s].

        Sequences are shorter than the way in which heavy bases stop, so their costs alone would brake too late.
        """
        p = self.parameters
        x, y, theta = start[:3].tolist()
        to_go = path.to_go(request.costmap.info.origin @ Pose2D(x, y, theta))
        late = request.period + p.motor_lag
        stoppable = p.acc_lim_x * (math.sqrt(late**2 + 2.0 * to_go / p.acc_lim_x) - late)
        return max(min(request.speed_limit.of(p.max_vel_x, p.min_vel_trans), stoppable), p.min_vel_trans)

    def _stands(self, measured: Velocity, linear: float, angular: float) -> bool:
        """Return whether the robot stands still and would go on to: the commands are too slow for the base."""
        p = self.parameters
        moves = abs(measured.linear) > p.trans_stopped_vel or abs(measured.angular) > p.rot_stopped_vel
        return (
            not moves
            and np.abs(self._sequence[:, 0]).max() < p.min_vel_trans
            and (np.abs(self._sequence[:, 1]).max() < p.min_vel_theta)
        )

    def _start(self, request: ControlRequest, commanded: Velocity) -> Floats:
        """Return pose, velocity and last command at the time the next command takes effect, in the grid's frame."""
        p, period = self.parameters, request.period
        pose, velocity = request.costmap.info.origin.inverse() @ request.pose, request.velocity
        left, age = p.command_delay, math.ceil(p.command_delay / period - 1e-9)
        for k in range(age, 0, -1):
            # The command sent k cycles ago is effective until the next one arrives.
            seconds = left - (k - 1) * period
            target = self._sent[-k] if k <= len(self._sent) else Velocity()
            pose, velocity = self._drive(pose, velocity, target, seconds)
            left -= seconds
        return np.array((*pose, *velocity, *commanded))

    def _drive(self, pose: Pose2D, velocity: Velocity, target: Velocity, seconds: float) -> tuple[Pose2D, Velocity]:
        p = self.parameters
        steps = max(1, math.ceil(seconds / (0.5 * p.model_dt)))
        dt = seconds / steps
        part = _part(p.motor_lag, dt)
        for _ in range(steps):
            reached = Velocity(
                velocity.linear + part * (target.linear - velocity.linear),
                velocity.angular + part * (target.angular - velocity.angular),
            )
            mean = Velocity(0.5 * (velocity.linear + reached.linear), 0.5 * (velocity.angular + reached.angular))
            pose, velocity = advance(pose, mean, dt), reached
        return pose, velocity

    def _improve(self, request: ControlRequest, terrain: Terrain, start: Floats, fastest: float) -> None:
        p = self.parameters
        base = self._base(fastest)
        x, y, theta = start[:3].tolist()
        free = clearance(terrain.distance, terrain.resolution, self._body, x, y, math.cos(theta), math.sin(theta))
        critics = Critics(
            p.collision_cost, min(p.collision_margin_distance, free - ROUNDING), p.critical_weight, p.critical_distance,
            p.repulsion_weight, p.inflation_length, p.prefer_forward_weight, p.turn_weight,
            p.moving_weight, p.moving_distance,
        )  # fmt: skip
        self._sequence = _shifted(self._sequence, request.period / p.model_dt)
        for _ in range(p.iteration_count):
            commands = self._sequence + self._noise
            commands[1:4] = self._plain
            with limit_threads(request.threads) as threads:
                roll_out = roll_out_serial if threads == 1 else roll_out_parallel
                costs = roll_out(commands, start, terrain, base, self._body, critics)
            best = int(np.argmin(costs))
            if costs[best] >= p.collision_cost:
                raise NoValidControl("every command sequence would collide; stop, then plan again or recover")
            self._sequence = self._mean(commands, costs)
            checked = self._sequence[None].copy()
            if roll_out_serial(checked, start, terrain, base, self._body, critics)[0] >= p.collision_cost:
                checked[0] = commands[best]
            self._sequence = checked[0]

    def _mean(self, commands: Floats, costs: Floats) -> Floats:
        """Return the mean of the sequences, weighted by exp(-cost / temperature)."""
        p = self.parameters
        change = commands - self._sequence
        effort = 0.5 * p.gamma * np.einsum("nki,nki->n", change, change / np.square((p.vx_std, p.wz_std)))
        total = costs + p.temperature * effort
        weights = np.exp((total.min() - total) / p.temperature)
        weights /= weights.sum()
        mean: Floats = np.einsum("n,nki->ki", weights, commands)
        return mean

    def _base(self, fastest: float) -> Base:
        p = self.parameters
        return Base(
            p.model_dt, p.max_vel_x, fastest, max(p.min_vel_x, -fastest), p.max_vel_theta, p.acc_lim_x * p.model_dt,
            p.acc_lim_theta * p.model_dt, _part(p.motor_lag, p.model_dt),
        )  # fmt: skip

    def _first(self, period: float) -> tuple[float, float]:
        """Return the velocity to send: the mean of the commands until the next cycle."""
        p = self.parameters
        steps = max(1, min(round(period / p.model_dt), p.time_steps))
        linear, angular = self._sequence[:steps].mean(axis=0).tolist()
        return linear, angular


def _part(lag: float, dt: float) -> float:
    """Return the part of the difference to the command by which motors get nearer within ``dt`` [s]."""
    return -math.expm1(-dt / lag) if lag > 0.0 else 1.0


def _shifted(sequence: Floats, steps: float) -> Floats:
    """Return a sequence shifted by a number of steps; its last command is repeated."""
    at = np.arange(len(sequence)) + steps
    return np.stack([np.interp(at, np.arange(len(sequence)), sequence[:, axis]) for axis in (0, 1)], axis=-1)
