"""Numbers, nodes and commands in rapyuta.md are those of the code; its example does what the page says."""

import json
import re

from endpoints.rapyuta import executor, registry
from endpoints.rapyuta.clone import NODES, ON_REQUEST
from ppaas.wire.rapyuta.interface_types import InterfaceForm, InterfaceRole, check_joinable, interface_type
from ppaas.wire.rapyuta.tags import split_address
from tests.support.documents import table, text_of
from tests.support.sources import ROOT

PAGE = "docs/rapyuta.md"
EXAMPLE = json.loads((ROOT / "docs/examples/rapyuta_tb1.json").read_text())


def test_the_table_of_nodes_is_that_of_the_code() -> None:
    rows = table(PAGE, "package and executable", "node of the clone")
    found = {}
    for names, node in rows:
        for name in names.replace("`", "").split(", "):
            found[tuple(name.split(" "))] = (re.split(r"\W", node.strip("`"))[0], "added" in node)
    assert found == {names: (node, node in ON_REQUEST) for names, node in NODES.items()}


def test_numbers_and_types_are_those_of_the_code() -> None:
    page = " ".join(text_of(PAGE).split())
    assert f"Up to {executor.MAX_CONTAINERS} containers of a robot share its clone" in page
    assert f"A robot that is away for {registry.RECONNECT_TIMEOUT:g} s loses" in page
    assert f"begins with `Invalid Request:` if the robot can mend it, and with `{executor.FULL}`" in page
    assert all(f"`{part}`" in page for part in (*InterfaceRole, *InterfaceForm))


def test_the_client_file_of_the_example_is_consistent() -> None:
    interfaces = {
        (one["eTag"], one["iTag"]): (interface_type(one["iType"]), one["iCls"]) for one in EXAMPLE["interfaces"]
    }
    for pair in EXAMPLE["connections"]:
        one, other = (interfaces.pop(split_address(tag, pair[tag])) for tag in ("tagA", "tagB"))
        check_joinable(one, other)
    assert not interfaces
    assert all((node["pkg"], node["exe"]) in NODES for node in EXAMPLE["nodes"])
