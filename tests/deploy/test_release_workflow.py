"""The workflow of releases runs targets of the Makefile, on actions by their commits, with few rights."""

import re
import shutil
import subprocess
from typing import Any

import pytest
import yaml

from tests.support.sources import ROOT

WORKFLOW = ROOT / ".github" / "workflows" / "release.yaml"
JOBS: dict[str, dict[str, Any]] = yaml.safe_load(WORKFLOW.read_text(encoding="utf-8"))["jobs"]
STEPS = [(job, step) for job, found in JOBS.items() for step in found["steps"]]
RUNS = [step["run"] for _, step in STEPS if "run" in step]
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")
TARGETS = set(re.findall(r"^([\w-]+):.*## \S", MAKEFILE, re.MULTILINE))
ACTIONLINT = shutil.which("actionlint", path=ROOT / "build" / "release")


def needed(job: str) -> set[str]:
    """Return the jobs that end before a job, itself included."""
    before = JOBS[job].get("needs", [])
    return {job}.union(*(needed(one) for one in ([before] if isinstance(before, str) else before)))


@pytest.mark.parametrize("line", RUNS)
def test_each_step_is_a_target_of_the_makefile(line: str) -> None:
    words = line.partition(" >> ")[0].split()
    assert words[0] == "make"
    targets = [word for word in words[1:] if not word.startswith("--") and "=" not in word]
    assert targets and set(targets) <= TARGETS
    variables = {word.partition("=")[0] for word in words if "=" in word}
    assert all(f"$({variable})" in MAKEFILE for variable in variables)


@pytest.mark.parametrize("name", sorted({step["uses"] for _, step in STEPS if "uses" in step}))
def test_each_action_is_named_by_its_commit(name: str) -> None:
    assert re.fullmatch(r"actions/[\w-]+@[0-9a-f]{40}", name)


def test_nothing_is_published_before_all_is_built_and_tested() -> None:
    order = [target for line in RUNS for target in line.split() if target in TARGETS]
    publishing = {job for job, step in STEPS if "publish" in step.get("run", "")}
    assert publishing == {"packages", "images", "page"}
    assert all("build" in needed(job) for job in publishing)
    built = [step["run"] for job, step in STEPS if job == "build" and "run" in step]
    assert " ".join(built).count("publish") == 0
    checks = ("release-check", "lint", "test", "dist", "reproduce", "sbom", "image", "sbom-image")
    assert [order.index(target) for target in checks] == sorted(order.index(target) for target in checks)


def test_only_tags_are_published() -> None:
    events = yaml.safe_load(WORKFLOW.read_text())[True]  # YAML reads the key "on" as a truth value
    assert events["push"] == {"tags": ["v*"]}
    for job in ("packages", "images"):
        assert "github.ref_type == 'tag'" in JOBS[job]["if"]
    assert needed("page") == {"page", "packages", "images", "build"}


def test_each_job_has_the_rights_that_it_needs() -> None:
    assert yaml.safe_load(WORKFLOW.read_text())["permissions"] == {}
    rights = {
        job: {right for right, level in found["permissions"].items() if level == "write"} for job, found in JOBS.items()
    }
    attest = {"id-token", "attestations"}
    assert rights == {
        "build": set(),
        "packages": {"id-token"},
        "images": {"packages", *attest},
        "page": {"contents", *attest},
    }
    checkouts = [step for _, step in STEPS if step.get("uses", "").startswith("actions/checkout@")]
    assert len(checkouts) == len(JOBS)
    assert all(step["with"]["persist-credentials"] is False for step in checkouts)


def test_no_step_has_a_value_that_others_choose_in_its_command() -> None:
    assert [line for line in RUNS if "${{" in line] == []


@pytest.mark.skipif(ACTIONLINT is None, reason="no actionlint: make workflow")
def test_actionlint_has_nothing_to_say() -> None:
    assert ACTIONLINT is not None
    done = subprocess.run([ACTIONLINT, str(WORKFLOW)], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
