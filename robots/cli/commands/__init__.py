"""Commands of ``ppaas`` for users and robots; each module has the name of its command."""
