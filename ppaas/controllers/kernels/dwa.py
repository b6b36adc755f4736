"""Kernel: roll each velocity out over the costmap and score what would come of it.

The dynamic window approach of Fox, Burgard and Thrun (1997), with the cost terms of dwa_local_planner: distance to the
path, way still to go, and the highest cost met. All in one frame, that of the plan and the costmap.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.controllers.kernels.clearance import Body, Field, Floats, between, clearance
from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION

ANGULAR_GRANULARITY = 0.1
"""Most that a step of a rollout turns [rad]."""
PATH_CHECKS = 8
"""About so many points of a rollout are measured against the path."""
SLOWEST_OUT = 0.05
"""A robot that leaves an inscribed cell more slowly is rolled out as long as one that is so fast [m/s]."""
BLOCKED = 1_000.0
"""Score of a rollout that ends in an obstacle, though the robot could stop before: worse than any that is free."""


class Frame(NamedTuple):
    """Where the cells of a costmap lie: corner [m], cosine and sine of its turn, edge of a cell [m]."""

    x: float
    y: float
    cosine: float
    sine: float
    resolution: float


class Scoring(NamedTuple):
    """What counts for how much; the names are those of dwa_local_planner where it has the same.

    ``reaction`` is the time until a new command takes effect [s], ``max_vel_x`` the speed in the open [m/s],
    ``leaving`` whether the robot is in an inscribed cell, and ``way_out`` how far it may go there [m].
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


class Outline(NamedTuple):
    """What a robot that is no disc may not touch: its body, distances to obstacles, and how much it must keep [m]."""

    body: Body
    distance: Field
    least: float


@njit(cache=True, nogil=True, error_model="numpy")
def cost_at(costs: NDArray[np.uint8], x: float, y: float) -> int:
    """Return the cost of the cell at a point, from the corner of cell (0, 0) [cells]; 255 outside the costmap."""
    if x >= 0.0 and y >= 0.0 and x < costs.shape[1] and y < costs.shape[0]:
        return int(costs[int(y), int(x)])
    return NO_INFORMATION


@njit(cache=True, nogil=True, error_model="numpy")
def segments_of(path: Floats, remaining: Floats, frame: Frame) -> Floats:
    """Return a polyline as rows for `project`, in the frame of the grid [m].

    A row is a point, the way to the next, one over the square of its length, a quarter of that square, the way still to
    go from the point, and by how much less that is at the next.
    """
    segments = np.zeros((len(path), 8))
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
    return segments


@njit(cache=True, nogil=True, error_model="numpy")
def project(segments: Floats, x: float, y: float, hint: int) -> tuple[float, float, int]:
    """Return how far a point is from a polyline and the way still to go from the nearest point of it [m], and its row.

    ``hint`` is a row that is near. On a segment no point is nearer than that whose square is the lesser of its ends'
    less a quarter of its length's: so most need not be looked at.
    """
    dx, dy = segments[hint, 0] - x, segments[hint, 1] - y
    best, to_go, nearest = dx * dx + dy * dy, segments[hint, 6], hint
    dx, dy = segments[0, 0] - x, segments[0, 1] - y
    here = dx * dx + dy * dy
    if here < best:
        best, to_go, nearest = here, segments[0, 6], 0
    for i in range(len(segments) - 1):
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
    return math.sqrt(best), to_go, nearest


@njit(cache=True, nogil=True, error_model="numpy")
def _score(
    v: float, w: float, costs: NDArray[np.uint8], resolution: float, segments: Floats,
    x: float, y: float, theta: float, scoring: Scoring, outline: Outline,
) -> float:  # fmt: skip
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
    # A disc is free where the inflated costmap says so. Of an outline no point comes nearer by more than it moves.
    blocked = LETHAL_OBSTACLE if len(outline.body.edges) > 0 else INSCRIBED_INFLATED_OBSTACLE
    moves = (abs(v) + outline.body.circumscribed * abs(w)) * dt
    room = 0.0 if len(outline.body.edges) > 0 else math.inf
    # Each step goes along the chord of its arc; the chords turn by the same angle, so one cosine and sine do for all.
    step_x, step_y = v * dt * math.cos(theta + 0.5 * w * dt), v * dt * math.sin(theta + 0.5 * w * dt)
    cosine, sine = math.cos(w * dt), math.sin(w * dt)
    for step in range(1, steps + 1):
        x += step_x
        y += step_y
        step_x, step_y = cosine * step_x - sine * step_y, sine * step_x + cosine * step_y
        cost = cost_at(costs, x * per, y * per)
        if cost == NO_INFORMATION:
            cost = FREE_SPACE if scoring.allow_unknown else LETHAL_OBSTACLE
        room -= moves
        if room <= 0.0:
            room = _room(outline, resolution, x, y, theta + w * dt * step)
        if room < 0.0 or cost == LETHAL_OBSTACLE or (cost >= blocked and not leaving):
            hit_at = (step - 1) * dt  # somewhere in this step
            break
        leaving = leaving and cost == INSCRIBED_INFLATED_OBSTACLE
        if leaving:
            inside += abs(v) * dt
        highest = max(highest, cost)
        if step % every == 0 or step == steps:
            distance, to_go, near = project(segments, x, y, near)
            off_path += distance
            checks += 1
            if to_go <= 0.0 and step * dt >= must_be_free:
                to_go = -abs(v) * (seconds - step * dt)  # there early: as good as having gone on
                break
    if leaving or 0.0 <= hit_at <= must_be_free:
        return math.inf
    if hit_at >= 0.0:
        return BLOCKED * (2.0 - hit_at / seconds) + abs(v)
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


@njit(cache=True, nogil=True, error_model="numpy")
def _room(outline: Outline, resolution: float, x: float, y: float, theta: float) -> float:
    """Return how far each point of a robot may move before it must be looked at again [m]; negative if it touches."""
    body = outline.body
    beyond = between(outline.distance, x / resolution, y / resolution) - body.circumscribed
    if beyond > outline.least + resolution:
        return beyond - outline.least - 0.5 * resolution  # whichever way it turns
    free = clearance(outline.distance, resolution, body, x, y, math.cos(theta), math.sin(theta))
    if free < outline.least:
        return -1.0
    # What is between two looks at the outline may be nearer by an eighth, and as much may be interpolated away.
    return max(0.75 * free - outline.least, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def score_velocities(
    velocities: Floats, costs: NDArray[np.uint8], frame: Frame, path: Floats, remaining: Floats,
    x: float, y: float, theta: float, scoring: Scoring, outline: Outline,
) -> Floats:  # fmt: skip
    """Score velocities by what would come of each if it were kept; less is better.

    A rollout must be free until the robot could have stopped: else its score is infinite. One that meets an obstacle
    later scores `BLOCKED` and more, the sooner the more. The robot is a disc, so a point is free if the inflated
    costmap has less than 253 there. A robot that is in a 253 already may go on through 253 until it has left it, if it
    does so within the ``way_out``; each metre of that scores `BLOCKED`, so that the shortest is taken.

    A robot with an outline is free where that keeps its clearance, whatever the inflated costmap says of its disc.

    Parameters
    ----------
    velocities : (n, 2) array
        Forward [m/s], turning [rad/s].
    costs : (height, width) uint8 array
        Local costmap, inflated for the robot's radius.
    frame : Frame
        Where it lies.
    path : (m, 2) array
        Points of the plan ahead [m], at least one.
    remaining : (m,) array
        Way along the plan from each to the last [m].
    x, y, theta : float
        Where the rollouts begin [m, rad].
    scoring : Scoring
    outline : Outline
        Of a body without edges for a disc.

    Returns
    -------
    (n,) array
    """
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
    """Compile and call each kernel once, for a costmap of its own, a read-only one and one cut out of another."""
    scoring = Scoring(1.0, 0.1, 0.1, 1.0, 1.0, 1.0, 1.0, 1.0, 0.1, 0.5, True, False, 0.4)
    costs = np.zeros((2, 2), np.uint8)
    read_only = costs.copy()
    read_only.flags.writeable = False
    frame = Frame(0.0, 0.0, 1.0, 0.0, 1.0)
    outline = Outline(Body(np.zeros((0, 5)), 0.18, 0.18), np.ones((2, 2), np.float32), 0.0)
    for cells in (costs, read_only, np.zeros((4, 4), np.uint8)[1:3, 1:3]):
        score_velocities(np.ones((1, 2)), cells, frame, np.zeros((1, 2)), np.zeros(1), 0.5, 0.5, 0.0, scoring, outline)
