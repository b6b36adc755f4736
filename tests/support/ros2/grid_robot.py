"""Robot in the cells of a map, for scripts that run without this project: its motion, odometry and laser."""

import math
import time

import numpy as np

RESOLUTION, RANGE, BEAMS = 0.05, 8.0, 360
TIMEOUT = 0.5
"""Age at which a command counts no more [s]."""


class GridRobot:
    """Turtlebot that turns and drives as it is told, without errors of its odometry.

    Parameters
    ----------
    grid : (height, width) array
        Cells of 5 cm; those above 50 are walls.
    pose : list of float
        x, y [m], yaw [rad] in the map.
    """

    def __init__(self, grid: np.ndarray, pose: list[float]) -> None:
        self.grid, self.start, self.pose = grid, tuple(pose), list(pose)
        self.command, self.commanded, self.stepped = (0.0, 0.0), 0.0, time.monotonic()
        self.angles = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
        self.distances = np.arange(0.1, RANGE, RESOLUTION / 2)

    def drive(self, speed: float, turn: float) -> None:
        """Follow a command [m/s, rad/s]."""
        self.command, self.commanded = (speed, turn), time.monotonic()

    def stands(self) -> bool:
        """Return whether no command has come for a second."""
        return time.monotonic() - self.commanded > 1.0

    def step(self) -> tuple[float, float]:
        """Move until now; return the velocities [m/s, rad/s]."""
        now = time.monotonic()
        passed, self.stepped = now - self.stepped, now
        speed, turn = self.command if now - self.commanded < TIMEOUT else (0.0, 0.0)
        x, y, yaw = self.pose
        yaw += turn * passed
        self.pose = [x + speed * math.cos(yaw) * passed, y + speed * math.sin(yaw) * passed, yaw]
        return speed, turn

    def odometry(self) -> tuple[float, float, float]:
        """Return x, y [m], yaw [rad] from the start."""
        x, y = self.pose[0] - self.start[0], self.pose[1] - self.start[1]
        cosine, sine = math.cos(self.start[2]), math.sin(self.start[2])
        return cosine * x + sine * y, cosine * y - sine * x, self.pose[2] - self.start[2]

    def ranges(self) -> np.ndarray:
        """Return the readings of the laser, from behind the robot counterclockwise [m]."""
        angles = self.angles + self.pose[2]
        columns = (self.pose[0] + np.outer(np.cos(angles), self.distances)) / RESOLUTION
        rows = (self.pose[1] + np.outer(np.sin(angles), self.distances)) / RESOLUTION
        height, width = self.grid.shape
        hit = self.grid[rows.astype(int).clip(0, height - 1), columns.astype(int).clip(0, width - 1)] > 50
        return np.where(hit.any(1), self.distances[hit.argmax(1)], np.inf).astype(np.float32)
