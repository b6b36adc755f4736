"""kubernetes.md names values, objects and commands that there are; tests/deploy/test_chart.py renders its values."""

import re
import shlex

import yaml

from tests.support.documents import blocks, table, text_of
from tests.support.sources import ROOT

PAGE = "docs/kubernetes.md"
CHART = ROOT / "deploy" / "helm" / "ppaas"
VALUES = yaml.safe_load((CHART / "values.yaml").read_text())


def value_of(path: str) -> object:
    found = VALUES
    for name in path.split("."):
        found = found[name]
    return found


def test_the_values_are_those_of_the_chart_with_their_defaults() -> None:
    for names, default, _ in table(PAGE, "value", "default", "what it is"):
        for name in names.split(", "):
            found = value_of(name)
            shown = {"": "", "{}": {}}.get(default, default)
            assert str(found).lower() == str(shown).lower(), name


def test_other_values_in_the_text_exist() -> None:
    prefixes = "|".join(VALUES)
    for name in set(re.findall(rf"`((?:{prefixes})\.[\w.]+)`", text_of(PAGE))):
        value_of(name)


def test_secrets_that_are_made_are_those_of_the_values() -> None:
    commands = "\n".join(blocks(PAGE, "text"))
    made = set(re.findall(r"create secret generic (\S+)", commands))
    keys = set(re.findall(r"--from-literal=([\w-]+)=", commands))
    used = yaml.safe_load(blocks(PAGE, "yaml")[0])
    assert made == {used["master"]["passwordSecret"], used["stores"]["urlSecret"], used["machines"]["joinSecret"]}
    templates = "".join(path.read_text() for path in (CHART / "templates").iterdir())
    assert all(f"key: {key}," in templates for key in keys)


def test_helm_installs_a_chart_that_is_there() -> None:
    lines = [shlex.split(line) for block in blocks(PAGE, "text") for line in block.splitlines() if "helm " in line]
    assert lines and all((ROOT / words[3] / "Chart.yaml").is_file() for words in lines)


def test_the_oldest_kubernetes_is_that_of_the_chart() -> None:
    wanted = yaml.safe_load((CHART / "Chart.yaml").read_text())["kubeVersion"]
    [oldest] = re.findall(r"Kubernetes (\d\.\d+)\s+or newer", text_of(PAGE))
    assert wanted == f">={oldest}.0-0"
