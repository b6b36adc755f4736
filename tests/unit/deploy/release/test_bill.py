"""A bill of materials is valid, is the same in each build, and has the versions of the lock."""

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from deploy.release import bill
from ppaas.errors import InvalidInput

LOCK = """\
# made
msgspec==0.21 \\
    --hash=sha256:00
pywin32==3 ; sys_platform == 'win32' \\
    --hash=sha256:00
Zope.Thing==2
"""
EXPECTED = bill.Expected(bill.pins(LOCK), {"ppaas-cloud": "1.2.0"}, ("pypi", "deb"))
DATE = 1_700_000_000
SUBJECT = "sha256:" + "0" * 64


def component(kind: str, name: str, version: str) -> dict[str, str]:
    return {"type": "library", "name": name, "version": version, "purl": f"pkg:{kind}/{name}@{version}"}


BILL: dict[str, Any] = {
    "bomFormat": "CycloneDX",
    "specVersion": "1.6",
    "serialNumber": "urn:uuid:3e671687-395b-41f5-a30f-a58921a69b79",
    "metadata": {"timestamp": "2026-11-30T00:00:00Z", "tools": {"components": []}},
    "components": [
        component("pypi", "ppaas-cloud", "1.2.0"),
        component("pypi", "msgspec", "0.21"),
        component("pypi", "zope_thing", "2"),
        component("deb", "libc6", "2.36"),
    ],
}


def faults(changed: dict[str, Any]) -> list[str]:
    return list(bill.faults(changed, EXPECTED))


def without(name: str) -> dict[str, Any]:
    return BILL | {"components": [found for found in BILL["components"] if found["name"] != name]}


def test_a_valid_bill_of_the_locked_versions_has_no_faults() -> None:
    assert faults(BILL) == []


def test_a_lock_pins_packages_of_this_computer_by_their_normal_names() -> None:
    assert bill.pins(LOCK) == {"msgspec": "0.21", "zope-thing": "2"}


def test_another_version_than_the_locked_one_is_named() -> None:
    changed = without("msgspec")
    changed["components"].append(component("pypi", "Msgspec", "0.22"))
    assert faults(changed) == ["Msgspec is 0.22, not 0.21 as locked"]


def test_a_bill_without_this_project_or_debian_is_refused() -> None:
    assert faults(without("ppaas-cloud")) == ["ppaas-cloud 1.2.0 is not in it"]
    assert faults(without("libc6")) == ["it has no package of the kind deb"]


def test_a_bill_that_does_not_fit_the_schema_is_refused() -> None:
    changed = copy.deepcopy(BILL)
    changed["components"][0]["colour"] = "red"
    [fault] = faults(changed)
    assert "schema of CycloneDX 1.6" in fault and "colour" in fault


def test_number_and_time_are_the_same_in_each_build(tmp_path: Path) -> None:
    written = []
    for number in ("1", "2"):
        file = tmp_path / f"{number}.json"
        begun = BILL | {"serialNumber": f"urn:uuid:3e671687-395b-41f5-a30f-a58921a69b7{number}"}
        file.write_text(json.dumps(begun))
        assert bill.complete(file, SUBJECT, DATE, EXPECTED) == 4
        written.append(file.read_bytes())
    assert written[0] == written[1]
    found = json.loads(written[0])
    assert found["metadata"] == {"timestamp": "2023-11-14T22:13:20Z", "tools": {"components": []}}
    assert found["serialNumber"] != bill.dated(BILL, "sha256:" + "1" * 64, DATE)["serialNumber"]


def test_a_bill_with_faults_stays_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "bill").write_text(json.dumps(without("libc6")))
    before = (tmp_path / "bill").read_bytes()
    with pytest.raises(InvalidInput, match="bill: it has no package of the kind deb"):
        bill.complete(tmp_path / "bill", SUBJECT, DATE, EXPECTED)
    assert (tmp_path / "bill").read_bytes() == before
