"""Loaded last in the fork server: what is in memory now is shared by all containers and never looked at again."""

import gc
import sys

from engine.runtimes import gaps, memory, preload

if preload.COMPILED.buffer:
    memory.begin_anew(preload.ENVIRONMENT)
gc.collect()
memory.give_back()
gaps.fill()
sys._clear_type_cache()  # else containers let go of cached names one by one, each on a page of its own
gc.freeze()
