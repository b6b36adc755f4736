import gc

import pytest

from engine.processes.imports import YOUNG_OBJECTS, without_collection


@pytest.fixture(autouse=True)
def unchanged():
    thresholds = gc.get_threshold()
    yield
    gc.unfreeze()
    gc.set_threshold(*thresholds)


def test_garbage_is_not_collected_while_modules_are_imported():
    with without_collection():
        assert not gc.isenabled()
    assert gc.isenabled()
    assert gc.get_freeze_count() > 1000
    assert gc.get_threshold()[0] == YOUNG_OBJECTS


def test_garbage_is_collected_again_after_a_failed_import():
    with pytest.raises(ModuleNotFoundError), without_collection():
        __import__("no_such_module")
    assert gc.isenabled()
