import sys
from pathlib import Path

import pytest

from engine.runtimes.memory_tuning import lean_python


def test_python_runs_without_docstrings() -> None:
    assert (sys.executable, "-OO") == lean_python.PYTHON


def test_modules_are_compiled_into_our_own_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    given = {"PYTHONDONTWRITEBYTECODE": "1", "PATH": "/bin"}
    assert lean_python.environment(given) == {"PATH": "/bin", "PYTHONPYCACHEPREFIX": str(tmp_path / "modules")}


def test_a_folder_in_the_environment_is_kept() -> None:
    assert lean_python.environment({"PYTHONPYCACHEPREFIX": "/elsewhere"}) == {"PYTHONPYCACHEPREFIX": "/elsewhere"}
