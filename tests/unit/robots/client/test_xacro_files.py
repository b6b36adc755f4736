"""Xacro files, expanded without ROS: macros, packages, arguments, and what is wrong with them."""

from collections.abc import Mapping
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from robots.client.urdf_files import read_urdf_file

HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="cart">'
WHEEL = (
    '<xacro:macro name="wheel" params="side">'
    '<link name="$(arg prefix)${side}_wheel"><collision><geometry><sphere radius="${size / 2}"/></geometry></collision>'
    "</link></xacro:macro>"
)
ROBOT = (
    '<xacro:property name="size" value="0.1"/><xacro:include filename="{included}"/>'
    '<link name="base_link"/><xacro:wheel side="left"/>'
)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Return the folder of a package whose manifest gives its name, with a robot and a wheel."""
    folder = tmp_path / "checkout"
    (folder / "urdf").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>cart_description</name></package>")
    (folder / "urdf" / "wheel.xacro").write_text(f"{HEAD}{WHEEL}</robot>")
    written(folder / "urdf" / "cart.urdf.xacro", ROBOT.format(included="$(find cart_description)/urdf/wheel.xacro"))
    return folder


def written(path: Path, body: str) -> Path:
    path.write_text(f'{HEAD}<xacro:arg name="prefix" default=""/>{body}</robot>')
    return path


def expanded(path: Path, folders: tuple[Path, ...] = (), arguments: Mapping[str, str] | None = None) -> str:
    return read_urdf_file(path, folders, arguments).decode()


def test_macros_properties_and_packages_are_expanded(package: Path) -> None:
    urdf = expanded(package / "urdf" / "cart.urdf.xacro")
    assert '<link name="left_wheel">' in urdf
    assert '<sphere radius="0.05"/>' in urdf
    assert "xacro" not in urdf and str(package) not in urdf


def test_arguments_are_given_by_name(package: Path) -> None:
    assert '<link name="r1_left_wheel">' in expanded(package / "urdf" / "cart.urdf.xacro", arguments={"prefix": "r1_"})


def test_a_package_is_a_folder_of_its_name_or_one_that_is_given(tmp_path: Path, package: Path) -> None:
    robot = written(tmp_path / "own.xacro", ROBOT.format(included="$(find cart_description)/urdf/wheel.xacro"))
    with pytest.raises(InvalidInput, match=r"the package of \$\(find cart_description\) is in no folder known"):
        expanded(robot)
    assert "left_wheel" in expanded(robot, (package,))
    (tmp_path / "cart_description").symlink_to(package)
    assert "left_wheel" in expanded(robot)


def test_a_urdf_that_was_expanded_stays_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(f"{HEAD}<link name='a'/></robot>")
    assert expanded(path) == path.read_text()
    path.write_text(f"{HEAD}<xacro:property name='n' value='a'/><link name='${{n}}'/></robot>")
    assert '<link name="a"/>' in expanded(path)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ('<xacro:property name="size" value="${size}"/><a b="${size}"/>', "circular variable definition"),
        ("<xacro:weel side='left'/>", "unknown macro name: xacro:weel"),
        ("<a b='${size}'/>", "'size' is not defined"),
        ("<a b='$(arg side)'/>", "the argument side has no value; give one: --xacro-arg side=VALUE"),
        ("<xacro:include filename='no.xacro'/>", "no.xacro"),
        ("<xacro:arg name='side'/>", "missing attribute 'default'"),
        ("<a", "cannot expand"),
        ("<a b='${1 / 0}'/>", "division by zero"),
        ("<a b='$(find a b)'/>", "cannot expand"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, body: str, words: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        expanded(written(tmp_path / "r.xacro", body))
    assert words in str(caught.value)
