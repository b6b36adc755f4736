import gc

import pytest

from engine.processes.imports import without_collection


@pytest.fixture(autouse=True)
def unfrozen():
    yield
    gc.unfreeze()


def test_garbage_is_not_collected_while_modules_are_imported():
    with without_collection():
        assert not gc.isenabled()
    assert gc.isenabled()
    assert gc.get_freeze_count() > 1000


def test_garbage_is_collected_again_after_a_failed_import():
    with pytest.raises(ModuleNotFoundError), without_collection():
        __import__("no_such_module")
    assert gc.isenabled()
