"""Numbers and names in quotas.md are those of the code, and its commands work."""

import json
import re
from pathlib import Path

import pytest

from engine.control.planning_places import PATIENCE
from engine.master.queueing import MAX_QUEUED, MAX_QUEUED_OF_USER
from engine.master.quotas import QUOTAS, Quota
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import run_shell, script, table, text_of

PAGE = "docs/quotas.md"


def test_the_table_lists_every_quota_with_its_default() -> None:
    listed = {name.strip("`"): float(number) for name, number, _ in table(PAGE, "quota", "every user", "what counts")}
    assert listed == {name: float(getattr(Quota(), name)) for name in QUOTAS}


def test_the_numbers_of_the_queue_are_those_of_the_code() -> None:
    text = re.sub(r"\s+", " ", text_of(PAGE))
    assert f"The queue holds {MAX_QUEUED}, and {MAX_QUEUED_OF_USER} of one user" in text
    assert f"does not ask again for {PATIENCE:g} s" in text


@pytest.mark.journey
def test_the_shell_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    (tmp_path / "password").write_text("correct horse\n")
    make = "ppaas user create ann --password-file password"
    answers = run_shell(f"{login}\n{make}\n{script(PAGE)}", tmp_path, cloud)
    limited = json.loads(answers[answers.rindex('{"id":"ann"') :])
    assert (limited["limits"]["containers"], limited["quota"]["cores"]) == (None, 2.5)
