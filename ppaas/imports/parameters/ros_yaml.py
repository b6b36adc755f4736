"""Parameter files of ROS 1 and ROS 2 as YAML, with the line of each value.

Source: ROS 2 design of parameter files (``rcl_yaml_param_parser``): ``NODE: {ros__parameters: {…}}``, with namespaces,
``/**`` for all nodes, and nested mappings whose names are joined by dots. ROS 1: mappings without ``ros__parameters``.
"""

import re
from collections.abc import Iterator
from typing import Any

import msgspec
import yaml

from ppaas.errors import InvalidParameter
from ppaas.imports.collection import uncollected
from ppaas.imports.yaml_depth import check_depth

MAX_FILE = 2 << 20
"""Limit of the size of a parameter file [bytes]."""

MAX_DEPTH = 32
"""Largest depth of nesting."""

MAX_VALUES = 100_000
"""Largest number of values, with those that aliases repeat."""

ROS2_KEY = "ros__parameters"

_MARK = re.compile(rb"^(<{7}|>{7}) ", re.MULTILINE)

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class GivenValue(msgspec.Struct, frozen=True):
    """A parameter's value, and the line that it is in, from 1."""

    value: Any
    line: int


class ParameterFile(msgspec.Struct, frozen=True):
    """Parameters of a file.

    Parameters
    ----------
    nodes : dict of dict
        Values by the dotted names of parameters, by the name of their node: ``local_costmap/local_costmap``. The node
        is empty for the parameters of a file of ROS 1 that stand outside any mapping.
    is_ros2 : bool
        Whether a node has ``ros__parameters``.
    repeated : list of (str, int)
        Names that occur twice in one mapping, with the line of the later one, which counts.
    """

    nodes: dict[str, dict[str, GivenValue]]
    is_ros2: bool
    repeated: list[tuple[str, int]]


_MERGE = "tag:yaml.org,2002:merge"

_Leaf = tuple[tuple[str, ...], GivenValue]
"""Names above and of a value, and the value."""

_Pair = tuple[yaml.Node, yaml.Node]


@uncollected()
def read_parameter_file(text: bytes) -> ParameterFile:
    """Read a parameter file. Values with substitutions, such as ``$(find pkg)``, stay text.

    Raises
    ------
    InvalidParameter
        The file is no YAML with a mapping, too large, or nested too deeply; the text names the line.
    """
    if len(text) > MAX_FILE:
        raise InvalidParameter(f"the parameter file has {len(text)} bytes; at most {MAX_FILE} are allowed")
    try:
        check_depth(text, "the parameter file")
        loader = _LOADER(text)
        try:
            root = loader.get_single_node()
            reader = _Reader(loader)
            return reader.file(root)
        finally:
            loader.dispose()
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = "" if mark is None else f"line {mark.line + 1}, column {mark.column + 1}: "
        why = getattr(error, "problem", None) or " ".join(str(error).split())
        raise InvalidParameter(f"the parameter file is no YAML: {_mark_of_git(text) or where + why}") from error


def _mark_of_git(text: bytes) -> str:
    """Return where a merge of git has left its marks in a file; empty if it has none."""
    found = _MARK.search(text)
    if found is None:
        return ""
    line = text.count(b"\n", 0, found.start()) + 1
    return f"line {line} is a mark of git, which has not merged two versions: keep the lines of one, and no marks"


class _Reader:
    """Flattens the nodes of a YAML document, of which aliases are counted each time."""

    def __init__(self, loader: Any) -> None:
        self._loader = loader
        self._left = MAX_VALUES
        self._merged: dict[int, dict[str, _Pair]] = {}
        self.repeated: list[tuple[str, int]] = []

    def file(self, root: yaml.Node | None) -> ParameterFile:
        if not isinstance(root, yaml.MappingNode):
            raise InvalidParameter("the parameter file must be a mapping of nodes or parameters")
        flat = dict(self._flat(root, (), 0))
        is_ros2 = any(ROS2_KEY in path for path in flat)
        nodes: dict[str, dict[str, GivenValue]] = {}
        for path, value in flat.items():
            node, name = _split(path, is_ros2=is_ros2)
            nodes.setdefault(node, {})[name] = value
        return ParameterFile(nodes, is_ros2, self.repeated)

    def _flat(self, node: yaml.MappingNode, above: tuple[str, ...], depth: int) -> Iterator[_Leaf]:
        if depth > MAX_DEPTH:
            raise InvalidParameter(f"the parameter file is nested more than {MAX_DEPTH} deep")
        for name, (_, value) in self._pairs(node, above, 0).items():
            yield from self._values(value, (*above, name), depth + 1)

    def _pairs(self, node: yaml.MappingNode, above: tuple[str, ...], depth: int) -> dict[str, _Pair]:
        """Return the keys of a mapping and the merged ones (``<<``). Each mapping is merged once."""
        if id(node) in self._merged:
            return self._merged[id(node)]
        if depth > MAX_DEPTH:
            raise InvalidParameter(f"the parameter file merges mappings more than {MAX_DEPTH} deep")
        merged: dict[str, _Pair] = {}
        own: dict[str, _Pair] = {}
        for key, value in node.value:
            if key.tag == _MERGE:
                for each in value.value if isinstance(value, yaml.SequenceNode) else (value,):
                    if not isinstance(each, yaml.MappingNode):
                        raise InvalidParameter(
                            f"line {key.start_mark.line + 1}: << must be a mapping, or a list of them"
                        )
                    merged = self._pairs(each, above, depth + 1) | merged
                continue
            name = str(self._constructed(key))
            if name in own:
                self.repeated.append((".".join((*above, name)), key.start_mark.line + 1))
            own[name] = (key, value)
        self._merged[id(node)] = merged | own
        return self._merged[id(node)]

    def _values(self, node: yaml.Node, path: tuple[str, ...], depth: int) -> Iterator[_Leaf]:
        if isinstance(node, yaml.MappingNode) and node.value:
            yield from self._flat(node, path, depth)
            return
        self._left -= self._size(node, depth)
        if self._left < 0:
            raise InvalidParameter(f"the parameter file has more than {MAX_VALUES} values")
        yield path, GivenValue(self._constructed(node), node.start_mark.line + 1)

    def _constructed(self, node: yaml.Node) -> Any:
        """Return the value of a node; what only looks like a date or a number, such as 2026-13-45, is text."""
        try:
            return self._loader.construct_object(node, deep=True)
        except ValueError as error:
            if isinstance(node, yaml.ScalarNode):
                return node.value
            raise InvalidParameter(f"line {node.start_mark.line + 1}: {error}") from error

    def _size(self, node: yaml.Node, depth: int) -> int:
        """Return the number of scalars of a value, before it is constructed."""
        if depth > MAX_DEPTH:
            raise InvalidParameter(f"the parameter file is nested more than {MAX_DEPTH} deep")
        if isinstance(node, yaml.SequenceNode):
            total = 1
            for each in node.value:
                total += self._size(each, depth + 1)
                if total > self._left:
                    break
            return total
        if isinstance(node, yaml.MappingNode):
            return 1 + sum(self._size(each, depth + 1) for _, each in node.value)
        return 1


def _split(path: tuple[str, ...], *, is_ros2: bool) -> tuple[str, str]:
    """Return the node and the dotted name of a parameter."""
    if is_ros2 and ROS2_KEY in path:
        at = path.index(ROS2_KEY)
        return "/".join(each.strip("/") for each in path[:at]), ".".join(path[at + 1 :])
    if len(path) == 1:
        return "", path[0]
    return path[0].strip("/"), ".".join(path[1:]).replace("/", ".")
