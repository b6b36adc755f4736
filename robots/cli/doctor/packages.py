"""Packages of this computer in the diagnosis: those that PPaaS was not tried with."""

from importlib.util import find_spec
from typing import Any

import msgspec

from ppaas.diagnosis.rules.finding import error
from ppaas.distribution import BASE, misfits, pip_command

OF_A_CLOUD = ("uvicorn", "zenoh", "argon2")
"""Modules that are installed together only where a cloud may be started."""


def with_packages(report: dict[str, Any]) -> dict[str, Any]:
    """Return a diagnosis with a finding about the packages of this computer, if some do not fit."""
    unfit = misfits(BASE, "cloud") if all(map(find_spec, OF_A_CLOUD)) else misfits(BASE)
    if not unfit:
        return report
    text = f"Packages on this computer are of versions that ppaas does not work with: {', '.join(map(str, unfit))}."
    finding = msgspec.to_builtins(error("packages-unfit", text, f"Run: {pip_command(unfit)}"))
    return report | {"level": "error", "findings": [finding, *report["findings"]]}
