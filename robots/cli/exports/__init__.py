"""Commands that write what the cloud has as files of other programs."""
