"""Bad frames made on purpose, and what a replay made of them."""
