"""Files of figures are checked before anything is computed for them."""

import sys
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from robots.pictures.figure_file import check_figure


def test_only_png_files_are_written() -> None:
    check_figure(Path("chart.PNG"))
    with pytest.raises(InvalidInput, match="PNG"):
        check_figure(Path("chart.pdf"))


def test_a_missing_matplotlib_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "matplotlib.figure", raising=False)
    with pytest.raises(ModuleNotFoundError) as missing:
        check_figure(Path("chart.png"))
    assert (missing.value.name or "").partition(".")[0] == "matplotlib"
