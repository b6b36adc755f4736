"""Names of settings: which are known, and what a misspelt one may stand for."""

import difflib
import re
from collections.abc import Collection, Iterable, Iterator, Mapping

from endpoints.settings.setting import CONFIG, PREFIX, Setting

CONFIG_VARIABLE = f"{PREFIX}{CONFIG.upper()}"
"""Variable with the path of the file of settings."""

OTHERS: Mapping[str, str] = {
    "PPAAS_URL": "commands of robots and operators: URL of the cloud",
    "PPAAS_TOKEN": "commands of robots and operators: token",
    "PPAAS_MQTT_PASSWORD": "ppaas bridge vda5050, devices of mqtt: password at the broker",
    "PPAAS_OPTIONS": "units of systemd: options of the command",
    "PPAAS_BACKUPS": "unit of the backup: place and options",
    "PPAAS_LEAN": "processes of a cloud: 0 turns memory tuning off",
    "PPAAS_BEGUN_ANEW": "containers: set by a process that starts again",
    "PPAAS_ADDRESS": "Docker Compose: address of the published port",
    "PPAAS_PROXIES": "Docker Compose: options of proxies",
    "PPAAS_SHARED_MEMORY": "Docker Compose: size of the shared memory",
    "PPAAS_ROBOTS": "Docker Compose: robots of the demo",
    "PPAAS_GOALS": "Docker Compose: goals of each robot of the demo",
    "PPAAS_ALERTMANAGER": "Docker Compose: configuration of Alertmanager",
    "PPAAS_ALERTMANAGER_IMAGE": "Docker Compose: image of Alertmanager",
    "PPAAS_GRAFANA_IMAGE": "Docker Compose: image of Grafana",
    "PPAAS_PROMETHEUS_IMAGE": "Docker Compose: image of Prometheus",
    "PPAAS_PROXY_IMAGE": "Docker Compose: image of the proxy",
    "PPAAS_CASSANDRA_IMAGE": "Docker Compose: image of Cassandra",
    "PPAAS_HADOOP_IMAGE": "Docker Compose: image of Hadoop",
    "PPAAS_HDFS_IMAGE": "Docker Compose: image of HDFS",
    "PPAAS_DATA": "tests and benches: folder of real data",
    "PPAAS_CHROMIUM": "tests and benches: browser",
    "PPAAS_NICENESS": "tests: niceness of processes",
    "PPAAS_DOCKER_UP": "tests: command that brings up a Docker Engine",
    "PPAAS_JOINT_SECONDS": "tests: duration of joints",
    "PPAAS_FUZZ_EXAMPLES": "tests: number of examples",
    "PPAAS_PROPERTY_EXAMPLES": "tests: number of examples",
    "PPAAS_SCHEMATHESIS_EXAMPLES": "tests: number of examples",
}
"""Variables that are no settings, with what reads them."""

_LINK = re.compile(rf"{PREFIX}(\w+_)?(SERVICE_(HOST|PORT(_\w+)?)|PORT_\d+_(TCP|UDP|SCTP)(_(PROTO|PORT|ADDR))?)")
"""Variables that Kubernetes sets in each pod for a service whose name begins with ``ppaas``."""

_ADDRESS = re.compile(r"(tcp|udp|sctp)://")
"""Beginning of the value of ``…_PORT`` of a service of Kubernetes."""


def own_variables(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the variables of this project; empty ones, and those that Kubernetes sets for services, are left out."""
    return {
        name: value
        for name, value in environment.items()
        if name.upper().startswith(PREFIX)
        and value
        and not _LINK.fullmatch(name)
        and not (name.endswith("_PORT") and _ADDRESS.match(value))
    }


def unknown_variables(variables: Iterable[str], settings: Collection[Setting]) -> Iterator[str]:
    """Yield a sentence for each variable that nothing of this project reads."""
    known = {setting.variable for setting in settings} | OTHERS.keys() | {CONFIG_VARIABLE}
    for name in sorted(set(variables) - known):
        yield f"the variable {name} is unknown{did_you_mean(name.upper(), known)}"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a question for the nearest of the known names; empty if none is near."""
    near = difflib.get_close_matches(name, sorted(known), n=1)
    return f": did you mean {near[0]}?" if near else ""
