"""Loaded last in the fork server: what is in memory now is shared by all containers and never looked at again."""

import gc

from engine.container.warm_up import preload, restart
from engine.runtimes.memory_tuning import allocator, heap_fill

if preload.COMPILED.buffer:
    restart.restart_once(preload.ENVIRONMENT)
gc.collect()
allocator.trim()
heap_fill.fill()
gc.freeze()
