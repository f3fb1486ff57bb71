"""What the program and its tools are made of (tools/sbom.py)."""
