"""The project's documents as one site."""
