"""Made-up sequences and runs, for tests."""
