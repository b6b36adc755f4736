"""Pages of the reference: commands, Markdown, parameters, REST, topics."""

import math
import re

import msgspec
import pytest

from docs.site.reference import clones, messages, rest, schemas, settings, topics
from docs.site.reference.clones import members
from docs.site.reference.commands import page as commands_page
from docs.site.reference.markdown import cell, page, slug, table
from docs.site.reference.parameters import COSTMAPS, NODES, descriptions, fields_table, prose
from docs.site.reference.parameters import page as parameters_page
from docs.site.reference.schema_types import bounds_of, type_of
from endpoints.app import OPERATIONS, description
from endpoints.cli.settings_tree import TABLES
from endpoints.settings.names import OTHERS
from endpoints.settings.setting import settings_of
from ppaas.controllers.registry import CONTROLLERS
from ppaas.messages import rosapi
from ppaas.messages.base.message import Empty
from ppaas.nodes.topics import CMD_VEL, MAP, SCAN, TOPICS
from ppaas.parameters import Parameters
from ppaas.planners.registry import PLANNERS
from ppaas.recoveries.registry import RECOVERIES
from tests.support.sources import pyproject

COMMANDS_PAGE = commands_page()


def section(command: str) -> str:
    """Return what the page says of a command."""
    return COMMANDS_PAGE.partition(f"# `{command}`\n")[2].partition("\n#")[0]


def test_each_command_and_bridge_has_a_section() -> None:
    groups = pyproject()["project"]["entry-points"]
    commands = [f"ppaas {name}" for name in groups["ppaas.commands"]]
    commands += [f"ppaas bridge {name}" for name in groups["ppaas.bridges"]]
    commands += [f"ppaas machine {name}" for name in groups["ppaas.machine_verbs"]]
    assert [command for command in commands if not section(command)] == []


def test_options_have_their_values_and_defaults() -> None:
    text = section("ppaas up")
    assert "`ppaas up [OPTION ...]`" in text
    assert "| `--port PORT` | port; 0 takes a free one (8500) |" in text
    assert "| `--log-level {debug,info,warning,error}` |" in text
    assert "%(" not in COMMANDS_PAGE


def test_each_setting_and_each_other_variable_has_a_row() -> None:
    text = settings.page()
    rows = re.findall(
        r"^\| `([a-z-]+)` \| [a-z ,]+ \| `--([a-z-]+)` \| `PPAAS_[A-Z_]+` \| (?:yes)? \| \S", text, re.MULTILINE
    )
    assert [name for name, _ in rows] == [flag for _, flag in rows] == [each.name for each in settings_of(TABLES)]
    assert re.findall(r"^\| `(PPAAS_[A-Z_]+)` \|", text, re.MULTILINE) == list(OTHERS)


def test_arguments_that_are_not_options_are_in_the_usage() -> None:
    assert "`ppaas map publish " in section("ppaas map publish")
    assert "`ppaas login [user] [OPTION ...]`" in section("ppaas login").replace("USER", "user")


def test_a_cell_is_one_line_and_keeps_its_bars() -> None:
    assert cell("a | b\n  c \\| d") == "a \\| b c \\| d"


def test_a_table_has_a_header_and_is_left_out_if_it_has_no_rows() -> None:
    assert table(("a", "b"), [("1", "2")]) == "| a | b |\n|---|---|\n| 1 | 2 |\n"
    assert table(("a", "b"), []) == ""


@pytest.mark.parametrize(
    ("heading", "anchor"),
    [
        ("`ppaas map publish`", "ppaas-map-publish"),
        ("`nav_msgs/Path`", "nav_msgspath"),
        ("3D maps", "3d-maps"),
    ],
)
def test_an_anchor_is_that_of_its_heading(heading: str, anchor: str) -> None:
    assert slug(heading) == anchor


def test_a_page_has_an_empty_line_between_its_parts() -> None:
    assert page("# A", "", "text\n") == "# A\n\ntext\n"


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


REST_PAGE, SCHEMAS = rest.page(), schemas.page()


def test_each_operation_and_each_schema_has_a_section() -> None:
    headings = re.findall(r"^### `(.*)`$", REST_PAGE, re.MULTILINE)
    assert sorted(headings) == sorted(f"{method} {path}" for path, methods in OPERATIONS for method in methods)
    assert re.findall(r"^## `(.*)`$", SCHEMAS, re.MULTILINE) == sorted(description()["components"]["schemas"])


def test_types_are_words_and_links() -> None:
    assert type_of({"$ref": "#/components/schemas/Pose"}) == "[`Pose`](schemas.md#pose)"
    assert type_of({"anyOf": [{"type": "string"}, {"type": "null"}]}) == "string or null"
    assert type_of({"type": "array", "items": {"type": "number"}}) == "array of number"
    assert type_of({"type": "array", "prefixItems": [{"type": "number"}, {"const": "a"}]}) == "array of (number, `a`)"
    assert type_of({"type": "object", "additionalProperties": {"type": "integer"}}) == "object of integer"
    assert type_of({"enum": ["a", "b"]}) == "`a` or `b`"
    assert bounds_of({"type": "integer", "minimum": 1, "maximum": 20}) == "at least 1, at most 20"


def test_an_operation_has_its_parameters_bodies_and_problems() -> None:
    text = REST_PAGE.partition("### `POST /v1/maps/{map_id}/plans`\n")[2].partition("\n### ")[0]
    assert "`map_id` (required) | path | string" in text
    assert "Body, `application/json`: [`" in text
    assert re.search(r"\[Problems\]\(schemas\.md#problem\): .*404, .*422", text)


TOPICS_PAGE, MESSAGES = topics.page(), messages.page()


def test_each_topic_of_the_table_and_each_service_has_a_row() -> None:
    rows = re.findall(r"^\| `([\w/]+)` \|", TOPICS_PAGE, re.MULTILINE)
    services = {service.name for member in members() for service in member.node.services}
    assert {*TOPICS, *services} - set(rows) == set()


def test_rows_have_nodes_and_delivery() -> None:
    kind, nodes = "[`geometry_msgs/Twist`](messages.md#geometry_msgstwist)", "`docking_server`, `move_base`"
    assert f"| `cmd_vel` | {kind} | {nodes} |" in TOPICS_PAGE
    assert topics.delivery(MAP) == ["latched", "lasting"]
    assert topics.delivery(SCAN) == ["stream", "robot only"]
    assert topics.delivery(CMD_VEL) == ["stream"]


def test_each_type_that_is_named_has_a_section() -> None:
    sections = {slug(heading) for heading in re.findall(r"^#+ (.*)$", MESSAGES, re.MULTILINE)}
    assert (
        set(re.findall(r"messages\.md#([\w-]+)", TOPICS_PAGE)) | set(re.findall(r"\]\(#([\w-]+)", MESSAGES)) <= sections
    )
    assert "| `linear` | [`geometry_msgs/Vector3`](#geometry_msgsvector3) |" in MESSAGES
