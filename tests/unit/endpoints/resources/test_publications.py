"""Progress of the publications of maps."""

from pathlib import Path

import pytest

from endpoints.resources.publications import ProgressFile, PublicationProgress, Publications, Stage
from ppaas.errors import Unavailable


def test_a_publication_is_registered_until_its_end() -> None:
    publications = Publications()
    assert publications.progress("ann", "tb1") is None
    with publications.begin("ann", "tb1") as publication:
        assert publications.progress("ann", "tb1") == PublicationProgress(Stage.TRANSFER)
        publication.stage = Stage.WAITING
        assert publications.progress("ann", "tb1") == PublicationProgress(Stage.WAITING)
        assert publications.progress("bob", "tb1") is None
    assert publications.progress("ann", "tb1") is None


def test_the_last_publication_of_a_robot_counts() -> None:
    publications = Publications()
    first, second = publications.begin("ann", "tb1"), publications.begin("ann", "tb1")
    first.__enter__().stage = Stage.STORING
    second.__enter__()
    assert publications.progress("ann", "tb1") == PublicationProgress(Stage.TRANSFER)
    first.__exit__(None, None, None)
    assert publications.progress("ann", "tb1") == PublicationProgress(Stage.TRANSFER)
    second.__exit__(None, None, None)
    assert publications.progress("ann", "tb1") is None


def test_a_program_reports_by_a_file(tmp_path: Path) -> None:
    publications, file = Publications(), ProgressFile(tmp_path)
    with publications.begin("ann", "tb1") as publication:
        publication.stage, publication.file = Stage.WAITING, ProgressFile(tmp_path)
        assert publications.progress("ann", "tb1") == PublicationProgress(Stage.WAITING)
        file.write(Stage.LOOPS, 0.25)
        assert publications.progress("ann", "tb1") == PublicationProgress(Stage.LOOPS, 0.25)
        publication.stage, publication.file = Stage.STORING, None
        assert publications.progress("ann", "tb1") == PublicationProgress(Stage.STORING)


def test_a_folder_that_has_gone_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(Unavailable):
        ProgressFile(tmp_path / "gone").write(Stage.DRAWING)
