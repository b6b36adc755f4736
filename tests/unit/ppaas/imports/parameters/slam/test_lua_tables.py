"""Tables of Lua files: constants, tables, references and arithmetic; what is computed otherwise is refused."""

import math

import pytest

from ppaas.errors import InvalidParameter
from ppaas.imports.parameters.slam.lua_tables import MAX_LUA, LuaTables, read_lua_tables
from ppaas.imports.report import ImportReport

ALIASES = {"options.map_builder": "MAP", "MAP.graph": "GRAPH"}


def read(text: str) -> tuple[dict[str, object], list[str], LuaTables]:
    report = ImportReport("f.lua")
    tables = read_lua_tables(text.encode(), ALIASES, report)
    return {name: given.value for name, given in tables.values.items()}, [each.text for each in report.entries], tables


def test_constants_tables_and_arithmetic_are_read() -> None:
    values, texts, _ = read(
        "T = {\n  a = 1, b = -2.5e1, ['c'] = \"x\", d = true, sub = { e = false, f = {1, 2} },\n}\n"
        "T.g = math.rad(90.) -- a comment\nT.h = T.a * 2 ^ 3 + 1 / 2\nT.a = 7\n"
    )
    assert texts == []
    assert values == {
        "T.a": 7, "T.b": -25.0, "T.c": "x", "T.d": True, "T.sub.e": False, "T.sub.f": [1, 2],
        "T.g": pytest.approx(math.pi / 2), "T.h": 8.5,
    }  # fmt: skip


def test_tables_have_several_names() -> None:
    values, _, tables = read(
        "options = { map_builder = MAP }\noptions.map_builder.graph.n = 1\nMAP.x = 2\nGRAPH.n = 3\n"
    )
    assert values == {"MAP.x": 2, "GRAPH.n": 3}
    assert tables.values["GRAPH.n"].line == 4


def test_a_table_of_the_file_is_taken_over() -> None:
    assert read("local base = { r = 0.1 }\nT = base\nT.s = 1\n")[0] == {"base.r": 0.1, "T.r": 0.1, "T.s": 1}


def test_a_table_that_is_set_again_replaces_the_earlier_one() -> None:
    assert read("T = { a = 1, b = 2 }\nT = { a = 3 }\n")[0] == {"T.a": 3}


def test_included_files_are_named() -> None:
    assert read('include "map_builder.lua"\nrequire("mine")\n')[2].included == [("map_builder.lua", 1), ("mine", 2)]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("T.a = os.time()", "it is computed"),
        ("T.a = b", "'b' is not set in this file"),
        ("T.a = 1 / 0", "it cannot be computed"),
        ("T.a = 'x' * 2", "'x' is no number"),
        ("T.a = (-1) ^ 0.5", "no real number"),
        ("for i = 1, 3 do T.a = i end", "only assignments of values are read"),
        ("if x then T.a = 1 end", "only assignments of values are read"),
        ("function f() return 1 end", "only assignments of values are read"),
        ("T[f()] = 1", "the name of what is set is computed"),
        ("a, b = f()", "only assignments of values are read"),
        ("T = { a = 1, 2 }", "a list is mixed with names"),
    ],
)
def test_what_is_computed_is_refused_and_the_rest_is_read(line: str, words: str) -> None:
    values, texts, _ = read(f"{line}\nT.rest = 1\n")
    assert values["T.rest"] == 1
    assert len(texts) == 1 and words in texts[0]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"T = {", "the file is not in Lua"),
        (b"T = 1 1", "the file is not in Lua"),
        (b"\xff\xfe", "not in UTF-8"),
        (b"T = " + b"{" * 500 + b"}" * 500, "nested more than"),
        (b"T = " + b"(" * 500 + b"1" + b")" * 500, "nested more than"),
        (b"-" * (MAX_LUA + 1), "at most"),
    ],
)
def test_a_file_that_cannot_be_read_is_an_error(content: bytes, words: str) -> None:
    with pytest.raises(InvalidParameter, match=words):
        read_lua_tables(content, {}, ImportReport("f.lua"))
