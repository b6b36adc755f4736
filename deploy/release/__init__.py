"""What a release consists of: how it is checked, built, compared and published (docs/releasing.md)."""
