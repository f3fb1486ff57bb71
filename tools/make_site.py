#!/usr/bin/env -S python3 -Es -X utf8
"""Makes the site: guides, decisions, interfaces, requirements, known limits and the API, by Sphinx, Doxygen and Breathe."""

from polhode_ground.website.make_site import command

if __name__ == "__main__":
    command()
