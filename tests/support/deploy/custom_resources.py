"""Schemas of custom resources of Kubernetes, from modules of Go in ``build/crds``; as a program, it fetches them."""

import copy
import json
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import yaml

from tests.support.sources import ROOT

FOLDER = ROOT / "build" / "crds"
LOCK = Path(__file__).with_name("crds.lock")


def are_there() -> bool:
    """Return whether ``make helm`` has fetched the definitions."""
    return any(FOLDER.glob("*.yaml"))


def custom_faults(found: dict[str, Any]) -> list[str]:
    """Return what is wrong with a custom resource by its definition; unknown fields are as well."""
    validator = jsonschema.Draft202012Validator(_schema(found["apiVersion"], found["kind"]))
    return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(found)]


@cache
def _schema(api_version: str, kind: str) -> Any:
    group, _, release = api_version.partition("/")
    for file in FOLDER.glob("*.yaml"):
        spec = yaml.load(file.read_bytes(), yaml.CSafeLoader)["spec"]
        if (spec["group"], spec["names"]["kind"]) == (group, kind):
            [version] = [one for one in spec["versions"] if one["name"] == release]
            return strict(version["schema"]["openAPIV3Schema"])
    raise LookupError(f"no definition of {kind} of {api_version}")


def strict(schema: dict[str, Any]) -> dict[str, Any]:
    """Return a schema of Kubernetes that allows no other fields than it names."""
    strictly = copy.deepcopy(schema)
    _forbid_others(strictly)
    strictly["properties"]["metadata"].pop("additionalProperties", None)
    return strictly


def _forbid_others(schema: dict[str, Any]) -> None:
    if "properties" in schema and not schema.get("x-kubernetes-preserve-unknown-fields"):
        schema["additionalProperties"] = False
    inner = [*schema.get("properties", {}).values(), schema.get("items"), schema.get("additionalProperties")]
    for one in inner:
        if isinstance(one, dict):
            _forbid_others(one)


def main() -> None:
    """Fetch the modules of the lock, check their sums, and copy their definitions.

    Raises
    ------
    SystemExit
        A module has another sum than in the lock.
    """
    shutil.rmtree(FOLDER, ignore_errors=True)
    lines = [line.split() for line in LOCK.read_text().splitlines() if not line.startswith("#")]
    for module, version, total, *files in lines:
        command = ["go", "mod", "download", "-json", f"{module}@{version}"]
        fetched = json.loads(subprocess.run(command, check=True, capture_output=True, cwd="/").stdout)
        if fetched["Sum"] != total:
            raise SystemExit(f"{module}@{version} is {fetched['Sum']}, not {total}")
        FOLDER.mkdir(parents=True, exist_ok=True)
        for file in files:
            shutil.copyfile(Path(fetched["Dir"], file), FOLDER / Path(file).name)


if __name__ == "__main__":
    main()
