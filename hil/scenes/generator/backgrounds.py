"""What is behind the target: nothing, stars, the Earth, or a laboratory. Linear radiance in camera pixels."""


class Empty:
    """Black space."""

    own_light = False

    def radiance(self, motion, row):
        """None, or linear RGB (H, W, 3) at a row of the motion."""
        del motion, row
        return None


def make(plan, resampler, blender, scratch_path):
    """The background that the scene asks for."""
    del plan, resampler, blender, scratch_path
    return Empty()
