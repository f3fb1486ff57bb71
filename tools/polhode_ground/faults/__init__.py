"""Bits flipped in the memory of a running program, and what comes of it."""
