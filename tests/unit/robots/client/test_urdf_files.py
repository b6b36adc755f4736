"""URDF files get the extents of their meshes, wherever these are kept.

Names of meshes in files of real robots: ``package://``, ``file://``, relative and absolute, in folders of a package, in
one folder, beside the URDF, and installed in ROS.
"""

import shutil
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from ppaas.robot_model.describe import describe
from robots.client.urdf_files import read_urdf_file
from tests.support.world.urdf import box, box_stl, joint, link, part, urdf

MESH = '<mesh filename="{}" scale="2 1 1"/>'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A package ``r`` with ``urdf`` and ``meshes``."""
    (tmp_path / "r" / "meshes").mkdir(parents=True)
    (tmp_path / "r" / "urdf").mkdir()
    (tmp_path / "r" / "meshes" / "base.stl").write_bytes(box_stl((-0.3, -0.25, 0.0), (0.3, 0.25, 0.3)))
    return tmp_path


def read(path: Path, *inside: str, folders=()) -> bytes:
    path.write_bytes(urdf(*inside))
    return read_urdf_file(path, folders)


def is_known(data: bytes) -> bool:
    footprint = describe(data).footprint
    assert footprint in ((), ((-0.6, -0.25), (0.6, -0.25), (0.6, 0.25), (-0.6, 0.25)))
    return bool(footprint)


@pytest.mark.parametrize("name", ["package://r/meshes/base.stl", "../meshes/base.stl", "file://{0}/r/meshes/base.stl"])
def test_mesh_of_the_package_of_the_urdf_is_found(folder: Path, name: str):
    mesh = part(MESH.format(name.format(folder)))
    assert is_known(read(folder / "r" / "urdf" / "r.urdf", link("base_link", mesh)))


def test_mesh_of_a_url_with_spaces_is_found(folder: Path):
    shutil.copy(folder / "r" / "meshes" / "base.stl", folder / "my base.stl")
    mesh = part(MESH.format(f"file://{folder}/my%20base.stl"))
    assert is_known(read(folder / "r.urdf", link("base_link", mesh)))


def test_collisions_in_comments_do_not_keep_visuals_from_their_extents(folder: Path):
    path = folder / "r" / "urdf" / "r.urdf"
    visual = f"<visual><geometry>{MESH.format('package://r/meshes/base.stl')}</geometry></visual>"
    comment = '<!-- <collision><geometry><box size="1 1 1"/></geometry></collision> -->'
    assert is_known(read(path, f'<link name="base_link">{comment}{visual}</link>'))


def test_mesh_beside_the_urdf_is_found_whatever_its_package(folder: Path):
    shutil.copy(folder / "r" / "meshes" / "base.stl", folder)
    assert is_known(read(folder / "r.urdf", link("base_link", part(MESH.format("package://other/meshes/base.stl")))))


def test_mesh_in_a_folder_of_its_own_or_in_an_installed_package_is_found(folder: Path, monkeypatch):
    other = folder / "elsewhere" / "deep" / "deeper" / "deepest"
    other.mkdir(parents=True)
    inside = link("base_link", part(MESH.format("package://r/meshes/base.stl")))
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")
    assert not is_known(read(other / "r.urdf", inside))
    for place in (folder, folder / "r", folder / "r" / "meshes"):
        assert is_known(read(other / "r.urdf", inside, folders=[place]))
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"/nowhere:{folder}")
    assert is_known(read(other / "r.urdf", inside))
    (folder / "share").symlink_to(folder)
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(folder))
    assert is_known(read(other / "r.urdf", inside))


def test_urdf_is_unchanged_but_for_the_extents(folder: Path):
    path = folder / "r" / "r.urdf"
    mesh = part(MESH.format("package://r/meshes/base.stl"))
    known = part('<mesh filename="package://r/meshes/base.stl" bounding_box="0 0 0 1 1 1"/>')
    seen = part(MESH.format("package://r/meshes/base.stl"), kind="visual")
    inside = (link("base_link", mesh, known, seen), "<!-- a comment -->")
    written = read(path, *inside)
    box = ' bounding_box="-0.300000012 -0.25 0 0.300000012 0.25 0.300000012"'
    assert written == urdf(*inside).replace(b"<mesh filename", f"<mesh{box} filename".encode(), 1)
    visual = urdf(link("base_link", seen))
    path.write_bytes(visual)
    assert read_urdf_file(path).count(b"bounding_box") == 1  # without a collision, visuals count


def test_mesh_that_is_missing_or_of_another_format_leaves_the_urdf_to_the_cloud(folder: Path):
    inside = [link("base_link", part(box(1, 1, 1)), part(MESH.format("package://r/meshes/no.stl")))]
    inside += [link("a", part(MESH.format("package://r/meshes/base.fbx"))) + joint("a"), link("b", part("<mesh/>"))]
    assert read(folder / "r" / "r.urdf", *inside) == urdf(*inside)
    (folder / "r" / "x.urdf").write_bytes("<robot name='ä'/>".encode("latin-1"))
    assert read_urdf_file(folder / "r" / "x.urdf") == "<robot name='ä'/>".encode("latin-1")


def test_damaged_mesh_and_missing_urdf_are_refused_by_name(folder: Path):
    (folder / "r" / "meshes" / "base.stl").write_bytes(b"junk")
    with pytest.raises(InvalidInput, match=r"base\.stl.*cannot be read"):
        read(folder / "r" / "r.urdf", link("base_link", part(MESH.format("package://r/meshes/base.stl"))))
    with pytest.raises(InvalidInput, match="cannot read the URDF"):
        read_urdf_file(folder / "no.urdf")
