"""Exports: what the cloud has, as files of other programs, with a report of what could not be expressed."""
