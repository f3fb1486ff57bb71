"""Checks of the program, its builds and its packages."""
