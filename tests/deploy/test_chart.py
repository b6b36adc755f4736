"""The Helm chart renders objects of Kubernetes that are valid, confined, and fit each other and this project."""

import re
import shutil
import subprocess
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml

from ppaas import __version__
from robots.cli.main import main
from tests.support.deploy.custom_resources import are_there, custom_faults
from tests.support.deploy.helm_tools import faults, helm_program
from tests.support.documents import blocks
from tests.support.sources import ROOT

CHART = ROOT / "deploy" / "helm" / "ppaas"
RULES = ROOT / "deploy" / "prometheus" / "ppaas.rules.yaml"
RELEASE = "robots"
HELM = helm_program()
OLDEST, NEWEST = "1.27", "1.37"
"""Versions of Kubernetes whose schemas the objects are compared with."""

pytestmark = pytest.mark.skipif(HELM is None, reason="no helm: make helm")

SECRETS = "stores: {urlSecret: s}\n"
CASES = {
    "one node": "",
    "as documented": blocks("docs/kubernetes.md", "yaml")[0],
    "numbered": f"""{SECRETS}
machines: {{kind: StatefulSet, joinSecret: j, replicas: 3, labels: {{hall: "2"}}, tolerations: [{{operator: Exists}}]}}
master: {{cores: 2, nodeSelector: {{a: b}}, data: {{storageClass: fast, size: 1Gi}}}}
image: {{tag: other, pullSecrets: [{{name: p}}]}}
settings: {{up: {{quota: {{stored_bytes: 10000000000, cores: 2.5}}, linger: 60}}}}
service: {{type: LoadBalancer, annotations: {{a: b}}}}
ingress: {{enabled: true, host: robots.example, className: nginx, annotations: {{a: b}}}}
metrics: {{scrapeAnnotations: true, serviceMonitor: {{enabled: true, labels: {{release: p}}}}}}
networkPolicy: {{clientsFrom: [{{ipBlock: {{cidr: 10.0.0.0/8}}}}], metricsFrom: [], egress: []}}
""",
    "without endpoints of machines": f"{SECRETS}machines: {{kind: DaemonSet, joinSecret: j, endpoints: 0}}",
    "bare": "networkPolicy: {enabled: false}\npodDisruptionBudget: {enabled: false}",
}

Manifest = dict[str, Any]


def helm(*words: str, values: str = "", chart: Path = CHART) -> subprocess.CompletedProcess[str]:
    """Run helm with a chart and values on its standard input."""
    assert HELM is not None
    command = [HELM, words[0], *words[1:], str(chart), "--values", "-"]
    return subprocess.run(command, input=values or "{}", capture_output=True, text=True, check=False)


def template(values: str, chart: Path = CHART) -> list[Manifest]:
    """Return the objects of a release."""
    done = helm("template", RELEASE, "--namespace", "robotics", values=values, chart=chart)
    assert done.returncode == 0, done.stderr
    return [found for found in yaml.safe_load_all(done.stdout) if found]


@cache
def rendered(case: str) -> tuple[Manifest, ...]:
    return tuple(template(CASES[case]))


def of_kind(case: str, *kinds: str) -> dict[str, Manifest]:
    return {found["metadata"]["name"]: found for found in rendered(case) if found["kind"] in kinds}


def workloads(case: str) -> dict[str, Manifest]:
    return of_kind(case, "StatefulSet", "DaemonSet")


def pods(case: str) -> Iterator[tuple[str, Manifest, Manifest]]:
    """Yield the name of each workload, its labels of pods, and its pods."""
    for name, found in workloads(case).items():
        yield name, found["spec"]["template"]["metadata"]["labels"], found["spec"]["template"]["spec"]


def containers(case: str) -> Iterator[Manifest]:
    for _, _, pod in pods(case):
        yield from pod["containers"]
        yield from pod["initContainers"]


every_case = pytest.mark.parametrize("case", CASES)


@every_case
def test_lint_has_nothing_to_say(case: str) -> None:
    done = helm("lint", "--strict", values=CASES[case])
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("version", [OLDEST, NEWEST])
@every_case
def test_the_objects_fit_the_schemas_of_kubernetes(case: str, version: str) -> None:
    ours = [found for found in rendered(case) if not found["apiVersion"].startswith("monitoring.coreos.com/")]
    assert {found["kind"]: fault for found in ours for fault in faults(found, version)} == {}


@pytest.mark.skipif(not are_there(), reason="no definitions: make helm")
def test_monitors_and_rules_fit_the_definitions_of_the_operator() -> None:
    found = [one for case in CASES for one in rendered(case) if one["apiVersion"].startswith("monitoring")]
    assert {one["kind"] for one in found} == {"ServiceMonitor", "PrometheusRule"}
    assert [fault for one in found for fault in custom_faults(one)] == []
    monitor = next(one for one in found if one["kind"] == "ServiceMonitor")
    [fault] = custom_faults({**monitor, "spec": {**monitor["spec"], "endpoint": []}})
    assert "endpoint" in fault
    [fault] = custom_faults({**monitor, "spec": {**monitor["spec"], "endpoints": [{"interval": "15"}]}})
    assert fault.startswith("$.spec.endpoints[0].interval")


def test_an_object_that_fits_no_schema_is_found() -> None:
    [wrong] = of_kind("one node", "StatefulSet").values()
    [fault] = faults({**wrong, "spec": {**wrong["spec"], "replica": 1}}, NEWEST)
    assert "replica" in fault


def test_the_chart_has_the_version_of_this_project() -> None:
    chart = yaml.safe_load((CHART / "Chart.yaml").read_text())
    assert chart["version"] == chart["appVersion"] == __version__


# -- pods --------------------------------------------------------------------------------------------------------------


@every_case
def test_pods_are_confined(case: str) -> None:
    for _, _, pod in pods(case):
        assert pod["automountServiceAccountToken"] is False
        assert pod["securityContext"]["runAsNonRoot"] is True
        assert pod["securityContext"]["seccompProfile"] == {"type": "RuntimeDefault"}
    for container in containers(case):
        assert container["securityContext"] == {
            "allowPrivilegeEscalation": False,
            "readOnlyRootFilesystem": True,
            "capabilities": {"drop": ["ALL"]},
        }
        assert container["resources"]["requests"] and container["resources"]["limits"]["memory"]


def test_pods_run_as_the_user_of_the_image_and_write_where_it_does() -> None:
    image = (ROOT / "docker" / "engine.Dockerfile").read_text()
    [user] = re.findall(r"--uid (\d+)", image)
    [kernels] = re.findall(r"NUMBA_CACHE_DIR=(\S+) PYTHON", image)
    for case in CASES:
        for _, _, pod in pods(case):
            assert pod["securityContext"]["runAsUser"] == pod["securityContext"]["fsGroup"] == int(user)
            [copy] = pod["initContainers"]
            assert f"{kernels}/." in copy["command"]
            [container] = pod["containers"]
            assert {"/tmp", "/dev/shm", kernels, "/var/lib/ppaas"} <= {
                m["mountPath"] for m in container["volumeMounts"]
            }


@every_case
def test_mounts_have_volumes_and_probes_have_ports(case: str) -> None:
    for name, _, pod in pods(case):
        claims = workloads(case)[name]["spec"].get("volumeClaimTemplates", [])
        volumes = {volume["name"] for volume in pod["volumes"]} | {claim["metadata"]["name"] for claim in claims}
        for container in (*pod["containers"], *pod["initContainers"]):
            assert {mount["name"] for mount in container["volumeMounts"]} <= volumes
            ports = {port["name"] for port in container.get("ports", ())}
            probes = [container[probe] for probe in container if probe.endswith("Probe")]
            assert {probe["httpGet"]["port"] for probe in probes} <= ports


def test_paths_of_probes_are_served() -> None:
    served = (ROOT / "endpoints" / "rest" / "cluster" / "health.py").read_text()
    metrics = (ROOT / "endpoints" / "metrics" / "server.py").read_text()
    paths = {
        container[probe]["httpGet"]["path"]
        for case in CASES
        for container in containers(case)
        for probe in container
        if probe.endswith("Probe")
    }
    assert paths == {"/alive", "/v1/health", "/v1/health/ready"}
    assert 'ALIVE = "/alive"' in metrics and '"/ready"' in served


# -- settings ----------------------------------------------------------------------------------------------------------


def settings(case: str) -> str:
    [found] = of_kind(case, "ConfigMap").values()
    return str(found["data"]["ppaas.toml"])


@every_case
def test_the_settings_are_those_of_the_commands(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for container in containers(case):
        for variable in container.get("env", ()):
            monkeypatch.setenv(variable["name"], "some-pod")
    (tmp_path / "ppaas.toml").write_text(settings(case))
    assert main(["config", "check", str(tmp_path / "ppaas.toml")]) == 0, capsys.readouterr()


def test_numbers_of_values_arrive_as_they_are() -> None:
    up = tomllib.loads(settings("numbered"))["up"]
    assert up["quota"] == {"stored_bytes": 10_000_000_000, "cores": 2.5}
    assert (up["linger"], up["port"], up["cores"]) == (60, 8500, 2)


@every_case
def test_files_of_settings_are_mounted_from_secrets(case: str) -> None:
    tables = tomllib.loads(settings(case))
    for name, _, pod in pods(case):
        table = tables["up" if name == f"{RELEASE}-master" else "machine"]
        secrets = {volume["name"]: volume["secret"] for volume in pod["volumes"] if "secret" in volume}
        [container] = pod["containers"]
        there = {
            f"{mount['mountPath']}/{item['path']}"
            for mount in container["volumeMounts"]
            for item in secrets.get(mount["name"], {}).get("items", ())
        }
        assert {value for key, value in table.items() if key.endswith("-file")} == there


@every_case
def test_machines_ask_the_masters_that_there_are(case: str) -> None:
    tables, master = tomllib.loads(settings(case)), workloads(case)[f"{RELEASE}-master"]
    names = [
        f"{RELEASE}-master-{number}.{master['spec']['serviceName']}.robotics.svc:8510"
        for number in range(master["spec"]["replicas"])
    ]
    assert tables["machine"]["master"] == names
    assert tables["up"].get("master", names) == names
    assert master["spec"]["serviceName"] in of_kind(case, "Service")


# -- what selects pods -------------------------------------------------------------------------------------------------


def selected(case: str, selector: dict[str, str]) -> set[str]:
    return {name for name, labels, _ in pods(case) if selector.items() <= labels.items()}


@every_case
def test_clients_reach_pods_that_serve_them(case: str) -> None:
    service = of_kind(case, "Service")[RELEASE]["spec"]
    found = selected(case, service["selector"])
    alone = workloads(case)[f"{RELEASE}-master"]["spec"]["replicas"] == 1
    machines = f"{RELEASE}-machine" in workloads(case) and case != "without endpoints of machines"
    assert found == ({f"{RELEASE}-master"} if alone else set()) | ({f"{RELEASE}-machine"} if machines else set())
    for name, _, pod in pods(case):
        [container] = pod["containers"]
        if name in found:
            assert {"name": "http", "containerPort": 8500, "protocol": "TCP"} in container["ports"]
            assert container["readinessProbe"]["httpGet"] == {"path": "/v1/health/ready", "port": "http"}


@every_case
def test_each_selector_finds_pods_of_its_own_only(case: str) -> None:
    for name, found in workloads(case).items():
        assert selected(case, found["spec"]["selector"]["matchLabels"]) == {name}
    for name, found in of_kind(case, "PodDisruptionBudget").items():
        assert selected(case, found["spec"]["selector"]["matchLabels"]) == {name}
        assert workloads(case)[name]["kind"] == "StatefulSet", "pods of a DaemonSet cannot be counted"
    for found in of_kind(case, "Service").values():
        assert selected(case, found["spec"]["selector"])
    for found in of_kind(case, "NetworkPolicy").values():
        assert selected(case, found["spec"]["podSelector"]["matchLabels"]) == set(workloads(case))
    for found in of_kind(case, "ServiceMonitor").values():
        wanted = found["spec"]["selector"]["matchLabels"]
        services = of_kind(case, "Service").values()
        [service] = [one for one in services if wanted.items() <= one["metadata"]["labels"].items()]
        ports = {port["name"] for port in service["spec"]["ports"]}
        assert {endpoint["port"] for endpoint in found["spec"]["endpoints"]} <= ports


def test_the_alerts_are_those_of_prometheus() -> None:
    [rule] = of_kind("as documented", "PrometheusRule").values()
    assert rule["spec"] == yaml.safe_load(RULES.read_text())
    assert (CHART / "files" / RULES.name).is_symlink(), "one source"


# -- upgrades ----------------------------------------------------------------------------------------------------------

FIXED = {
    "StatefulSet": ("serviceName", "podManagementPolicy", "selector", "volumeClaimTemplates"),
    "DaemonSet": ("selector",),
    "Service": ("clusterIP",),
}
"""Fields of the specification that Kubernetes keeps for ever, by kind."""


def fixed(found: list[Manifest] | tuple[Manifest, ...]) -> dict[str, Manifest]:
    """Return the fields of objects that an upgrade must not change."""
    return {
        f"{one['apiVersion']} {one['kind']} {one['metadata']['name']}": {
            field: one["spec"].get(field) for field in FIXED.get(one["kind"], ())
        }
        for one in found
    }


@every_case
def test_an_upgrade_changes_nothing_that_is_kept_for_ever(case: str, tmp_path: Path) -> None:
    newer = tmp_path / "ppaas"
    shutil.copytree(CHART, newer)
    chart = yaml.safe_load((newer / "Chart.yaml").read_text()) | {"version": "9.9.9", "appVersion": "9.9.9"}
    (newer / "Chart.yaml").write_text(yaml.safe_dump(chart))
    after = template(CASES[case], chart=newer)
    assert fixed(after) == fixed(rendered(case))
    assert after != list(rendered(case)), "the labels of the version differ"


@every_case
def test_the_objects_are_those_that_were_released(case: str) -> None:
    """A change of this file is a break for those who have installed the chart."""
    released = yaml.safe_load((ROOT / "tests" / "deploy" / "released_objects.yaml").read_text())
    assert fixed(rendered(case)) == released[case]


# -- refusals ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ("masters: {}", "masters"),
        ("master: {replicas: 3}", "replicas"),
        ("master: {replicas: '2'}", "replicas"),
        ("machines: {kind: Deployment}", "kind"),
        ("machines: {kind: DaemonSet}", "stores.urlSecret"),
        (f"{SECRETS}machines: {{kind: DaemonSet}}", "machines.joinSecret"),
        (f"{SECRETS}master: {{replicas: 2}}\nmachines: {{joinSecret: j, kind: DaemonSet}}", "master.passwordSecret"),
        (f"{SECRETS}master: {{replicas: 2, passwordSecret: p}}\nmachines: {{joinSecret: j}}", "machines.kind"),
        ("ingress: {enabled: true}", "host"),
        ("networkPolicy: {egress: anywhere}", "egress"),
    ],
)
def test_values_that_are_wrong_or_incomplete_are_refused(values: str, reason: str) -> None:
    done = helm("template", RELEASE, values=values)
    assert done.returncode != 0 and reason in done.stderr
