"""releasing.md names targets, files and commands that there are."""

import re
import shlex

import pytest
import yaml

from deploy.release.publication import PARTS, image_name
from tests.support.documents import blocks, table, text_of
from tests.support.sources import ROOT

PAGE = "docs/releasing.md"
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
TARGETS = set(re.findall(r"^([\w-]+):.*## \S", MAKEFILE, re.MULTILINE))
WORKFLOW = (ROOT / ".github" / "workflows" / "release.yaml").read_text(encoding="utf-8")
LINES = [line for block in blocks(PAGE, "bash") for line in block.splitlines()]
ROWS = table(PAGE, "target", "what it does", "needs")


@pytest.mark.parametrize("line", LINES)
def test_each_command_names_targets_and_variables_of_the_makefile(line: str) -> None:
    program, *words = shlex.split(line)
    assert program == "make"
    assert {word for word in words if "=" not in word} <= TARGETS
    assert all(f"$({word.partition('=')[0]})" in MAKEFILE for word in words if "=" in word)


def test_the_table_has_all_targets_of_the_workflow_but_the_usual_ones() -> None:
    documented = {name for names, _, _ in ROWS for name in re.findall(r"[\w-]+", names)}
    run = {word for line in re.findall(r"run: make (.*)", WORKFLOW) for word in line.split()}
    assert documented - {"reproduce-image"} == (run & TARGETS) - {"setup", "lint", "test"}


def test_the_parts_and_files_are_those_of_the_code() -> None:
    text = text_of(PAGE)
    [parts] = re.findall(r"publishes `PART`: (.*) \|", text.replace(" | ", " |"))[:1]
    assert tuple(re.findall(r"`(\w+)`", parts.partition("|")[0])) == PARTS
    jobs = yaml.safe_load(WORKFLOW)["jobs"]
    assert all(found.get("environment") == "release" for name, found in jobs.items() if name != "build")
    for name in ("ppaas_cloud.cdx.json", "ppaas-engine.cdx.json", "base-image.txt"):
        assert f"`{name}`" in text
        code = MAKEFILE + WORKFLOW + (ROOT / "deploy/release/__main__.py").read_text()
        assert name in code
    assert image_name("VERSION") == "ppaas-engine-VERSION.oci.tar"
