"""Room that robots have beside them in their cells, and where in a cell they stop."""

Point = tuple[float, float]
"""x, y [m] in the map frame."""

Line = tuple[Point, Point]
"""Both ends of a straight way [m]."""


def beside(spacing: float, radius: float) -> float:
    """Return half of the room that a robot has on each side in a cell [m]: two in cells side by side share a margin.

    Parameters
    ----------
    spacing : float
        Side of a cell [m].
    radius : float
        Radius of the robot [m].
    """
    return max(spacing / 2.0 - radius, 0.0) / 2.0


def nearest_in_cell(place: Point, centre: Point, apart: float) -> Point:
    """Return the point nearest to a place that is at most a distance from the centre of a cell along x and y [m]."""
    (x, y), (mid_x, mid_y) = place, centre
    return min(max(x, mid_x - apart), mid_x + apart), min(max(y, mid_y - apart), mid_y + apart)
