"""The key ``rules`` of a map's record."""

import pytest

from ppaas.errors import InvalidMap
from ppaas.maps.formats.map_yaml import Rules, parse_yaml, with_image, with_rules
from tests.support.world.maps import YAML


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
