"""Compiled kernels over grids. Each module has a ``warm`` that calls all of its kernels once."""
