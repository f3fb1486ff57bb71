"""Requirements and faults beside the tests that verify them."""
