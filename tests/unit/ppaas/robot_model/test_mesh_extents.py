"""Extents of meshes: STL (binary and text), COLLADA (units, nodes that move) and OBJ."""

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.robot_model.mesh_extents import Extent, extent_of
from tests.support.world.urdf import box_stl

LEAST, GREATEST = (-0.3, -0.25, 0.0), (0.3, 0.25, 0.3)
CORNERS = np.array(list(product(*zip(LEAST, GREATEST, strict=True))))
FACETS = [CORNERS[0:3], CORNERS[3:6], CORNERS[5:8]]
BINARY = box_stl(LEAST, GREATEST)
IDENTITY = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"


def text() -> bytes:
    vertices = [f"vertex {x} {y:e} {z}" for facet in FACETS for x, y, z in facet]
    loops = "\n".join(f"facet normal 0 0 1\nouter loop\n{vertex}\nendloop\nendfacet" for vertex in vertices)
    return f"solid box\n{loops}\nendsolid box".encode()


def dae(nodes: str, unit: float = 1.0, scene: bool = True) -> bytes:
    numbers = " ".join(map(repr, CORNERS.ravel().tolist()))
    scenes = f"<library_visual_scenes><visual_scene>{nodes}</visual_scene></library_visual_scenes>" if scene else ""
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">
      <asset><unit meter="{unit}" name="m"/><up_axis>Y_UP</up_axis></asset>
      <library_geometries><geometry id="g"><mesh>
        <source id="p"><float_array id="pa" count="24">{numbers}</float_array></source>
        <source id="n"><float_array id="na" count="3">9 9 9</float_array></source>
        <vertices id="v"><input semantic="POSITION" source="#p"/><input semantic="NORMAL" source="#n"/></vertices>
      </mesh></geometry></library_geometries>{scenes}</COLLADA>""".encode()


def node(inside: str, below: str = "") -> str:
    return f'<node>{inside}<instance_geometry url="#g"/>{below}</node>'


def check(extent: Extent, least=LEAST, greatest=GREATEST) -> None:
    assert extent.least == pytest.approx(least, abs=1e-6)
    assert extent.greatest == pytest.approx(greatest, abs=1e-6)


def test_extent_of_an_stl_file_binary_or_text():
    check(extent_of("base.stl", BINARY))
    check(extent_of("base.STL", b"solid, or not".ljust(80) + BINARY[80:]))
    check(extent_of("base.stl", text()))


def test_words_of_an_stl_file_may_be_in_capitals():
    check(extent_of("base.stl", text().upper()))


def test_lines_of_an_obj_file_may_go_on_in_the_next_one():
    lines = [f"v \\\n {x} {y} \\\r\n {z}" for x, y, z in CORNERS]
    check(extent_of("base.obj", "\n".join(lines).encode()))
    with pytest.raises(InvalidInput, match="a line 'v' has fewer than three numbers"):
        extent_of("base.obj", b"v 1 2 3\nv 1 2\n")


def test_extent_of_an_obj_file():
    lines = [f"v {x} {y} {z} 1.0" for x, y, z in CORNERS]
    check(extent_of("base.obj", "\n".join(["# made by hand", *lines, "vn 9 9 9", "f 1 2 3"]).encode()))


def test_extent_of_a_collada_file_is_in_metres_and_along_its_own_axes():
    check(extent_of("a.dae", dae(node(f"<matrix>{IDENTITY}</matrix>"))))
    check(extent_of("a.dae", dae(node(""), unit=0.001)), [0.001 * x for x in LEAST], [0.001 * x for x in GREATEST])
    check(extent_of("a.dae", dae("", scene=False)))


def test_nodes_of_a_collada_file_move_what_is_below_them():
    turned = node("<rotate>0 0 1 90</rotate><translate>1 0 0</translate><scale>2 2 2</scale>")
    check(extent_of("a.dae", dae(turned)), (-0.5, 0.4, 0.0), (0.5, 1.6, 0.6))
    below = f"<node><translate>0 0 5</translate>{node('<translate>0 0 1</translate>')}</node>"
    check(extent_of("a.dae", dae(below)), (-0.3, -0.25, 6.0), (0.3, 0.25, 6.3))


def test_of_several_scenes_of_a_collada_file_the_one_that_it_shows_counts():
    two = f'{node("<translate>50 0 0</translate>")}</visual_scene><visual_scene id="shown">{node("")}'
    shown = '<scene><instance_visual_scene url="#shown"/></scene></COLLADA>'
    check(extent_of("a.dae", dae(two).replace(b"</COLLADA>", shown.encode())))
    check(extent_of("a.dae", dae(two)), (49.7, -0.25, 0.0), (50.3, 0.25, 0.3))


def test_nodes_that_are_placed_by_reference_count():
    """Exporters put parts that are used twice into ``library_nodes``."""
    library = f'<node id="part"><translate>0 0 1</translate>{node("")}</node>'
    part = '<instance_node url="#part"/>'
    written = dae(f"<node><translate>2 0 0</translate>{part}</node><node>{part}</node>").decode()
    placed = written.replace("<library_geometries>", f"<library_nodes>{library}</library_nodes><library_geometries>")
    check(extent_of("a.dae", placed.encode()), (-0.3, -0.25, 1.0), (2.3, 0.25, 1.3))
    check(extent_of("a.dae", dae(node("") + '<node><instance_node url="#missing"/></node>')))


def test_nodes_that_place_each_other_without_end_are_refused():
    doubled = "".join(
        f'<node id="n{k}"><instance_node url="#n{k + 1}"/><instance_node url="#n{k + 1}"/></node>' for k in range(60)
    )
    for scene in (doubled + f'<node id="n60">{node("")}</node>', '<node id="a"><instance_node url="#a"/></node>'):
        with pytest.raises(InvalidInput, match=r"place more than|nested"):
            extent_of("a.dae", dae(scene))


@pytest.mark.parametrize(
    ("name", "data", "why"),
    [
        ("a.fbx", b"", "must be one of stl, dae, obj"), ("stl", b"", "has no vertex|too few"),
        ("a.stl", b"", "too few"), ("a.stl", b"junk" * 50, "too few"), ("a.stl", BINARY[:-1], "too few"),
        ("a.stl", b"solid x\nfacet\nvertex 1 2\n", "cannot be read"),
        ("a.stl", b"solid x\nfacet normal 0 0 1\nendsolid x\n", "has no vertex"),
        ("a.stl", b"solid x\nfacet\nvertex nan 0 0\nvertex 0 0 0\n", "not finite"),
        ("a.obj", b"v a b c", "cannot be read"), ("a.dae", b"<COLLADA>", "cannot be read"),
        ("a.dae", b"<!DOCTYPE a [<!ENTITY x 'y'>]><a>&x;</a>", "entities"),
        ("a.dae", dae("<node>" * 200 + "</node>" * 200), "nested"),
        ("a.dae", dae(node("<matrix>1 2</matrix>")), "cannot be read"),
    ],
)  # fmt: skip
def test_damaged_mesh_is_refused_by_name(name, data, why):
    with pytest.raises(InvalidInput, match=why) as refused:
        extent_of(name, data)
    assert name in str(refused.value)


@given(st.sampled_from(["a.stl", "a.obj", "a.dae"]), st.binary(max_size=300))
def test_any_file_has_an_extent_or_is_refused(name, data):
    try:
        extent = extent_of(name, data)
    except InvalidInput:
        return
    assert all(map(math.isfinite, (*extent.least, *extent.greatest)))
