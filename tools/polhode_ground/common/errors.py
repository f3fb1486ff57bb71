"""The one exception that means: the user's input is unusable. Its text is one line naming file and field."""


class BadInput(Exception):
    """Raised where a file or argument can't be used; scripts print it and exit with status 2."""
