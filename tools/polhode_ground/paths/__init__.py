"""Random flights past boxes with texture: whole sequences for the search for inputs that end a run, drawn without Blender."""
