"""Poses of a run in the formats of flight dynamics and of robotics: poses reads, each other file writes one kind of files."""
