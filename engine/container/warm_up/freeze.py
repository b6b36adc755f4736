"""Freezes the fork server's memory; loaded last. Garbage collection in containers never touches these objects."""

import gc

from engine.container.warm_up import preload, restart
from engine.runtimes.memory_tuning import process_memory

if preload.COMPILED.buffer:
    restart.restart_once(preload.ENVIRONMENT)
gc.collect()
process_memory.trim()
process_memory.fill()
gc.freeze()
gc.enable()
