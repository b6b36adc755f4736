"""Loaded last in the fork server: what is in memory now is shared by all containers and never looked at again."""

import gc

from engine.runtimes import gaps, memory, preload

if preload.COMPILED.buffer:
    memory.begin_anew(preload.ENVIRONMENT)
gc.collect()
memory.give_back()
gaps.fill()
gc.freeze()
