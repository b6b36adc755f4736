"""Command `ppaas task`: missions of tasks, run and rehearsed."""
