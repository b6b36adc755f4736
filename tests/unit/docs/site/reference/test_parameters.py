"""The page of parameters has all parameters of all clones."""

import math

import msgspec
import pytest

from docs.site.reference import clones
from docs.site.reference.parameters import COSTMAPS, NODES, descriptions, fields_table, page as parameters_page, prose
from ppaas.controllers.registry import CONTROLLERS
from ppaas.messages import rosapi
from ppaas.messages.base.message import Empty
from ppaas.parameters import Parameters
from ppaas.planners.registry import PLANNERS
from ppaas.recoveries.registry import RECOVERIES

BEHAVIOURS = {"conservative_reset", "aggressive_reset"}
"""Names of recovery behaviours whose type has another name."""


class Example(Parameters, frozen=True):
    """Parameters of an example.

    Parameters
    ----------
    first, second : float
        Two lengths | widths [m].
    names : list of str
        Some names.
    """

    first: float
    second: float = math.pi
    names: list[str] = msgspec.field(default_factory=lambda: ["a"])


@pytest.mark.parametrize("kind", clones.KINDS)
def test_the_page_has_each_parameter_that_a_clone_uses(kind: str) -> None:
    replies: list[rosapi.GetParamNamesResponse] = []
    clones.clone(kind).nodes["parameter_server"].on_call("rosapi/get_param_names", Empty(), replies.append)
    classes = NODES | COSTMAPS
    used = [name.split("/", 2)[1:] for name in replies[0].names]
    own = [(node, name) for node, name in used if node in classes]
    assert [each for each in own if each[1] not in classes[each[0]].__struct_encode_fields__] == []
    plugins = {*PLANNERS.names(), *CONTROLLERS.names(), *RECOVERIES.names()}
    assert {node for node, _ in used} - classes.keys() - plugins - BEHAVIOURS == set()
    assert len(own) > 50


def test_plugins_are_on_the_page() -> None:
    text = parameters_page()
    for registry in (PLANNERS, CONTROLLERS, RECOVERIES):
        assert [name for name in registry.names() if f"### `{name}`" not in text] == []
    assert [name for name in (*NODES, *COSTMAPS) if f"### `{name}`" not in text] == []


def test_a_table_has_defaults_and_descriptions() -> None:
    assert fields_table(Example).splitlines()[2:] == [
        "| `first` |  | Two lengths \\| widths [m]. |",
        "| `second` | `3.141592653589793` | Two lengths \\| widths [m]. |",
        '| `names` | `["a"]` | Some names. |',
    ]


@pytest.mark.parametrize("cls", [*NODES.values(), *COSTMAPS.values()])
def test_each_class_is_described_by_the_names_of_its_parameters(cls: type[Parameters]) -> None:
    assert prose(cls)
    assert descriptions(cls).keys() <= set(cls.__struct_encode_fields__)
