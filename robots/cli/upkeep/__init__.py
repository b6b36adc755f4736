"""Commands of those who run a cloud: webhooks, and for how long data are kept."""
