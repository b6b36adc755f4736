"""Names of variables: known, misspelt, and those of Kubernetes."""

import re

import pytest

from endpoints.cli.settings_tree import TABLES
from endpoints.settings.names import CONFIG_VARIABLE, OTHERS, did_you_mean, own_variables, unknown_variables
from endpoints.settings.setting import settings_of
from tests.support.sources import ROOT

SETTINGS = settings_of(TABLES)
KNOWN = {setting.variable for setting in SETTINGS} | OTHERS.keys() | {CONFIG_VARIABLE}
PLACES = (
    "Makefile",
    *["ppaas", "engine", "endpoints", "storage", "robots", "benchmarks", "deploy", "docker", "docs", "tests"],
)
SKIPPED = {"node_modules", "__pycache__", "settings", "test_config.py", "test_settings_tree.py"}
"""Parts of paths with what is not ours, and with misspelt names."""


def test_every_variable_that_something_reads_is_known() -> None:
    found = set()
    for place in PLACES:
        for file in [ROOT / place] if (ROOT / place).is_file() else (ROOT / place).rglob("*"):
            readable = file.suffix in {"", ".py", ".md", ".yaml", ".service", ".sh", ".toml"} and file.is_file()
            if readable and not SKIPPED & set(file.relative_to(ROOT).parts):
                found |= set(re.findall(r"\bPPAAS_[A-Z_]*[A-Z]\b", file.read_text(errors="replace")))
    assert {"PPAAS_TOKEN", "PPAAS_OPTIONS", "PPAAS_DATA", "PPAAS_STORE"} <= found
    assert found - KNOWN == set()


def test_no_setting_has_the_variable_of_something_else() -> None:
    assert not {setting.variable for setting in SETTINGS} & OTHERS.keys()


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("PPAAS_PROT", "PPAAS_PORT"), ("PPAAS_STOER", "PPAAS_STORE"), ("PPAAS_TOKN", "PPAAS_TOKEN"),
        ("PPAAS_LOGLEVEL", "PPAAS_LOG_LEVEL"), ("ppaas_port", "PPAAS_PORT"),
    ],
)  # fmt: skip
def test_a_misspelt_variable_is_named_with_the_nearest_one(name: str, near: str) -> None:
    own = own_variables({name: "1", "PATH": "/bin"})
    assert list(unknown_variables(own, SETTINGS)) == [f"the variable {name} is unknown: did you mean {near}?"]


def test_a_name_that_is_near_to_none_is_named_alone() -> None:
    assert did_you_mean("PPAAS_XYZZY_QUUX_WALDO", KNOWN) == ""


def test_variables_that_are_empty_or_set_by_kubernetes_are_left_out() -> None:
    of_kubernetes = {
        "PPAAS_PORT": "tcp://10.0.0.7:8500",
        "PPAAS_SERVICE_HOST": "10.0.0.7",
        "PPAAS_SERVICE_PORT": "8500",
        "PPAAS_SERVICE_PORT_HTTP": "8500",
        "PPAAS_PORT_8500_TCP": "tcp://10.0.0.7:8500",
        "PPAAS_PORT_8500_TCP_ADDR": "10.0.0.7",
        "PPAAS_PORT_8500_TCP_PORT": "8500",
        "PPAAS_PORT_8500_TCP_PROTO": "tcp",
        "PPAAS_ENDPOINTS_PORT": "tcp://10.0.0.8:8500",
        "PPAAS_ENDPOINTS_SERVICE_HOST": "10.0.0.8",
    }
    assert own_variables(of_kubernetes | {"PPAAS_HOST": ""}) == {}
    assert own_variables({"PPAAS_PORT": "8600"}) == {"PPAAS_PORT": "8600"}
