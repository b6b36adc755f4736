"""The code follows the project's rules."""

import pytest

from tests.support import rules
from tests.support.sources import ALL_PACKAGES, sources


@pytest.mark.parametrize("rule", [rules.io_imports, rules.io_calls])
def test_the_domain_does_no_io(rule):
    assert [fault for source in sources("ppaas") for fault in rule(source)] == []


@pytest.mark.parametrize(
    "rule",
    [
        rules.long_file,
        rules.long_functions,
        rules.private_imports,
        rules.swallowed_errors,
        rules.working_assertions,
        rules.typed_decodes,
    ],
)
def test_all_code_follows_the_rule(rule):
    assert [fault for source in sources(*ALL_PACKAGES) for fault in rule(source)] == []
