"""Parser of untrusted XML: it rejects entities, and reads attributes as finite numbers."""

import math
import re
from xml.etree.ElementTree import Element, ParseError

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import fromstring

from ppaas.errors import InvalidUrdf, MessageTooLarge

MAX_BYTES = 1 << 20
"""Limit of a URDF's size; a PR2's, with 90 links and two arms, has a third of it [bytes]."""

MAX_NAME = 256
"""Limit of the length of names [characters]."""

MAX_NUMBER = 1e6
"""Limit of the magnitude of numbers [m or rad]."""

IS_XACRO = "this is xacro, not URDF ({}): run xacro first: xacro robot.urdf.xacro > robot.urdf"

_ENCODING = re.compile(r"""\s*<\?xml[^>]*\bencoding\s*=\s*["']([^"']*)["']""")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


def read_document(data: bytes) -> Element:
    """Return the root element of an XML document.

    Raises
    ------
    MessageTooLarge
        The document has more than ``MAX_BYTES``.
    InvalidUrdf
        The document is not XML in UTF-8, has a document type or entities, which a URDF never needs, or is xacro.
    """
    if len(data) > MAX_BYTES:
        raise MessageTooLarge(f"a URDF may have at most {MAX_BYTES} bytes, not {len(data)}")
    try:
        root = fromstring(_text(data), forbid_dtd=True)
    except DefusedXmlException as error:
        raise InvalidUrdf("a URDF must not have a document type or entities: remove them") from error
    except (ParseError, ValueError) as error:
        if b"<xacro:" in data:
            raise InvalidUrdf(IS_XACRO.format("it has <xacro:…> elements")) from error
        raise InvalidUrdf(f"the URDF is not XML: {error}") from error
    assert isinstance(root, Element)
    _check_expanded(root)
    return root


def _check_expanded(root: Element) -> None:
    """Raise ``InvalidUrdf`` if a document has elements or substitutions of xacro, which are not final."""
    for element in root.iter():
        tag = element.tag if isinstance(element.tag, str) else ""
        if tag.startswith("{") and "xacro" in tag.partition("}")[0]:
            raise InvalidUrdf(IS_XACRO.format(f"it has <xacro:{tag.partition('}')[2][:64]}>"))
        for name, value in element.items():
            if "${" in value or "$(" in value:
                raise InvalidUrdf(IS_XACRO.format(f"{name[:64]}= of <{tag[:64]}> is {value[:64]!a}"))


def _text(data: bytes) -> str:
    try:
        text = data.decode("utf-8-sig").lstrip()  # tinyxml2 takes lines before the declaration, expat does not
    except UnicodeDecodeError as error:
        raise InvalidUrdf("the URDF is not valid UTF-8: save it in UTF-8") from error
    declared = _ENCODING.match(text)
    if declared and not text.isascii() and declared[1].lower() not in ("utf-8", "utf8"):
        raise InvalidUrdf(f"a URDF must be in UTF-8, but this one declares {declared[1][:32]!a}: save it in UTF-8")
    return text


def name_of(element: Element, attribute: str = "name") -> str:
    """Return an attribute that is a name.

    Raises
    ------
    InvalidUrdf
        The name is missing, empty or too long.
    """
    name = element.get(attribute, "").strip()
    if not 0 < len(name) <= MAX_NAME:
        raise InvalidUrdf(f"<{element.tag[:MAX_NAME]}> must have {attribute}= of 1 to {MAX_NAME} characters")
    return name


def required(element: Element, child: str, where: str) -> Element:
    """Return a child element; raise ``InvalidUrdf``, with ``where`` in its text, if it is missing."""
    found = element.find(child)
    if found is None:
        raise InvalidUrdf(f"{where} has no <{child}>")
    return found


def numbers(element: Element, attribute: str, count: int, where: str, default: str | None = None) -> tuple[float, ...]:
    """Return an attribute that consists of ``count`` numbers.

    Raises
    ------
    InvalidUrdf
        The attribute is missing without a default, or is not ``count`` numbers of at most ``MAX_NUMBER`` in magnitude.
    """
    text = element.get(attribute, default)
    if text is None:
        raise InvalidUrdf(f"{where}: <{element.tag}> must have {attribute}=")
    words = text.split()
    found = tuple(float(word) for word in words if _NUMBER.fullmatch(word))
    if len(found) != count or len(words) != count or not all(abs(number) <= MAX_NUMBER for number in found):
        what = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InvalidUrdf(f"{where}: {attribute}= of <{element.tag}> must be {what}, not {text[:64]!a}")
    return found


def number(element: Element, attribute: str, where: str, default: str | None = None) -> float:
    """Return an attribute that is one number; raises as ``numbers``."""
    return numbers(element, attribute, 1, where, default)[0]


def sizes(element: Element, attribute: str, count: int, where: str) -> tuple[float, ...]:
    """Return an attribute that consists of ``count`` numbers, none of them negative; raises as ``numbers``."""
    found = numbers(element, attribute, count, where)
    if min(found) < 0.0:
        raise InvalidUrdf(f"{where}: {attribute}= of <{element.tag}> must not be negative: {element.get(attribute)!a}")
    return found


def unit(vector: tuple[float, ...], where: str) -> tuple[float, float, float]:
    """Return the unit vector in the direction of a vector; raise ``InvalidUrdf`` if its length is 0."""
    x, y, z = vector
    length = math.hypot(x, y, z)
    if length < 1e-9:
        raise InvalidUrdf(f"{where}: the axis must not be zero")
    return x / length, y / length, z / length
