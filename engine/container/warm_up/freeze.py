"""Loaded last in the fork server: what is in memory now is shared by all containers and never looked at again."""

import gc
import sys

from engine.container.warm_up import preload
from engine.runtimes.memory_tuning import allocator, heap_fill

if preload.COMPILED.buffer:
    allocator.begin_anew(preload.ENVIRONMENT)
gc.collect()
allocator.give_back()
heap_fill.fill()
sys._clear_type_cache()  # else containers let go of cached names one by one, each on a page of its own
gc.freeze()
