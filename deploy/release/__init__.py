"""Steps of a release: they check its tag, and build, compare and publish its files (docs/releasing.md)."""
