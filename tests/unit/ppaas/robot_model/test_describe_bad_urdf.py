"""Invalid URDFs are refused with an error that names the place."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidUrdf, MessageTooLarge, PPaaSError
from ppaas.robot_model.describe import describe
from ppaas.robot_model.urdf import MAX_LINKS, MAX_SHAPES
from ppaas.robot_model.xml_document import MAX_BYTES
from tests.support.world.urdf import box, cylinder, example, joint, link, origin, part, sphere, urdf

BASE = link("base_link", part(box(1.0, 1.0, 1.0)))
ENTITIES = "".join(f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 10))
MIMICS = "".join(
    link(f"m{n}")
    + joint(
        f"m{n}",
        "base_link",
        "revolute",
        f'<mimic joint="m{max(n - 1, 0)}_joint" multiplier="1e6" offset="1"/>' * (n > 0),
    )
    for n in range(60)
)


XACRO = b'<robot name="r" xmlns:xacro="http://ros.org/wiki/xacro">'


@pytest.mark.parametrize(
    ("data", "where"),
    [
        (XACRO + b'<link name="${prefix}base_link"/></robot>', r"name= of <link> is '\$\{prefix\}base_link'"),
        (XACRO + b'<link name="base_link"/><xacro:wheel side="left"/></robot>', "<xacro:wheel>"),
        (XACRO + b'<xacro:macro name="m"><link name="base_link"/></xacro:macro><xacro:m/></robot>', "<xacro:macro>"),
        (XACRO.replace(b"wiki", b"interface") + b'<xacro:property name="a" value="1"/></robot>', "<xacro:property>"),
        (b'<robot name="r"><link name="base_link"/><xacro:wheel/></robot>', "<xacro:…>"),
        (urdf(link("base_link", part('<mesh filename="$(find r)/base.stl"/>'))), r"filename= of <mesh> is '\$\(find r"),
        (urdf(link("base_link", part('<box size="${a} 1 1"/>'))), "size= of <box>"),
        (urdf(BASE, '<gazebo reference="${prefix}laser"/>'), "reference= of <gazebo>"),
    ],
)
def test_xacro_that_was_not_run_is_refused_with_what_to_do(data, where):
    """Macros, includes, properties and ``${…}`` in a name or a number, with and without the namespace."""
    with pytest.raises(InvalidUrdf, match=f"this is xacro, not URDF .*{where}.*run xacro first"):
        describe(data)


def test_urdf_that_xacro_wrote_may_name_the_namespace():
    assert describe(XACRO + b'<link name="base_link"/><!-- ${x} --></robot>').links == 1


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "not XML"),
        (b"robot", "not XML"),
        (b"<robot>", "not XML"),
        (b"\x00" * 64, "not XML"),
        (b"<robot name='a' name='b'/>", "not XML"),
        ("<robot/>".encode("utf-16"), "UTF-8"),
        (b'<?xml version="1.0" encoding="latin-1"?><robot name="\xe4"/>', "UTF-8"),
        ('<?xml version="1.0" encoding="latin-1"?><robot name="ä"/>'.encode(), "UTF-8"),
        (b'<!DOCTYPE robot><robot name="r"><link name="l"/></robot>', "document type"),
        (f'<!DOCTYPE r [<!ENTITY l0 "ha">{ENTITIES}]><robot name="&l9;"/>'.encode(), "document type"),
        (b'<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="r">&x;</robot>', "document type"),
        (b'<!DOCTYPE r SYSTEM "http://127.0.0.1:1/x.dtd"><robot name="r"/>', "document type"),
        (b"<sdf/>", "must be <robot>, not <sdf>"),
        (urdf(), "no <link>"),
        (urdf(link("")), "name="),
        (urdf(link("x" * 300)), "name="),
        (urdf(BASE, BASE), "two links"),
        (urdf(BASE, link("a"), link("b"), joint("a"), joint("a")), "two joints"),
        (urdf(BASE, link("a")), "one root link"),
        (urdf(link("a"), link("b"), joint("a", "b"), joint("b", "a")), "loop"),
        (urdf(BASE, link("a"), link("b"), joint("a", "b"), joint("b", "a")), "loop"),
        (urdf(BASE, joint("a")), "'a', which does not exist"),
        (urdf(BASE, link("a"), joint("a", "nowhere")), "'nowhere', which does not exist"),
        (urdf(BASE, link("a"), joint("a"), joint("a").replace("a_joint", "other")), "child of two joints"),
        (urdf(BASE, link("a"), '<joint name="j" type="fixed"><parent link="base_link"/></joint>'), "no <child>"),
        (urdf(BASE, link("a"), joint("a", "base_link", "hinge")), "'hinge'"),
        (urdf(BASE, link("a"), joint("a", "base_link", "revolute", '<axis xyz="0 0 0"/>')), "axis"),
        (urdf(BASE, link("a"), joint("a", "base_link", "fixed", '<origin xyz="nan 0 0"/>')), "joint 'a_joint'"),
        (urdf(BASE, link("a"), joint("a", "base_link", "fixed", '<origin rpy="0 inf 0"/>')), "joint 'a_joint'"),
        (urdf(BASE, link("a"), joint("a", "base_link", "fixed", '<origin xyz="0 0"/>')), "3 finite numbers"),
        (urdf(BASE, link("a"), joint("a", "base_link", "fixed", '<origin xyz="1e300 0 0"/>')), "3 finite numbers"),
        (urdf(BASE, link("a"), joint("a", "base_link", "fixed", '<origin xyz="1_0 ٣ 0"/>')), "3 finite numbers"),
        (urdf(BASE, link("a"), joint("a", "base_link", "continuous", '<limit velocity="-1"/>')), "negative"),
        (urdf(BASE, link("a"), joint("a", "base_link", "revolute", '<mimic joint="a_joint"/>')), "mimics itself"),
        (urdf(BASE, link("a"), joint("a", "base_link", "revolute", '<mimic joint="b"/>')), "'b', which does not exist"),
        (urdf(BASE, MIMICS), "beyond"),
        (urdf(link("l", part(box(-1.0, 1.0, 1.0)))), "link 'l'.*negative"),
        (urdf(link("l", part(box(float("nan"), 1.0, 1.0)))), "link 'l'.*finite"),
        (urdf(link("l", part(cylinder(float("inf"), 1.0)))), "link 'l'.*finite"),
        (urdf(link("l", part(sphere(-0.0001)))), "negative"),
        (urdf(link("l", part("<cylinder radius='1'/>"))), "length="),
        (urdf(link("l", part("<torus/>"))), "<torus>"),
        (urdf(link("l", part(""))), "empty"),
        (urdf(link("l", "<collision/>")), "no <geometry>"),
        (urdf(link("l", part("<cone/>"))), "one of <box>, <cylinder>, <capsule>, <sphere>, <mesh>, not <cone>"),
        (urdf(link("l", part("<capsule radius='1'/>"))), "length="),
        (urdf(link("l", part(sphere(0.1), "<origin rpy='0 0 0' quat_xyzw='0 0 0 1'/>"))), "give one of them"),
        (urdf(link("l", part(sphere(0.1), "<origin quat_xyzw='0 0 0 0'/>"))), "must be a rotation, not zero"),
        (urdf(link("l", part(sphere(0.1), "<origin quat_xyzw='0 0 1'/>"))), "4 finite numbers"),
        (urdf(link("l", part('<mesh filename="m" bounding_box="1 0 0 0 1 1"/>'))), "bounding_box"),
        (urdf(link("l", part('<mesh filename="m" scale="1"/>'))), "scale"),
        (urdf(link("l", part(box(0.4, 0.4, 0.4), origin((400.0, 0, 0))))), "reaches 100 m"),
        (urdf(*(link(f"l{n}") for n in range(MAX_LINKS + 1))), "1000 links"),
        (urdf(link("l", part(sphere(0.1)) * (MAX_SHAPES + 1))), "2000 shapes"),
    ],
)  # fmt: skip
def test_invalid_urdf_is_refused_with_the_reason(data, reason):
    with pytest.raises(InvalidUrdf, match=reason):
        describe(data)


def test_too_large_file_is_refused_before_parsing():
    with pytest.raises(MessageTooLarge, match=str(MAX_BYTES)):
        describe(b"<" * (MAX_BYTES + 1))


def test_longest_chain_and_deep_nesting_are_parsed():
    chain = "".join(
        link(f"l{n}") + joint(f"l{n}", f"l{n - 1}", "fixed", origin((0.01, 0, 0))) for n in range(1, MAX_LINKS)
    )
    assert describe(urdf(link("l0", part(sphere(0.1))), chain)).links == MAX_LINKS
    assert describe(urdf(BASE, "<a>" * 50_000 + "</a>" * 50_000)).links == 1


@given(st.data())
def test_damaged_file_is_read_or_raises_a_typed_error(data):
    whole = bytearray(example("turtlebot3_burger"))
    for _ in range(data.draw(st.integers(1, 5))):
        at = data.draw(st.integers(0, len(whole) - 1))
        whole[at : at + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=3))
    with suppress(PPaaSError):
        describe(bytes(whole))


@given(st.sampled_from(["0.14 0.14 0.143", "-0.032 0 0.07", "6.67", "0.033"]), st.text(max_size=12))
def test_any_attribute_value_is_read_or_raises_a_typed_error(number, instead):
    quoted = instead.replace("&", "").replace("<", "").replace('"', "")
    with suppress(PPaaSError):
        describe(example("turtlebot3_burger").replace(number.encode(), quoted.encode("utf-8", "surrogatepass")))


def test_lines_before_the_declaration_are_taken_as_ros_takes_them():
    """As in texts of launch files, which begin with a line end."""
    urdf = b'\n <?xml version="1.0"?><robot name="a"><link name="base_link"/></robot>'
    assert describe(urdf) == describe(urdf.strip())
