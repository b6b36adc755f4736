"""Depth of YAML: what would crash the parser is refused."""

import pytest

from ppaas.errors import InvalidInput
from ppaas.imports.parameters.ros_yaml import read_parameter_file
from ppaas.imports.yaml_depth import MAX_DEPTH, check_depth


@pytest.mark.parametrize("text", [b"[" * 100_000, b"{a: " * 100_000, b"- " * 100_000, b"a:\n" + b"? " * 100_000])
def test_deep_files_are_refused(text: bytes) -> None:
    with pytest.raises(InvalidInput, match=f"nested more than {MAX_DEPTH} deep"):
        check_depth(text, "file.yaml")
    with pytest.raises(InvalidInput, match="nested more than"):
        read_parameter_file(text)


def test_files_up_to_the_limit_pass() -> None:
    check_depth(b"[" * MAX_DEPTH + b"]" * MAX_DEPTH, "file.yaml")
