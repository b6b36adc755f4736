"""XML of strangers: read without entities, and its attributes as finite numbers."""

import math
import re
from xml.etree.ElementTree import Element, ParseError

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import fromstring

from ppaas.errors import InvalidUrdf, MessageTooLarge

MAX_BYTES = 1 << 20
"""That of a PR2, a robot of 90 links and two arms, is a third of it."""

MAX_NAME = 256
MAX_NUMBER = 1e6

_ENCODING = re.compile(r"""\s*<\?xml[^>]*\bencoding\s*=\s*["']([^"']*)["']""")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


def read_document(data: bytes) -> Element:
    """Return the root element of an XML document.

    Raises
    ------
    MessageTooLarge
        It has more than ``MAX_BYTES``.
    InvalidUrdf
        It is not XML in UTF-8, or has a document type or entities, which a URDF never needs.
    """
    if len(data) > MAX_BYTES:
        raise MessageTooLarge(f"a URDF may have {MAX_BYTES} bytes, not {len(data)}")
    try:
        root = fromstring(_text(data), forbid_dtd=True)
    except DefusedXmlException as error:
        raise InvalidUrdf("a URDF may have no document type and no entities: leave them out") from error
    except (ParseError, ValueError) as error:
        raise InvalidUrdf(f"this is not XML: {error}") from error
    assert isinstance(root, Element)
    return root


def _text(data: bytes) -> str:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InvalidUrdf("a URDF must be text in UTF-8: save it so") from error
    declared = _ENCODING.match(text)
    if declared and not text.isascii() and declared[1].lower() not in ("utf-8", "utf8"):
        raise InvalidUrdf(f"a URDF must be text in UTF-8, and says that it is {declared[1][:32]!a}: save it so")
    return text


def name_of(element: Element, attribute: str = "name") -> str:
    """Return an attribute that names something.

    Raises
    ------
    InvalidUrdf
        It is missing, empty or too long.
    """
    name = element.get(attribute, "").strip()
    if not 0 < len(name) <= MAX_NAME:
        raise InvalidUrdf(f"<{element.tag[:MAX_NAME]}> needs {attribute}=, of {MAX_NAME} characters at most")
    return name


def required(element: Element, child: str, where: str) -> Element:
    """Return a child element; ``InvalidUrdf`` if it is missing, with a text that says ``where``."""
    found = element.find(child)
    if found is None:
        raise InvalidUrdf(f"{where} has no <{child}>")
    return found


def numbers(element: Element, attribute: str, count: int, where: str, default: str | None = None) -> tuple[float, ...]:
    """Return an attribute of so many numbers.

    Raises
    ------
    InvalidUrdf
        It is missing and has no default, or is not so many finite numbers of a size that a robot may have.
    """
    text = element.get(attribute, default)
    if text is None:
        raise InvalidUrdf(f"{where}: <{element.tag}> needs {attribute}=")
    words = text.split()
    found = tuple(float(word) for word in words if _NUMBER.fullmatch(word))
    if len(found) != count or len(words) != count or not all(abs(number) <= MAX_NUMBER for number in found):
        what = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InvalidUrdf(f"{where}: {attribute}={text[:64]!a} of <{element.tag}> must be {what}")
    return found


def number(element: Element, attribute: str, where: str, default: str | None = None) -> float:
    """Return an attribute of one number; raises as ``numbers``."""
    return numbers(element, attribute, 1, where, default)[0]


def sizes(element: Element, attribute: str, count: int, where: str) -> tuple[float, ...]:
    """Return an attribute of numbers that are none of them negative; raises as ``numbers``."""
    found = numbers(element, attribute, count, where)
    if min(found) < 0.0:
        raise InvalidUrdf(f"{where}: {attribute}={element.get(attribute)!a} of <{element.tag}> must not be negative")
    return found


def unit(vector: tuple[float, ...], where: str) -> tuple[float, float, float]:
    """Return a vector of length 1 in the same direction; ``InvalidUrdf`` if it has none."""
    x, y, z = vector
    length = math.hypot(x, y, z)
    if length < 1e-9:
        raise InvalidUrdf(f"{where}: the axis must not be zero")
    return x / length, y / length, z / length
