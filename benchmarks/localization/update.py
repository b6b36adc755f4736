"""Time of one particle filter update: motion, a scan of 30 beams, likelihood field, KLD sampling and resampling."""

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from benchmarks.localization.route import RandomRoute
from ppaas.clock import monotonic
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.maps.grid import GridMap
from ppaas.messages.sensor_msgs import LaserScan
from robots.sim.world import World

BEAMS = 30
"""Number of beams of a scan that are used."""
RUNS = 25
"""Number of measurements, of which the fastest counts."""
SPREAD = np.diag((0.25, 0.25, math.radians(15.0) ** 2))
"""Covariance of an initial pose as set by rviz [m², rad²]."""


def measure(grid: GridMap, particles: Sequence[int], threads: Sequence[int]) -> list[dict[str, Any]]:
    """Return the shortest time of an update for each number of particles and threads.

    Parameters
    ----------
    grid : GridMap
        Map of the robot.
    particles : sequence of int
        Numbers of particles, which KLD sampling does not reduce.
    threads : sequence of int
        Largest numbers of threads of the kernels.
    """
    rng = np.random.default_rng(1)
    pose = RandomRoute(grid, rng).anywhere()
    world = World(grid, 1)
    scan = world.add_robot(pose).scan()
    layers = build_layers(grid)
    rows = []
    for count in particles:
        for most in threads:
            parameters = AmclParameters(
                min_particles=count, max_particles=count, laser_max_beams=BEAMS, resample_interval=1
            )
            localization = ParticleFilter(layers, parameters, partial(int, most))
            seconds = min(_seconds(localization, pose, scan) for _ in range(RUNS))
            rows.append({"particles": count, "threads": most, "update_ms": round(1e3 * seconds, 3)})
    return rows


def _seconds(localization: ParticleFilter, pose: Pose2D, scan: LaserScan) -> float:
    """Return the time of the second update [s]; the first has no motion."""
    sensor = localization.sensor
    localization.initialise(pose, SPREAD)
    beams, here = sensor.beams(scan, Pose2D(0.0, 0.0)), Pose2D(0.0, 0.0)
    localization.update(here, beams, scan.range_max)
    began = monotonic()
    localization.update(Pose2D(0.1, 0.0, 0.05), beams, scan.range_max)
    return monotonic() - began
