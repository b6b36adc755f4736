"""Tables of what becomes of the parameters of other programs, for the pages that list them."""

from docs.site.reference.markdown import code, table
from ppaas.imports.parameters.nav2.servers import CONTROLLER
from ppaas.imports.parameters.rules import ParameterRule, ParameterRules

COLUMNS = ("parameter", "outcome", "becomes, or why not")

OF_CONTROLLER = f"parameters.{CONTROLLER}."


def rule_table(rules: ParameterRules) -> str:
    """Return a table of rules: a row for each parameter that has a place, and one for each reason without effect."""
    rows = [_row(name, rule) for name, rule in rules.items() if rule.to]
    reasons: dict[str, list[str]] = {}
    for name, rule in rules.items():
        if not rule.to:
            reasons.setdefault(rule.text, []).append(name)
    rows += [(", ".join(map(code, names)), "no effect", reason) for reason, names in reasons.items()]
    return table(COLUMNS, rows)


def _row(name: str, rule: ParameterRule) -> tuple[str, str, str]:
    place = rule.to.replace(OF_CONTROLLER, "parameters.LOCAL_PLANNER.")
    same = name.rpartition(".")[2] == rule.to.rpartition(".")[2] and not rule.text
    words = code(place) + (f": {rule.text}" if rule.text else "")
    return code(name), "taken" if same else "translated", words
