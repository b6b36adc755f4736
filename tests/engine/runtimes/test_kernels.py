from engine.runtimes.kernels import modules, warm_all


def dispatchers(module):
    return [found for found in vars(module).values() if hasattr(found, "signatures") and hasattr(found, "py_func")]


def test_the_kernels_of_all_rooms_are_found():
    rooms = {module.__name__.split(".")[1] for module in modules()}
    assert {"maps", "costmap", "planners", "controllers", "localization"} <= rooms


def test_each_module_that_can_be_warmed_is_and_leaves_compiled_code():
    warmed = warm_all()
    assert len(warmed) > 5
    for module in warmed:
        assert any(kernel.signatures for kernel in dispatchers(module)), module.__name__
