"""True visibility of people: the share of a torso that a robot's sensor has in view."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import GridInfo
from ppaas.maps.raycast import cast_rays
from ppaas.messages.people_coordination import SensorView
from robots.sim.laser import Discs, cast_at_discs

Floats = NDArray[np.float64]

TORSO, THIN = 0.2, 0.12
"""Radius of a torso as seen from above, and half of its depth: a person who turns aside hides no more [m]."""

RAYS = 9
"""Number of rays from a sensor to a torso, spread evenly over its width."""

BEYOND, PERHAPS = 1.5, 0.4
"""Multiple of the range up to which people may be seen, and the largest share of those torsos: below half."""


class Surroundings(NamedTuple):
    """Objects that hide people.

    Parameters
    ----------
    occupied : (height, width) bool array
        Cells of walls.
    info : GridInfo
        Geometry of the cells.
    discs : tuple of Discs
        Other objects that are as high as a torso, from above.
    """

    occupied: NDArray[np.bool_]
    info: GridInfo
    discs: tuple[Discs, ...] = ()


def visible_shares(
    surroundings: Surroundings, robot: Pose2D, views: Sequence[SensorView], people: Floats, radius: float = TORSO
) -> Floats:
    """Return the share of each torso that a robot has in view, the largest of its sensors.

    A ray to a point of a torso counts if it is within the field of view and nothing else stops it before the torso. A
    torso whose centre is nearer than the sensor's range, or up to `BEYOND` times its end, has at most share `PERHAPS`:
    detectors find some of these, too. One that is farther away has share 0. A torso that another one hides has up to
    share `PERHAPS`, too, if its sides are in view unless the person in front shows the whole breadth of the shoulders.

    Parameters
    ----------
    surroundings : Surroundings
    robot : Pose2D
        True pose of the robot.
    views : sequence of SensorView
        Views of its sensors.
    people : (n, 2) array
        True positions of all people [m].
    radius : float
        Radius of a torso [m].

    Returns
    -------
    (n,) array
        Shares from 0 to 1.
    """
    shares = np.zeros(len(people))
    for view in views:
        sensor = robot @ Pose2D(view.x, view.y, view.yaw)
        distances = np.hypot(*(people - sensor[:2]).T)
        for person in np.flatnonzero(distances <= BEYOND * view.range_max).tolist():
            others, hide = np.delete(people, person, axis=0), surroundings.discs
            before = surroundings._replace(discs=((others, radius), *hide))
            share = _share(before, sensor, view, people[person], radius)
            if share < PERHAPS:
                before = surroundings._replace(discs=((others, THIN), *hide))
                share = max(share, min(_share(before, sensor, view, people[person], radius), PERHAPS))
            in_range = view.range_min <= distances[person] <= view.range_max
            shares[person] = max(shares[person], share if in_range else min(share, PERHAPS))
    return shares


def _share(before: Surroundings, sensor: Pose2D, view: SensorView, person: Floats, radius: float) -> float:
    """Return the share of one torso that a sensor at a pose has in view."""
    right, up = (person - sensor[:2]).tolist()
    distance = math.hypot(right, up)
    if distance <= radius:
        return 0.0
    half = math.asin(radius / distance) * (1.0 - 1.0 / RAYS)
    angles = wrap_angle(math.atan2(up, right) - sensor.theta) + np.linspace(-half, half, RAYS)
    angles = angles[np.abs(angles) <= 0.5 * view.field_of_view]
    if not len(angles):
        return 0.0
    reach = distance - radius
    ranges = cast_rays(before.occupied, before.info, sensor, angles, distance + radius)
    for centres, size in before.discs:
        ranges = np.minimum(ranges, cast_at_discs(sensor, angles, centres, size))
    return float(np.count_nonzero(ranges > reach) / RAYS)
