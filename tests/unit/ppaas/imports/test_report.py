"""Report of an import: entries, counts, summary."""

from ppaas.imports.report import ImportOutcome, ImportReport, ReportEntry


def test_a_report_counts_its_entries_by_outcome() -> None:
    report = ImportReport("nav2.yaml")
    report.taken("amcl.max_particles", line=3)
    report.translated("amcl.robot_model_type", "odom_model_type")
    report.without_effect("amcl.tf_broadcast", "the clone always publishes tf")
    report.refused("amcl.max_particle", "unknown; meant: max_particles")
    report.taken("amcl.min_particles")
    assert report.counts() == {"taken": 2, "translated": 1, "no effect": 1, "refused": 1}
    assert report.summary() == "nav2.yaml: 2 taken, 1 translated, 1 no effect, 1 refused"
    assert [entry.part for entry in report.of(ImportOutcome.TAKEN)] == ["amcl.max_particles", "amcl.min_particles"]


def test_withdrawn_entries_keep_their_line() -> None:
    report = ImportReport("f.yaml")
    report.taken("a.b", line=3, to="parameters.amcl.b")
    report.taken("a.bc", line=4, to="parameters.amcl.bc")
    report.withdraw("parameters.amcl.b", ImportOutcome.REFUSED, "no")
    assert report.entries == [
        ReportEntry("a.b", ImportOutcome.REFUSED, "no", 3),
        ReportEntry("a.bc", ImportOutcome.TAKEN, "", 4, "parameters.amcl.bc"),
    ]
