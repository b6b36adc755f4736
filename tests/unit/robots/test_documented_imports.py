"""Documented imports work, and earlier import paths give the same objects."""

import ast
import importlib
import re
import subprocess
import sys

import pytest

from tests.support.sources import ROOT

PACKAGES = ("ppaas", "robots")

ALIASES = {
    "robots.client:RobotClient": "robots.client.robot_client:RobotClient",
    "robots.client:MoveBaseClient": "robots.client.move_base:MoveBaseClient",
    "robots.client:RestClient": "robots.client.rest:RestClient",
    "robots.client:Login": "robots.client.rest:Login",
    "robots.client:RobotFile": "robots.client.robot_file:RobotFile",
    "robots.client:load_robot_file": "robots.client.robot_file:load_robot_file",
    "robots.onboard:BaseController": "robots.onboard.base_controller:BaseController",
    "robots.onboard:BaseLimits": "robots.onboard.base_controller:BaseLimits",
    "robots.onboard:LocalNodes": "robots.onboard.node_manager:LocalNodes",
    "robots.onboard:run_local_nodes": "robots.onboard.local_nodes:run_local_nodes",
    "robots.onboard:this_computer": "robots.onboard.computer:this_computer",
}
"""Documented names, and the modules that define them."""

DEPRECATED = {
    "robots.move_base_client:MoveBaseClient": "robots.client:MoveBaseClient",
    "robots.move_base_client:GoalOutcome": "robots.client.move_base:GoalOutcome",
    "robots.base_controller:BaseController": "robots.onboard:BaseController",
    "robots.base_controller:BaseLimits": "robots.onboard:BaseLimits",
    "robots.base_controller:STOP": "robots.onboard.base_controller:STOP",
    "robots.rest:RestClient": "robots.client:RestClient",
    "robots.rest:Login": "robots.client:Login",
    "ppaas.planners.many:plan_many": "ppaas.planners.batch.plan_many:plan_many",
    "ppaas.planners.cost_matrix:cost_matrix": "ppaas.planners.batch.cost_matrix:cost_matrix",
}
"""Names at import paths that earlier documents show, and the paths that their warnings name."""


def documented() -> list[str]:
    """Return the imports of our packages in documents and examples, each as ``module:name``."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    blocks = [block for page in pages for block in re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)]
    blocks += [file.read_text() for file in sorted((ROOT / "docs" / "examples").rglob("*.py"))]
    found = {
        f"{node.module}:{alias.name}"
        for block in blocks
        for node in ast.walk(ast.parse(block))
        if isinstance(node, ast.ImportFrom) and node.module and node.module.partition(".")[0] in PACKAGES
        for alias in node.names
    }
    return sorted(found)


def load(path: str) -> object:
    module, _, name = path.partition(":")
    try:
        return getattr(importlib.import_module(module), name)
    except AttributeError as error:
        try:
            return importlib.import_module(f"{module}.{name}")  # which nothing has imported yet
        except ModuleNotFoundError:
            raise error from None


@pytest.mark.parametrize("path", documented())
def test_documented_imports_exist(path: str) -> None:
    load(path)


@pytest.mark.parametrize(("alias", "path"), ALIASES.items())
def test_an_alias_is_the_same_object(alias: str, path: str) -> None:
    assert load(alias) is load(path)


@pytest.mark.parametrize(("alias", "path"), DEPRECATED.items())
def test_an_earlier_import_path_warns_and_names_the_new_one(
    alias: str, path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, new = alias.partition(":")[0], path.partition(":")[0]
    monkeypatch.delitem(sys.modules, module, raising=False)
    with pytest.warns(DeprecationWarning, match=rf"^{re.escape(module)} is deprecated: .*\b{re.escape(new)}\b"):
        found = load(alias)
    assert found is load(path)


def test_no_document_shows_a_deprecated_import_path() -> None:
    assert not {alias.partition(":")[0] for alias in DEPRECATED} & {path.partition(":")[0] for path in documented()}


@pytest.mark.parametrize("package", ["robots.client", "robots.onboard"])
def test_unknown_names_of_a_package_raise_attribute_error(package: str) -> None:
    assert {path.partition(":")[2] for path in ALIASES if path.startswith(f"{package}:")} == set(
        importlib.import_module(package).__all__
    )
    with pytest.raises(AttributeError, match="nothing"):
        load(f"{package}:nothing")


@pytest.mark.parametrize("package", ["robots.client", "robots.onboard"])
def test_importing_a_package_loads_no_heavy_module(package: str) -> None:
    code = f"import sys, {package}; sys.exit(any(m in sys.modules for m in ('asyncio', 'websockets', 'msgspec')))"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0
