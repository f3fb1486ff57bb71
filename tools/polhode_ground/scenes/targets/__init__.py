"""The targets that can be rendered. Each module builds a list of mesh parts in the geometric frame G."""
