"""Findings as ``diagnostic_msgs/DiagnosticStatus``, as ROS's tools show them."""

from ppaas.diagnosis.rules.finding import LEVELS, Finding
from ppaas.messages.health.diagnostic_msgs import DiagnosticStatus, KeyValue

OWN = "ppaas: "
"""Prefix of the names of the statuses of the cloud, which tells them from those of the robot's programs."""


def statuses_of(findings: list[Finding]) -> list[DiagnosticStatus]:
    """Return the status of each finding; one that says that all is well if there is none."""
    if not findings:
        return [DiagnosticStatus(0, f"{OWN}robot", "Everything that the cloud checks is in order.")]
    return [
        DiagnosticStatus(LEVELS.index(each.level), f"{OWN}{each.kind}", each.text, values=_values(each))
        for each in findings
    ]


def _values(finding: Finding) -> list[KeyValue]:
    named = {"advice": finding.advice, "topic": finding.topic}
    return [KeyValue(key, value) for key, value in named.items() if value]
