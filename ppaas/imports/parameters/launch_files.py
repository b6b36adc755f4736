"""Parameters in launch files of ROS 1: ``<param>`` and ``<rosparam>`` of each node, with arguments filled in."""

import re
from collections.abc import Mapping
from xml.parsers import expat

import yaml

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.ros_yaml import MAX_DEPTH, GivenValue, ParameterFile, read_parameter_file
from ppaas.imports.report import ImportReport

MAX_LAUNCH = 1 << 20
"""Limit of the size of a launch file [bytes]."""

MAX_ARGUMENT = 256
"""Limit of the length of an argument that is filled in: arguments may be in others, and would grow without end."""

_ARGUMENT = re.compile(r"\$\(arg\s+([\w-]+)\)")
_ELSEWHERE = "each file is read alone: give this one, too"


def read_parameters(content: bytes, report: ImportReport) -> ParameterFile:
    """Read a parameter file in YAML, or a launch file of ROS 1, which begins with ``<``.

    Raises
    ------
    InvalidParameter
        The file is neither, too large, or nested too deeply.
    """
    if not content.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        return read_parameter_file(content)
    if len(content) > MAX_LAUNCH:
        raise InvalidParameter(f"the launch file has {len(content)} bytes; at most {MAX_LAUNCH} are allowed")
    return ParameterFile(_Launch(report).read(content), is_ros2=False, repeated=[])


class _Launch:
    """Reads the elements of a launch file in order.

    Parameters
    ----------
    report : ImportReport
        It names the files that this one loads.
    """

    def __init__(self, report: ImportReport) -> None:
        self._report = report
        self._nodes: dict[str, dict[str, GivenValue]] = {}
        self._arguments: dict[str, str] = {}
        self._open: list[tuple[str, dict[str, str], int]] = []
        self._off = 0
        self._text = ""
        self._parser = expat.ParserCreate()
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._add
        self._parser.StartDoctypeDeclHandler = self._refuse

    def read(self, content: bytes) -> dict[str, dict[str, GivenValue]]:
        """Return the parameters by the executables of their nodes."""
        try:
            self._parser.Parse(content, True)
        except expat.ExpatError as error:
            raise InvalidParameter(f"the launch file is not XML: {error}") from error
        return self._nodes

    def _refuse(self, *_: object) -> None:
        raise InvalidParameter("a launch file must have no document type")

    def _start(self, tag: str, given: Mapping[str, str]) -> None:
        if len(self._open) >= MAX_DEPTH:
            raise InvalidParameter(f"the launch file is nested more than {MAX_DEPTH} deep")
        attributes = {name: self._filled(value) for name, value in given.items()}
        line = self._parser.CurrentLineNumber
        self._open.append((tag, attributes, line))
        self._text = ""
        if self._off or not _is_on(attributes):
            self._off += 1
        elif tag == "arg":
            self._set_argument(attributes)
        elif tag == "include" or (tag == "rosparam" and "file" in attributes):
            self._report.without_effect(f"{tag} {attributes.get('file', '')}", _ELSEWHERE, line)

    def _set_argument(self, attributes: Mapping[str, str]) -> None:
        value = attributes.get("value", attributes.get("default"))
        is_of_another_file = any(tag == "include" for tag, _, _ in self._open)
        if value is not None and len(value) <= MAX_ARGUMENT and not is_of_another_file:
            self._arguments[attributes.get("name", "")] = value

    def _add(self, text: str) -> None:
        self._text += text

    def _end(self, tag: str) -> None:
        _, attributes, line = self._open.pop()
        if self._off:
            self._off -= 1
            return
        node = next((each for name, each, _ in reversed(self._open) if name == "node"), None)
        if node is None or tag not in ("param", "rosparam"):
            return
        values = self._nodes.setdefault(node.get("type") or node.get("name", ""), {})
        name = attributes.get("name" if tag == "param" else "param", "").replace("/", ".")
        if tag == "param" and name and "value" in attributes:
            values[name] = GivenValue(_typed(attributes["value"], attributes.get("type", "auto")), line)
        elif tag == "rosparam" and "file" not in attributes:
            self._add_yaml(values, name or attributes.get("ns", "").replace("/", "."), line)

    def _add_yaml(self, values: dict[str, GivenValue], name: str, line: int) -> None:
        """Add the parameters of inline YAML, whose lines follow the one of its element."""
        text = self._filled(self._text)
        if not text.strip():
            return
        try:
            file = read_parameter_file(text.encode())
        except InvalidParameter:
            values[name] = GivenValue(_typed(text.strip(), "yaml"), line)
            return
        for node, given in file.nodes.items():
            for each, value in given.items():
                path = ".".join(part for part in (name, node.replace("/", "."), each) if part)
                values[path] = GivenValue(value.value, line + value.line - 1)

    def _filled(self, text: str) -> str:
        """Return text with the arguments of this file; others stay as they are."""
        return _ARGUMENT.sub(lambda found: self._arguments.get(found[1], found[0]), text)


def _is_on(attributes: Mapping[str, str]) -> bool:
    """Return whether an element holds by its conditions; one that is not known here counts."""
    wanted, unwanted = attributes.get("if", "true").lower(), attributes.get("unless", "false").lower()
    return wanted not in ("false", "0") and unwanted not in ("true", "1")


def _typed(text: str, kind: str) -> object:
    """Return a value of the type that ``roslaunch`` gives it."""
    if kind in ("str", "string"):
        return text
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        return text
    if kind == "auto" and not isinstance(value, bool | int | float):
        return text
    return float(value) if kind == "double" and isinstance(value, int) else value
