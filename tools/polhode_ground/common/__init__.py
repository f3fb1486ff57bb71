"""What all others use: the environment of a command, errors, files, sequences, tables."""
