"""The page of Nav2's parameters has all names that are known, with what becomes of them."""

from docs.site.reference.nav2_parameters import page
from ppaas.imports.parameters.nav2.catalogue import NODES

PAGE = page()


def test_each_name_of_each_table_is_on_the_page() -> None:
    for node in NODES:
        section = PAGE.partition(f"\n## `{node.node}`\n")[2].partition("\n## ")[0]
        names = [*node.rules]
        for group in node.groups:
            for plugin in group.tables:
                assert f"### `{plugin.plugin}`" in section
                names += [*plugin.rules, *plugin.sources]
            names += [] if group.untyped is None else [*group.untyped.rules]
        assert [name for name in names if f"`{name}`" not in section] == []


def test_outcomes_are_those_of_the_report() -> None:
    assert "| `alpha1` | translated | `parameters.amcl.odom_alpha1` |" in PAGE
    assert "| `max_particles` | taken | `parameters.amcl.max_particles` |" in PAGE
    assert "| `xy_goal_tolerance` | taken | `parameters.LOCAL_PLANNER.xy_goal_tolerance` |" in PAGE
    assert "### `dwb_core::DWBLocalPlanner`, which becomes `dwa`" in PAGE
    assert "| `do_beamskip`, `beam_skip_distance`," in PAGE
