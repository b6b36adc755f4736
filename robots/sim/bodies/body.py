"""Bodies of people as solid shapes: legs that swing, trunk, arms and head; standing, walking or sitting.

Lengths of the segments are fractions of the height from Drillis and Contini ("Body Segment Parameters", 1966), as in
Winter's "Biomechanics and Motor Control of Human Movement".
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from robots.sim.depth.shapes import Shapes, Vector, capsule, ellipsoid, shapes_of

HIP, KNEE, ANKLE = 0.530, 0.285, 0.039
"""Heights of the joints, as fractions of the height of the body."""
THIGH, SHANK = HIP - KNEE, KNEE - ANKLE
"""Lengths, as fractions of the height of the body."""
SHOULDER, HEAD = 0.818, 0.930
"""Heights of the shoulders and of the centre of the head, as fractions of the height of the body."""
UPPER_ARM, FOREARM = 0.172, 0.190
"""Lengths of the upper arm, and of the forearm with half of the hand, as fractions of the height of the body."""
SHANK_RADIUS, THIGH_RADIUS = 0.031, 0.044
"""Radii, as fractions of the height of the body."""
SEAT = 0.45
"""Height of a seat [m]."""
SHORTEST, TALLEST = 1.50, 1.95
"""Range of the heights of adults [m]."""


@dataclass(frozen=True, slots=True)
class BodyModel:
    """Size of a body.

    Parameters
    ----------
    height : float
        Height of the standing body [m].
    girth : float
        Factor of all radii.
    """

    height: float = 1.75
    girth: float = 1.0


@dataclass(frozen=True, slots=True)
class Stance:
    """Momentary posture of a body.

    Parameters
    ----------
    stride : float
        Amplitude of the swing of the legs [rad]; 0 for a body that stands.
    phase : float
        Phase of the gait [rad].
    sitting : bool
    """

    stride: float = 0.0
    phase: float = 0.0
    sitting: bool = False


@dataclass(frozen=True, slots=True)
class _Leg:
    """Joints of a leg in the body's frame [m]."""

    hip: Vector
    knee: Vector
    ankle: Vector


def random_body(rng: np.random.Generator) -> BodyModel:
    """Return a body of random size."""
    return BodyModel(float(rng.uniform(SHORTEST, TALLEST)), float(rng.uniform(0.9, 1.15)))


def body_shapes(body: BodyModel, stance: Stance, pose: Pose2D) -> Shapes:
    """Return a body as shapes in the frame of the map.

    Parameters
    ----------
    body : BodyModel
    stance : Stance
    pose : Pose2D
        Position of the hips on the floor, and the direction in which the body faces.
    """
    legs = _legs(body, stance)
    # The hips carry the trunk: they sink when the legs are apart, and onto the seat.
    lift = legs[0].hip[2] - HIP * body.height
    capsules = [part for leg in legs for part in _leg_parts(body, leg)]
    capsules += _arms(body, stance, lift) + _shoulders(body, lift)
    return shapes_of(capsules, _trunk(body, lift)).placed(pose)


def leg_discs(body: BodyModel, stance: Stance, pose: Pose2D, height: float) -> NDArray[np.float64]:
    """Return the discs in which a level plane cuts the shanks, (2, 3) x, y, radius [m], in the frame of the map."""
    discs = []
    for leg in _legs(body, stance):
        share = (height - leg.ankle[2]) / max(leg.knee[2] - leg.ankle[2], 1e-6)
        share = min(max(share, 0.0), 1.0)
        ahead, left = (leg.ankle[i] + share * (leg.knee[i] - leg.ankle[i]) for i in (0, 1))
        x, y, _ = pose @ Pose2D(ahead, left)
        discs.append((x, y, SHANK_RADIUS * body.height * body.girth))
    return np.array(discs)


def head_height(body: BodyModel, stance: Stance) -> float:
    """Return the height of the top of the head [m]."""
    return body.height + _legs(body, stance)[0].hip[2] - HIP * body.height


def _legs(body: BodyModel, stance: Stance) -> tuple[_Leg, _Leg]:
    if stance.sitting:
        return _sitting_leg(body, 1.0), _sitting_leg(body, -1.0)
    left, right = _walking_leg(body, stance, 1.0), _walking_leg(body, stance, -1.0)
    # The lower foot is on the floor.
    sink = ANKLE * body.height - min(left.ankle[2], right.ankle[2])
    return _lifted(left, sink), _lifted(right, sink)


def _walking_leg(body: BodyModel, stance: Stance, side: float) -> _Leg:
    height = body.height
    phase = stance.phase if side > 0.0 else stance.phase + math.pi
    swing = stance.stride * math.sin(phase)
    # The knee bends while the leg swings forward.
    shank = swing - 1.6 * stance.stride * max(math.cos(phase), 0.0)
    y = side * 0.052 * height
    knee_x, knee_z = THIGH * math.sin(swing), HIP - THIGH * math.cos(swing)
    ankle_x, ankle_z = knee_x + SHANK * math.sin(shank), knee_z - SHANK * math.cos(shank)
    hip = (0.0, y, HIP * height)
    return _Leg(hip, (knee_x * height, y, knee_z * height), (ankle_x * height, y, ankle_z * height))


def _sitting_leg(body: BodyModel, side: float) -> _Leg:
    height = body.height
    y = side * 0.06 * height
    hip_z, knee_z = SEAT + THIGH_RADIUS * height * body.girth, KNEE * height + 0.02
    ahead = math.sqrt(max((THIGH * height) ** 2 - (knee_z - hip_z) ** 2, 0.0))
    ankle_z = max(knee_z - SHANK * height, ANKLE * height)
    return _Leg((0.0, y, hip_z), (ahead, 1.5 * y, knee_z), (ahead + 0.03, 1.5 * y, ankle_z))


def _lifted(leg: _Leg, by: float) -> _Leg:
    moved = ((x, y, z + by) for x, y, z in (leg.hip, leg.knee, leg.ankle))
    return _Leg(*moved)


def _leg_parts(body: BodyModel, leg: _Leg) -> list[tuple[float, ...]]:
    height, width = body.height, body.height * body.girth
    x, y, z = leg.ankle
    sole = z - ANKLE * height + 0.02 * height
    return [
        capsule(leg.hip, leg.knee, THIGH_RADIUS * width),
        capsule(leg.knee, leg.ankle, SHANK_RADIUS * width),
        capsule((x - 0.02 * height, y, sole), (x + 0.10 * height, y, sole), 0.02 * height),
    ]


def _arms(body: BodyModel, stance: Stance, lift: float) -> list[tuple[float, ...]]:
    height, width = body.height, body.height * body.girth
    parts = []
    for side in (1.0, -1.0):
        # Arms swing against the leg of their side; those who sit rest their hands on the thighs.
        swing = -0.8 * stance.stride * math.sin(stance.phase if side > 0.0 else stance.phase + math.pi)
        upper, fore = (0.25, 1.35) if stance.sitting else (swing, swing + 0.2 + 0.5 * stance.stride)
        y = side * 0.112 * width
        shoulder = (0.0, y, SHOULDER * height + lift - 0.02 * height)
        elbow = _swung(shoulder, upper, UPPER_ARM * height, side * 0.012 * height)
        hand = _swung(elbow, fore, FOREARM * height, -side * 0.005 * height)
        parts += [capsule(shoulder, elbow, 0.027 * width), capsule(elbow, hand, 0.022 * width)]
    return parts


def _swung(joint: Vector, angle: float, length: float, aside: float) -> Vector:
    return joint[0] + length * math.sin(angle), joint[1] + aside, joint[2] - length * math.cos(angle)


def _shoulders(body: BodyModel, lift: float) -> list[tuple[float, ...]]:
    height, width = body.height, body.height * body.girth
    at = SHOULDER * height + lift - 0.025 * height
    neck = (0.0, 0.0, at), (0.01 * height, 0.0, 0.88 * height + lift)
    return [
        capsule((0.0, 0.088 * width, at), (0.0, -0.088 * width, at), 0.043 * width),
        capsule(*neck, 0.033 * width),
    ]


def _trunk(body: BodyModel, lift: float) -> list[tuple[float, ...]]:
    height, width = body.height, body.height * body.girth
    chest = ellipsoid((0.0, 0.0, 0.70 * height + lift), (0.068 * width, 0.100 * width, 0.135 * height))
    belly = ellipsoid((0.0, 0.0, 0.60 * height + lift), (0.066 * width, 0.090 * width, 0.110 * height))
    hips = ellipsoid((0.0, 0.0, 0.54 * height + lift), (0.066 * width, 0.098 * width, 0.080 * height))
    head = ellipsoid((0.012 * height, 0.0, HEAD * height + lift), (0.056 * height, 0.044 * height, 0.070 * height))
    return [chest, belly, hips, head]
