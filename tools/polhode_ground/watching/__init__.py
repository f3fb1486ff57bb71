"""The page of a live run (tools/watch.py): packets become plain data, and that a page; nothing goes back to the run."""
