"""Master: decides where containers run, what users may have and what happens after a failure. It does no I/O."""
