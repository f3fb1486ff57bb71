"""Scene generator: renders sequences of a tumbling target with truth. See ../README.md."""
