"""Campaigns: many scenes, many settings, one table. README.md says how the files belong together."""
