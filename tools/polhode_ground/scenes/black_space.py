"""Nothing behind the target, which is what every background begins from."""


class Empty:
    """Black space."""

    own_light = False

    def prepare(self, motion, row):
        """Called before the target is rendered at a row of the motion."""

    def radiance(self, motion, row):
        """None: nothing is added. Called after the target was rendered at that row."""
        del motion, row
        return
