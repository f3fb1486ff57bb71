"""Rendered sequences changed on purpose, each with its truth kept right. README.md says what there is."""
