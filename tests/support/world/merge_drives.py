"""Mappings of a small ring of corridors, made by two robots without a common start; each is mapped once."""

from functools import cache

import numpy as np

from benchmarks.mapping.simulated_drive import SimulatedDrive, simulate
from benchmarks.mapping.small_worlds import LAP, walls
from ppaas.geometry import Pose2D
from ppaas.mapping.pipeline.offline import map_log
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.planar_poses import PoseArray, compose
from tests.support.world.ring_drive import ring_drive

OTHER_START = (*LAP[2:], *LAP, *LAP[:2])
"""Way points of the second robot [m]."""


@cache
def first_drive() -> SimulatedDrive:
    """Return the drive of the first robot: two laps."""
    return ring_drive(2)


@cache
def second_drive(beams: int = 90) -> SimulatedDrive:
    """Return the drive of the second robot, which starts at another corner and looks along another wall."""
    return simulate(walls(), np.array(OTHER_START), 9, beams=beams, mount=Pose2D(0.0, 0.1, 0.0))


@cache
def first_mapping() -> Mapping:
    """Return the mapping of the first robot; not to be changed."""
    return mapping_of(first_drive())


@cache
def second_mapping(beams: int = 90) -> Mapping:
    """Return the mapping of the second robot; not to be changed."""
    return mapping_of(second_drive(beams))


def mapping_of(drive: SimulatedDrive) -> Mapping:
    """Return the mapping of a drive."""
    made = map_log(drive.log).mapper
    return Mapping(made.key_frames, made.graph, "laser")


def true_lasers(drive: SimulatedDrive, mapping: Mapping) -> PoseArray:
    """Return the true poses (k, 3) of the laser at the key frames of a mapping."""
    return compose(drive.true[mapping.frames.scans], np.array(drive.log.geometry.mount))
