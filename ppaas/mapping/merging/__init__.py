"""Merging: two mappings of one place, made without a common start, become one."""
