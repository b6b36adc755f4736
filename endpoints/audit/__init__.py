"""Audit log: who did what to what, from where, when and with what outcome."""
