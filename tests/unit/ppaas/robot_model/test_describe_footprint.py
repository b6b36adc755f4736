"""The footprint and the height of a robot are those of its slow twin."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.robot_model.describe import describe
from ppaas.robot_model.shapes import CORNERS, placed
from tests.reference.maps import urdf_outline
from tests.support.world import urdf

coordinates = st.floats(-1.0, 1.0)
angles = st.floats(-np.pi, np.pi)
sizes = st.floats(0.05, 1.0)
triples = st.tuples(coordinates, coordinates, coordinates)
turns = st.tuples(angles, angles, angles)
shapes = (
    st.tuples(st.just("box"), st.tuples(sizes, sizes, sizes))
    | st.tuples(st.just("cylinder"), st.tuples(sizes, sizes))
    | st.tuples(st.just("capsule"), st.tuples(sizes, sizes))
    | st.tuples(st.just("sphere"), st.tuples(sizes))
)
parts = st.lists(st.tuples(shapes, triples, turns), max_size=2)
robots = st.lists(st.tuples(st.integers(0, 5), triples, turns, parts), min_size=1, max_size=5).filter(
    lambda links: any(part for *_, part in links)
)
WRITE = {"box": urdf.box, "cylinder": urdf.cylinder, "capsule": urdf.capsule, "sphere": urdf.sphere}
AROUND = np.linspace(0.0, 2.0 * np.pi, 90)
DIRECTIONS = np.column_stack([np.cos(AROUND), np.sin(AROUND)])


def written(links) -> bytes:
    """Return the URDF of a tree of links, each below an earlier one."""
    inside = []
    for number, (parent, xyz, rpy, parts) in enumerate(links):
        shapes_ = [urdf.part(WRITE[kind](*numbers), urdf.origin(at, turn)) for (kind, numbers), at, turn in parts]
        inside.append(urdf.link("base_link" if number == 0 else f"l{number}", *shapes_))
        if number:
            above = parent % number
            inside.append(
                urdf.joint(f"l{number}", f"l{above}" if above else "base_link", "fixed", urdf.origin(xyz, rpy))
            )
    return urdf.urdf(*inside)


def points_of(links):
    poses, found = [], []
    for number, (parent, xyz, rpy, parts) in enumerate(links):
        poses.append(np.eye(4) if number == 0 else poses[parent % number] @ urdf_outline.matrix(xyz, rpy))
        for (kind, numbers), at, turn in parts:
            pose = poses[-1] @ urdf_outline.matrix(at, turn)
            found.append(urdf_outline.surface(kind, numbers) @ pose[:3, :3].T + pose[:3, 3])
    return np.concatenate(found)


@given(robots)
def test_footprint_reaches_as_far_as_the_shapes_on_every_side(links):
    description, points = describe(written(links)), points_of(links)
    ours = urdf_outline.reach(np.array(description.footprint), DIRECTIONS)
    true = urdf_outline.reach(points[:, :2], DIRECTIONS)
    most = 1.0 / np.cos(np.pi / CORNERS) - 1.0 + 1e-3
    assert (ours >= true - 1e-5).all()
    assert (ours <= true + most).all()
    assert description.height == pytest.approx(np.ptp(points[:, 2]), abs=2e-3)


@given(robots)
def test_footprint_is_convex_between_its_two_discs(links):
    description = describe(written(links))
    corners = np.array(description.footprint)
    ahead = np.roll(corners, -1, axis=0) - corners
    turns = ahead[:, 0] * np.roll(ahead, -1, axis=0)[:, 1] - ahead[:, 1] * np.roll(ahead, -1, axis=0)[:, 0]
    assert (turns > 0.0).all()
    assert np.hypot(*corners.T).max() <= description.circumscribed_radius + 1e-8 <= np.hypot(*corners.T).max() + 1.1e-3
    inner = description.inscribed_radius
    edges = ahead / np.hypot(*ahead.T)[:, None]
    inside = [(edges[:, 0] * -corners[:, 1] + edges[:, 1] * corners[:, 0]).min()]
    assert inner == pytest.approx(max(0.0, inside[0]), abs=1e-9)


@given(triples, turns)
def test_a_rotation_may_be_a_quaternion(at, turn):
    given = [urdf.link("base_link", urdf.part(urdf.box(0.4, 0.2, 0.1), origin)) for origin in (
        urdf.origin(at, turn),
        f'<origin xyz="{urdf.text(at)}" quat_xyzw="{urdf.text([2.0 * part for part in placed(at, turn)[3:]])}"/>',
    )]  # fmt: skip
    by_angles, by_quaternion = (describe(urdf.urdf(each)) for each in given)
    assert np.array(by_quaternion.footprint) == pytest.approx(np.array(by_angles.footprint), abs=2e-3)
    assert by_quaternion.height == pytest.approx(by_angles.height, abs=2e-3)
