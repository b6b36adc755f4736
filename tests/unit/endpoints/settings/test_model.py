"""Model of the settings of a command: types are strict in files, and all that is wrong is named."""

from typing import Any

import pytest

from endpoints.cli.settings_tree import TABLES
from endpoints.settings.model import read_values
from endpoints.settings.setting import settings_of

UP = [setting for setting in settings_of(TABLES) if setting.table == "up"]


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("port", "8600", "valid integer"), ("port", True, "valid integer"), ("port", 8600.0, "valid integer"),
        ("port", 65536, "from 0 to 65535"), ("linger", "5", "valid number"), ("linger", -1, "at least 0 seconds"),
        ("host", 3, "valid string"), ("data", 3, "valid string"), ("allow", "a:b", "valid list"),
        ("allow", [3], "0: Input should be a valid string"), ("quota", ["maps=3"], "valid dictionary"),
        ("quota", {"maps": "3"}, "maps: Input should be a valid number"), ("quota", {"maps": 1.5}, "NUMBER"),
        ("quota", {"cakes": 1}, "unknown quota 'cakes'"), ("standby", "true", "valid boolean"),
        ("log-level", "loud", "'debug', 'info', 'warning' or 'error'"), ("tls-cert", ["a"], "valid string"),
    ],
)  # fmt: skip
def test_a_value_of_another_type_is_refused(name: str, value: Any, words: str) -> None:
    values, faults = read_values(UP, {name: value, "host": "::"} if name != "host" else {name: value}, {})
    assert values == {}
    ((setting, found),) = faults.items()
    assert setting.name == name and words in found


def test_all_faults_are_named_and_no_secret() -> None:
    _, faults = read_values(UP, {"port": "x", "cores": 0, "store": "cassandra://ann:secret@host/keys"}, {})
    assert {setting.name for setting in faults} == {"port", "cores", "store"}
    assert "secret" not in str(list(faults.values()))


def test_only_what_is_given_has_a_value() -> None:
    values, faults = read_values(UP, {"cores": 2, "linger": 7}, {"PPAAS_CORES": "3"})
    assert ({setting.name: value for setting, value in values.items()}, faults) == ({"cores": 3, "linger": 7.0}, {})
