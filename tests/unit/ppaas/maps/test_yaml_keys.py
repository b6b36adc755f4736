"""YAML files as people and programs write them: every file that yaml-cpp reads for map_server and Nav2 is read alike.

The kind, and its members: tabs (after colons and dashes, before comments and brackets, on blank lines, at line ends);
line ends of Windows and of old Macs; byte-order marks, UTF-16 and UTF-32 with and without a mark, comments and file
names in Latin-1, GBK or any other code page; several documents, and a last line of dashes; keys twice (the first
counts); values that YAML 1.1 would take for another type (``on``, ``007``, ``1_000``, dates); numbers as ``-.5``,
``+5.`` and ``1e-2``, also in quotes; values left empty; anchors and aliases; tags; braces instead of lines. What only
YAML 1.1 or Python reads (sexagesimal numbers, merge keys, objects of Python) is not interpreted.
"""

import codecs
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidMap
from ppaas.maps.formats.map_yaml import Rules, parse_yaml, with_image, with_rules
from ppaas.maps.yaml_keys import read_keys, with_key
from tests.support.world.maps import YAML

KEYS = {"image": "a.pgm", "origin": ["0", "-.5", "0"]}
PLAIN = "image: a.pgm\norigin: [0, -.5, 0]\n"


@pytest.mark.parametrize(
    "text",
    [
        "image:\ta.pgm\norigin:\t[0,\t-.5,\t0]\n",
        "image: a.pgm\t\norigin: [0, -.5, 0]\t\t# comment\n",
        "image: a.pgm\n\t\norigin: [0, -.5, 0]\n \t \n",
        "\t# comment\nimage: a.pgm\n\t# 注释\norigin: [0, -.5, 0]\n\t",
        "image\t:\ta.pgm\norigin:\n  -\t0\n  - \t-.5\n  -\t0\n",
        "image: a.pgm\norigin:\n\t[0, -.5, 0]\n",
        "image: a.pgm\norigin: [0,\n\t-.5,\n\t0\n\t]\n",
        "---\t\nimage: a.pgm\norigin: [0, -.5, 0]\n",
    ],
)
def test_tabs_are_white_space_wherever_yaml_cpp_takes_them(text):
    assert read_keys(text.encode()) == KEYS
    assert read_keys(text.replace("\n", "\r\n").encode()) == KEYS


def test_tabs_in_quotes_are_part_of_the_text():
    assert read_keys(b"image: 'a\tb.pgm'\n") == {"image": "a\tb.pgm"}


@pytest.mark.parametrize("text", ["image: a.pgm\n\torigin: [0, 0, 0]\n", "origin:\n\t- 0\n"])
def test_a_tab_that_indents_a_key_is_refused_in_one_line(text):
    with pytest.raises(InvalidMap, match=r"line 2, column 1: .*; indent with spaces") as refused:
        read_keys(text.encode())
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize(
    "encoding",
    ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-32-le", "utf-32-be"],
)
def test_every_encoding_of_unicode_and_every_line_end_is_read(encoding, end):
    text = f"# Büro 地图\n{PLAIN}".replace("\n", end)
    assert read_keys(text.encode(encoding)) == KEYS


def test_big_endian_text_with_a_byte_order_mark_is_read():
    assert read_keys(codecs.BOM_UTF16_BE + PLAIN.encode("utf-16-be")) == KEYS


@pytest.mark.parametrize(("encoding", "name"), [("latin-1", "Büro.pgm"), ("gbk", "地图.pgm"), ("cp1252", "a€.pgm")])
def test_names_in_other_code_pages_are_the_bytes_of_the_file_name(encoding, name):
    keys = read_keys(f"# {name}\nimage: {name}\n".encode(encoding))
    assert keys is not None
    image = keys["image"]
    assert isinstance(image, str)
    assert os.fsencode(image) == name.encode(encoding)


def test_text_that_is_no_text_is_refused():
    with pytest.raises(InvalidMap, match="not valid UTF-16"):
        read_keys(codecs.BOM_UTF16_LE + b"a")


@pytest.mark.parametrize("more", ["---\nimage: b.pgm\n", "---\n", "...\n", "---\n: : [\n"])
def test_the_first_document_counts_and_nothing_after_it_is_read(more):
    assert read_keys((PLAIN + more).encode()) == KEYS
    assert read_keys(("%YAML 1.2\n---\n" + PLAIN + more).encode()) == KEYS


def test_the_first_of_equal_keys_counts():
    assert read_keys((PLAIN + "image: b.pgm\norigin: 1\n").encode()) == KEYS


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("on", "on"),
        ("007", "007"),
        ("1_000", "1_000"),
        ("2020-01-01", "2020-01-01"),
        ("2020-99-99", "2020-99-99"),
        ("0x10", "0x10"),
        ("'0.05'", "0.05"),
        ("!!float x", "x"),
        ("!!python/name:os.getcwd x", "x"),
        ("2nd floor (new).pgm", "2nd floor (new).pgm"),
        ("C:\\maps\\a.pgm", "C:\\maps\\a.pgm"),
        ("", None),
        ("~", None),
        ("null", None),
        ("'~'", "~"),
        ("{x: {y: 1}}", {}),
        ("[[1, 2], {a: b}]", [["1", "2"], {}]),
    ],
)
def test_scalars_are_text_whatever_they_look_like(text, value):
    assert read_keys(f"key: {text}\n".encode()) == {"key": value}


def test_anchors_are_followed_and_merge_keys_are_not():
    text = b"a: &half 0.5\nb: *half\nc: &more {d: 1}\n<<: *more\ne: [*half, *half]\n"
    assert read_keys(text) == {"a": "0.5", "b": "0.5", "c": {}, "<<": {}, "e": ["0.5", "0.5"]}


def test_a_file_that_doubles_with_each_alias_takes_no_more_than_its_size():
    lines = ["l0: &l0 [x]", *(f"l{n}: &l{n} [*l{n - 1}, *l{n - 1}]" for n in range(1, 40))]
    assert len(read_keys("\n".join(lines).encode()) or {}) == 40
    merged = ["m0: &m0 {a: 1}", *(f"m{n}: &m{n}\n  <<: *m{n - 1}\n  b: 1" for n in range(1, 500))]
    assert len(read_keys("\n".join(merged).encode()) or {}) == 500


@pytest.mark.parametrize(
    "text", [b"", b"# nothing\n", b"---\n---\nimage: a.pgm\n", b"words", b"[1, 2]", b"\xef\xbb\xbf"]
)
def test_a_first_document_that_is_not_a_mapping_has_no_keys(text):
    assert read_keys(text) is None


@pytest.mark.parametrize(
    "text", [b"a: [", b"[" * 5000, b"- " * 5000, b"a: " + b"- " * 200 + b"b", b"a: @b", b"a: \x01"]
)
def test_text_that_is_not_yaml_or_nested_without_end_is_refused(text):
    with pytest.raises(InvalidMap, match="cannot be read"):
        if read_keys(text) is None:
            raise InvalidMap("cannot be read")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16-le", "latin-1"])
@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ("# ü\nimage: a.pgm  # ü\nx: 1\n", "# ü\nimage: b.pgm  # ü\nx: 1\n"),
        ("image: 'a b.pgm'\r\nx: 1\r\n", "image: b.pgm\r\nx: 1\r\n"),
        ("image:\nx: 1\n", "image: b.pgm\nx: 1\n"),
        ("{image: a.pgm, x: 1}\n", "{image: b.pgm, x: 1}\n"),
        ("# ü\n  x: 1\n  y: 2\n", "# ü\n  image: b.pgm\n  x: 1\n  y: 2\n"),
        ("--- # ü\nx: 1\n---\nx: 2\n", "--- # ü\nimage: b.pgm\nx: 1\n---\nx: 2\n"),
        ("{x: 1, y: [2]}", "{image: b.pgm, x: 1, y: [2]}"),
        ("x:\t1\n\t\nimage:\ta.pgm\t\nimage: c.pgm\n", "x:\t1\n\t\nimage:\tb.pgm\t\nimage: c.pgm\n"),
    ],
)
def test_a_key_is_set_and_every_other_byte_stays(text, changed, encoding):
    assert with_key(text.encode(encoding), "image", "b.pgm") == changed.encode(encoding)


@given(st.text(min_size=1))
def test_any_text_can_be_set(value):
    assert read_keys(with_key(PLAIN.encode(), "image", value)) == KEYS | {"image": value}


@pytest.mark.parametrize("text", [b"words", b"{}", b"image: [a]\n"])
def test_a_key_cannot_be_set_where_there_is_none(text):
    with pytest.raises(InvalidMap, match="map_server record"):
        with_key(text, "image", "b.pgm")


@given(st.binary(max_size=80))
def test_arbitrary_bytes_are_read_or_raise_invalid_map(rubbish):
    for text in (rubbish, PLAIN.encode() + rubbish, b"image: " + rubbish):
        try:
            keys = read_keys(text)
        except InvalidMap as error:
            assert "\n" not in str(error)
        else:
            assert keys is None or isinstance(keys, dict)


def test_rules_default_to_map_server_unless_record_or_caller_set_them():
    assert parse_yaml(YAML).rules is Rules.MAP_SERVER
    assert parse_yaml(YAML + b"rules: nav2\n").rules is Rules.NAV2
    assert parse_yaml(YAML, Rules.NAV2).rules is Rules.NAV2
    assert parse_yaml(YAML + b"rules: nav2\n", Rules.MAP_SERVER).rules is Rules.MAP_SERVER


@pytest.mark.parametrize("missing", ["occupied_thresh", "free_thresh"])
def test_only_nav2_rules_require_both_thresholds(missing):
    record = b"\n".join(line for line in YAML.splitlines() if not line.startswith(missing.encode()))
    assert parse_yaml(record).rules is Rules.MAP_SERVER
    for ask in (lambda: parse_yaml(record, Rules.NAV2), lambda: parse_yaml(record + b"\nrules: nav2")):
        with pytest.raises(InvalidMap, match=f"`{missing}`, which Nav2's rules require"):
            ask()


def test_unknown_rules_are_refused():
    with pytest.raises(InvalidMap, match="rules"):
        parse_yaml(YAML + b"rules: gmapping\n")


@pytest.mark.parametrize("record", [YAML, YAML + b"rules: map_server\n", b"{" + YAML.replace(b"\n", b",") + b"}"])
def test_with_rules_sets_the_rules_and_keeps_the_rest(record):
    given = with_rules(record, Rules.NAV2)
    assert parse_yaml(given) == parse_yaml(record, Rules.NAV2)
    assert with_rules(given, Rules.NAV2) == given


def test_with_rules_keeps_the_bytes_if_the_rules_are_set():
    assert with_rules(YAML, Rules.MAP_SERVER) == YAML


def test_with_rules_keeps_comments_and_every_other_byte():
    record = b"# measured in May\r\n" + YAML + b"rules: map_server # ours\n---\nx: 1\n"
    assert with_rules(record, Rules.NAV2) == record.replace(b"rules: map_server", b"rules: nav2")
    assert with_rules(YAML, Rules.NAV2) == b"rules: nav2\n" + YAML


def test_with_image_sets_the_name_of_the_image_alone():
    assert with_image(YAML, "my map.pgm") == YAML.replace(b"a.pgm", b'"my map.pgm"')
    with pytest.raises(InvalidMap, match="resolution"):
        with_image(b"image: a.pgm\n", "b.pgm")


def test_with_rules_refuses_records_without_thresholds():
    with pytest.raises(InvalidMap, match="free_thresh"):
        with_rules(YAML.replace(b"free_thresh: 0.196", b""), Rules.NAV2)
    with pytest.raises(InvalidMap, match="map_server record"):
        with_rules(b"words", Rules.NAV2)
