"""Kernel: rolls out velocities over the costmap and scores the resulting trajectories.

Fox, Burgard, Thrun, *The Dynamic Window Approach to Collision Avoidance* (1997), with the cost terms of
dwa_local_planner: distance to the path, remaining distance along it, and the highest cost on the trajectory. Inputs are
in the common frame of plan and costmap; rollouts run in the frame of the grid.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.kernels.clearance import Field, Floats, RobotOutline, bilinear, clearance
from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.kernel_cache.decorators import compiled

ANGULAR_GRANULARITY = 0.1
"""Largest turn in a step of a rollout [rad]."""

PATH_CHECKS = 8
"""Approximate number of points of a rollout whose distance to the path is measured."""

SLOWEST_OUT = 0.05
"""Lower limit of the speed from which the duration of a rollout out of an inscribed cell is computed [m/s]."""

FARTHER = 4.0
"""Distance of a point of the path, in lengths of its longest segment, from which it is tried to skip segments."""

SAFE = 1e-6
"""Part of a segment that rounding may take."""

BLOCKED = 1_000.0
"""Score of a rollout that ends in an obstacle although the robot could stop before; higher than any free one."""


class Frame(NamedTuple):
    """Frame of a costmap's grid: origin [m], cosine and sine of its rotation, and edge of a cell [m]."""

    x: float
    y: float
    cosine: float
    sine: float
    resolution: float


class Scoring(NamedTuple):
    """Weights and limits of the score, named as in dwa_local_planner where it has them.

    ``reaction`` is the time until a new command takes effect [s], ``max_vel_x`` the speed in free space [m/s],
    ``leaving`` whether the robot starts in an inscribed cell, and ``way_out`` how far it may drive in such cells [m].
    The other fields are explained in `ppaas.controllers.dwa.parameters.DwaParameters`.
    """

    sim_time: float
    sim_granularity: float
    reaction: float
    acc_lim_x: float
    max_vel_x: float
    path_distance_bias: float
    goal_distance_bias: float
    occdist_scale: float
    forward_point_distance: float
    cost_slowdown: float
    allow_unknown: bool
    leaving: bool
    way_out: float


class OutlineCheck(NamedTuple):
    """Collision check of a robot that is not a disc.

    Parameters
    ----------
    body : RobotOutline
        Outline of the robot; without edges for a disc, which is checked against the inflated costmap.
    distance : (h, w) float32 array
        Distance from each cell's centre to that of the nearest occupied cell [m].
    least : float
        Clearance that the robot must keep [m].
    """

    body: RobotOutline
    distance: Field
    least: float


@compiled
def cost_at(costs: NDArray[np.uint8], x: float, y: float) -> int:
    """Return the cost at a point in the frame of the grid [cells], or 255 (unknown) outside the costmap."""
    if x >= 0.0 and y >= 0.0 and x < costs.shape[1] and y < costs.shape[0]:
        return int(costs[int(y), int(x)])
    return NO_INFORMATION


@compiled
def segments_of(path: Floats, remaining: Floats, frame: Frame) -> Floats:
    """Return a polyline as an array (m, 9) for `project`, in the frame of the grid [m].

    Columns: x, y of a point; x, y of the vector to the next point; 1 / squared length of that vector; a quarter of the
    squared length; remaining distance from the point to the end; its change to the next point; and in the first row the
    length of the longest segment.
    """
    segments = np.zeros((len(path), 9))
    for i in range(len(path)):
        dx, dy = path[i, 0] - frame.x, path[i, 1] - frame.y
        segments[i, 0] = frame.cosine * dx + frame.sine * dy
        segments[i, 1] = frame.cosine * dy - frame.sine * dx
        segments[i, 6] = remaining[i]
    for i in range(len(path) - 1):
        bx, by = segments[i + 1, 0] - segments[i, 0], segments[i + 1, 1] - segments[i, 1]
        length = bx * bx + by * by
        segments[i, 2], segments[i, 3] = bx, by
        segments[i, 4] = 1.0 / length if length > 0.0 else 0.0
        segments[i, 5] = 0.25 * length
        segments[i, 7] = remaining[i + 1] - remaining[i]
        segments[0, 8] = max(segments[0, 8], math.sqrt(length))
    return segments


@compiled
def project(segments: Floats, x: float, y: float, hint: int) -> tuple[float, float, int]:
    """Return the distance of a point to a polyline, the remaining distance from its nearest point, and its row.

    ``hint`` is a row near the point. The squared distance to a segment is at least the smaller one of its ends minus a
    quarter of its squared length, so that most segments can be skipped. Where a point of the polyline is far away, so
    are those that follow it: several segments are skipped at once.
    """
    longest = segments[0, 8]
    dx, dy = segments[hint, 0] - x, segments[hint, 1] - y
    best, to_go, nearest = dx * dx + dy * dy, segments[hint, 6], hint
    dx, dy = segments[0, 0] - x, segments[0, 1] - y
    here = dx * dx + dy * dy
    if here < best:
        best, to_go, nearest = here, segments[0, 6], 0
    i, last, farther = 0, len(segments) - 1, FARTHER * longest
    while i < last:
        if here > farther * farther and here > 4.0 * best:
            # Those segments begin and end at least as far away as the nearest point found.
            skipped = int((math.sqrt(here) - math.sqrt(best)) / longest - SAFE)
            if skipped > 0:
                i += skipped
                if i >= last:
                    break
                dx, dy = segments[i, 0] - x, segments[i, 1] - y
                here = dx * dx + dy * dy
        ex, ey = segments[i + 1, 0] - x, segments[i + 1, 1] - y
        there = ex * ex + ey * ey
        if min(here, there) - segments[i, 5] < best:
            bx, by = segments[i, 2], segments[i, 3]
            t = min(1.0, max(0.0, -(dx * bx + dy * by) * segments[i, 4]))
            off_x, off_y = dx + t * bx, dy + t * by
            distance = off_x * off_x + off_y * off_y
            if distance < best:
                best, to_go, nearest = distance, segments[i, 6] + t * segments[i, 7], i
        dx, dy, here = ex, ey, there
        i += 1
    return math.sqrt(best), to_go, nearest


@compiled
def _score(
    v: float, w: float, costs: NDArray[np.uint8], resolution: float, segments: Floats,
    x: float, y: float, theta: float, scoring: Scoring, outline: OutlineCheck,
) -> float:  # fmt: skip
    """Return the score of one velocity (v, w), rolled out from a pose in the frame of the grid.

    Parameters
    ----------
    v, w : float
        Forward [m/s] and turning [rad/s] speed.
    costs : (height, width) uint8 array
        Local costmap.
    resolution : float
        Edge of a cell [m].
    segments : (m, 9) array
        Path, see `segments_of`.
    x, y, theta : float
        Start of the rollout [m, rad].
    scoring, outline
        See their types.
    """
    # Duration of the rollout: the robot must at least be able to stop, and to leave inscribed cells.
    must_be_free = scoring.reaction + abs(v) / (2.0 * scoring.acc_lim_x)
    seconds = max(scoring.sim_time, must_be_free)
    leaving = scoring.leaving
    if leaving:
        seconds = max(seconds, scoring.way_out / max(abs(v), SLOWEST_OUT))
    steps = max(
        1,
        math.ceil(abs(v) * seconds / scoring.sim_granularity),
        math.ceil(abs(w) * seconds / ANGULAR_GRANULARITY),
    )
    dt, per = seconds / steps, 1.0 / resolution
    every = max(1, steps // PATH_CHECKS)
    highest, off_path, checks, to_go, near = 0, 0.0, 0, 0.0, 0
    inside = 0.0
    hit_at = -1.0
    # A disc collides in inscribed cells of the inflated costmap. An outline needs an exact check only after the motion
    # since the last check may have used up the clearance found there (``room``).
    blocked = LETHAL_OBSTACLE if len(outline.body.edges) > 0 else INSCRIBED_INFLATED_OBSTACLE
    moves = (abs(v) + outline.body.circumscribed * abs(w)) * dt
    room = 0.0 if len(outline.body.edges) > 0 else math.inf
    # Each step follows the chord of its arc. Successive chords turn by the same angle, so one cosine and sine suffice.
    step_x, step_y = v * dt * math.cos(theta + 0.5 * w * dt), v * dt * math.sin(theta + 0.5 * w * dt)
    cosine, sine = math.cos(w * dt), math.sin(w * dt)
    for step in range(1, steps + 1):
        x += step_x
        y += step_y
        step_x, step_y = cosine * step_x - sine * step_y, sine * step_x + cosine * step_y
        cost = cost_at(costs, x * per, y * per)
        if cost == NO_INFORMATION:
            cost = FREE_SPACE if scoring.allow_unknown else LETHAL_OBSTACLE
        # Collision check.
        room -= moves
        if room <= 0.0:
            room = _free_motion(outline, resolution, x, y, theta + w * dt * step)
        if room < 0.0 or cost == LETHAL_OBSTACLE or (cost >= blocked and not leaving):
            hit_at = (step - 1) * dt  # at some time during this step
            break
        leaving = leaving and cost == INSCRIBED_INFLATED_OBSTACLE
        if leaving:
            inside += abs(v) * dt
        highest = max(highest, cost)
        # Distance to the path at some of the steps.
        if step % every == 0 or step == steps:
            distance, to_go, near = project(segments, x, y, near)
            off_path += distance
            checks += 1
            if to_go <= 0.0 and step * dt >= must_be_free:
                to_go = -abs(v) * (seconds - step * dt)  # reached the end early: credit for the remaining time
                break
    if leaving or 0.0 <= hit_at <= must_be_free:
        return math.inf
    if hit_at >= 0.0:
        return BLOCKED * (2.0 - hit_at / seconds) + abs(v)
    # Score of a free rollout: the cost terms of dwa_local_planner, and penalties for speed near obstacles.
    off_path /= checks
    if to_go > scoring.forward_point_distance:
        theta += w * steps * dt
        ahead_x = x + scoring.forward_point_distance * math.cos(theta)
        ahead_y = y + scoring.forward_point_distance * math.sin(theta)
        off_path += project(segments, ahead_x, ahead_y, near)[0]
    allowed = scoring.max_vel_x * (1.0 - scoring.cost_slowdown * highest / INSCRIBED_INFLATED_OBSTACLE)
    too_fast = max(0.0, abs(v) - allowed)
    return (
        scoring.path_distance_bias * off_path
        + scoring.goal_distance_bias * (to_go + 2.0 * scoring.sim_time * too_fast)
        + scoring.occdist_scale * highest
        + BLOCKED * inside
    )


@compiled
def _free_motion(outline: OutlineCheck, resolution: float, x: float, y: float, theta: float) -> float:
    """Return how far each point of the robot may move before the next check [m]; negative if it is too near."""
    body = outline.body
    beyond = bilinear(outline.distance, x / resolution, y / resolution) - body.circumscribed
    if beyond > outline.least + resolution:
        return beyond - outline.least - 0.5 * resolution  # in any direction
    free = clearance(outline.distance, resolution, body, x, y, math.cos(theta), math.sin(theta))
    if free < outline.least:
        return -1.0
    # Sampling of the edges may overestimate the clearance by an eighth, and interpolation by as much.
    return max(0.75 * free - outline.least, 0.0)


@compiled
def score_velocities(
    velocities: Floats, costs: NDArray[np.uint8], frame: Frame, path: Floats, remaining: Floats,
    x: float, y: float, theta: float, scoring: Scoring, outline: OutlineCheck,
) -> Floats:  # fmt: skip
    """Return the scores of velocities from their rollouts; lower is better.

    A rollout must be free until the robot could have stopped; otherwise its score is infinite. A rollout that meets an
    obstacle later scores at least `BLOCKED`, and more the sooner it does. For a disc, a point is free if the inflated
    costmap is below 253 there. A robot that starts in a cell of 253 may drive through such cells until it has left
    them, within ``way_out``; each metre of that adds `BLOCKED`, so that the shortest way out is taken.

    For a robot with an outline, a pose is free if the outline keeps its clearance, regardless of inflated costs.

    Parameters
    ----------
    velocities : (n, 2) array
        Forward [m/s], turning [rad/s].
    costs : (height, width) uint8 array
        Local costmap, inflated for the robot's radius.
    frame : Frame
        Frame of the costmap's grid.
    path : (m, 2) array
        Points of the plan ahead [m], at least one.
    remaining : (m,) array
        Distance along the plan from each point to the last [m].
    x, y, theta : float
        Start of the rollouts [m, rad].
    scoring : Scoring
    outline : OutlineCheck

    Returns
    -------
    (n,) array
    """
    # Path and start in the frame of the grid.
    segments = segments_of(path, remaining, frame)
    dx, dy = x - frame.x, y - frame.y
    x, y = frame.cosine * dx + frame.sine * dy, frame.cosine * dy - frame.sine * dx
    theta -= math.atan2(frame.sine, frame.cosine)
    scores = np.empty(len(velocities))
    for i in range(len(velocities)):
        v, w = velocities[i, 0], velocities[i, 1]
        scores[i] = _score(v, w, costs, frame.resolution, segments, x, y, theta, scoring, outline)
    return scores


def warm() -> None:
    """Call each kernel once, with a writable costmap, a read-only one, and a view of a larger one."""
    scoring = Scoring(1.0, 0.1, 0.1, 1.0, 1.0, 1.0, 1.0, 1.0, 0.1, 0.5, True, False, 0.4)
    costs = np.zeros((2, 2), np.uint8)
    read_only = costs.copy()
    read_only.flags.writeable = False
    frame = Frame(0.0, 0.0, 1.0, 0.0, 1.0)
    outline = OutlineCheck(RobotOutline(np.zeros((0, 5)), 0.18, 0.18), np.ones((2, 2), np.float32), 0.0)
    for cells in (costs, read_only, np.zeros((4, 4), np.uint8)[1:3, 1:3]):
        score_velocities(np.ones((1, 2)), cells, frame, np.zeros((1, 2)), np.zeros(1), 0.5, 0.5, 0.0, scoring, outline)
