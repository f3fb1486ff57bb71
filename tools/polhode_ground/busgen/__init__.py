"""From the bus's one field table to all that must agree with it."""
