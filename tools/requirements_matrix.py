#!/usr/bin/env -S python3 -Es -X utf8
"""Requirements beside the tests that verify them: docs/requirements/*.toml and the tags `verifies: ID` above tests."""

from polhode_ground.verification.requirements_matrix import command

if __name__ == "__main__":
    command()
