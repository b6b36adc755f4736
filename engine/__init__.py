"""Engine: a master that places containers on machines, and the clones inside these containers."""
