"""Pictures of a replay's outputs. Each module draws one subject: draw(run, ..., folder) -> paths of the PNGs."""
