"""Freezes the fork server's memory; loaded last. Garbage collection in containers never touches these objects."""

import gc

from engine.container.warm_up import preload, restart
from engine.runtimes.memory_tuning import allocator, heap_fill

if preload.COMPILED.buffer:
    restart.restart_once(preload.ENVIRONMENT)
gc.collect()
allocator.trim()
heap_fill.fill()
gc.freeze()
gc.enable()
