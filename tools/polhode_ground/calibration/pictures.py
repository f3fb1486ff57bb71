"""The residuals of a calibration, to be looked at: structure in them means that something is wrong."""

import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy

from .solve import Calibration, view_rms_px


def draw(calibration: Calibration, file: pathlib.Path) -> None:
    from polhode_ground.common.whole_file import MARK

    points = numpy.concatenate([view.image_px for view in calibration.views])
    residuals = numpy.concatenate(calibration.residuals_px)
    figure, ((field, cloud), (bars, radial)) = plt.subplots(2, 2, figsize=(13, 10), layout="constrained")

    arrows = field.quiver(
        points[:, 0], points[:, 1], residuals[:, 0], residuals[:, 1], numpy.hypot(*residuals.T), angles="xy", cmap="viridis", width=0.002
    )
    figure.colorbar(arrows, ax=field, label="residual [px]")
    field.set(
        xlim=(0, calibration.width_px),
        ylim=(calibration.height_px, 0),
        aspect="equal",
        xlabel="u [px]",
        ylabel="v [px]",
        title=f"where corners were seen, and by how much they are off; {100 * calibration.covered():.0f} % covered",
    )

    limit = max(1.1 * numpy.abs(residuals).max(), 1e-3)
    cloud.scatter(residuals[:, 0], residuals[:, 1], s=4, alpha=0.5)
    cloud.set(
        xlim=(-limit, limit),
        ylim=(-limit, limit),
        aspect="equal",
        xlabel="du [px]",
        ylabel="dv [px]",
        title=f"all residuals, RMS {calibration.rms_px:.3f} px",
    )
    cloud.grid(alpha=0.3)

    names = [pathlib.Path(view.name).name for view in calibration.views]
    bars.bar(range(len(names)), [view_rms_px(r) for r in calibration.residuals_px])
    bars.set_xticks(range(len(names)), names, rotation=70, fontsize=7)
    bars.set(ylabel="RMS [px]", title=f"per picture; left out: {', '.join(calibration.left_out) or 'none'}")

    centre = calibration.intrinsics[2:]
    outward = points - centre
    radius = numpy.linalg.norm(outward, axis=1)
    along = numpy.sum(residuals * outward, axis=1) / numpy.maximum(radius, 1e-9)
    radial.scatter(radius, along, s=4, alpha=0.5)
    radial.axhline(0.0, color="black", linewidth=0.8)
    radial.set(
        xlabel="distance from the principal point [px]",
        ylabel="residual outward [px]",
        title="a bend here means that the distortion model does not fit",
    )
    radial.grid(alpha=0.3)
    figure.savefig(file, dpi=100, metadata={"Software": MARK})
    plt.close(figure)
