"""Options, alerts and numbers in metrics.md are those of the code."""

import re
import subprocess
import sys

import yaml

from benchmarks.alerts.faults import BESIDE, LAST
from endpoints.metrics import collector, families
from endpoints.metrics.snapshot import GONE
from engine.control.master_calls.cloud import SILENT
from tests.support.documents import blocks, table, text_of
from tests.support.sources import ROOT

PAGE = "docs/metrics.md"


def test_the_commands_have_options_that_exist() -> None:
    named = set(re.findall(r"--\w[\w-]*", text_of(PAGE)))
    shown = ""
    for words in (["up"], ["bench", "alerts"], ["bench", "service"]):
        command = [sys.executable, "-m", "robots.cli", *words, "--help"]
        shown += subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert named and named <= set(re.findall(r"--\w[\w-]*", shown))


def test_the_log_of_alerts_has_what_the_bench_breaks() -> None:
    [shown] = blocks(PAGE, "text")
    logged = [re.split(r" {2,}", line) for line in shown.splitlines()[1:]]
    assert [(alert, broken, mended) for alert, broken, _, mended, _ in logged] == [
        (fault.alert, fault.broken, fault.mended) for fault in BESIDE + LAST
    ]
    rules = yaml.safe_load((ROOT / "deploy" / "prometheus" / "ppaas.rules.yaml").read_text())
    assert {alert for alert, *_ in logged} <= {rule["alert"] for group in rules["groups"] for rule in group["rules"]}


def test_the_alerts_are_those_of_the_rules() -> None:
    rules = yaml.safe_load((ROOT / "deploy" / "prometheus" / "ppaas.rules.yaml").read_text())
    shipped = [(rule["alert"], rule["labels"]["severity"]) for group in rules["groups"] for rule in group["rules"]]
    assert [(alert, severity) for alert, severity, _ in table(PAGE, "alert", "severity", "when")] == shipped


def test_the_configuration_of_prometheus_names_the_rules_and_the_port_of_the_command() -> None:
    [code] = blocks(PAGE, "yaml")
    read = yaml.safe_load(code)
    [scraped] = read["scrape_configs"]
    [port] = set(re.findall(r"--metrics (\d+)", text_of(PAGE)))
    assert read["rule_files"] == ["ppaas.rules.yaml"]
    assert scraped["static_configs"] == [{"targets": [f"127.0.0.1:{port}"]}]


def test_numbers_are_those_of_the_code() -> None:
    page = " ".join(text_of(PAGE).split())
    assert f"does not answer within {collector.PATIENCE:g} s" in page
    assert f"disconnected within {GONE / 60:g} minutes" in page
    assert f"have not reported for {SILENT:g} s" in page
    assert f"a charge below {100 * collector.LOW_BATTERY:g} %" in page
    assert f"at most {families.MOST_SERIES} series" in page and families.OTHER in page
    assert f"histograms are of {families.MOST_HISTOGRAMS} endpoints" in page
    assert f"cut after {families.LONGEST_LABEL} characters" in page
