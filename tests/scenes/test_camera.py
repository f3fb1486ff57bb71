"""Projection, distortion and resampling."""

import numpy as np
import pytest
from polhode_ground.scenes import camera as cam

LENS = (-0.21, 0.06, 0.0008, -0.0011)


def test_undistort_inverts_distort():
    xy = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 21), np.linspace(-0.4, 0.4, 17)), axis=-1)
    assert np.abs(cam.undistort(cam.distort(xy, LENS), LENS) - xy).max() < 1e-10


def test_the_model_is_the_radial_tangential_one():
    x, y = 0.3, -0.2
    r2 = x * x + y * y
    radial = 1 + LENS[0] * r2 + LENS[1] * r2**2
    expected = [
        x * radial + 2 * LENS[2] * x * y + LENS[3] * (r2 + 2 * x * x),
        y * radial + LENS[2] * (r2 + 2 * y * y) + 2 * LENS[3] * x * y,
    ]
    assert np.allclose(cam.distort(np.array([x, y]), LENS), expected)


def _smooth(u, v):
    return np.sin(u / 9.0) + np.cos(v / 7.0)


def test_resampling_moves_the_picture_as_the_model_says():
    camera = cam.Camera(160, 120, 140.0, 143.0, 80.3, 58.9, LENS)
    resampler = cam.Resampler(camera)
    x0, y0, width, height = resampler.full_window()
    u, v = np.meshgrid(np.arange(x0, x0 + width), np.arange(y0, y0 + height))
    picture = _smooth(u, v)[..., None].astype(np.float32)
    out = resampler.to_camera(picture, (x0, y0, width, height))[..., 0]
    uu, vv = np.meshgrid(np.arange(160.0), np.arange(120.0))
    ideal = cam.pixel_rays(camera, uu, vv) * resampler.f_ideal + [camera.cu, camera.cv]
    # Catmull-Rom is third order: for waves of 44 px its error stays below 1e-3.
    assert np.abs(out - _smooth(ideal[..., 0], ideal[..., 1])).max() < 2e-3


def test_a_plain_camera_is_not_resampled():
    resampler = cam.Resampler(cam.Camera(64, 48, 60.0, 60.0, 31.5, 23.5))
    window = np.ones((10, 12, 4), dtype=np.float32)
    out = resampler.to_camera(window, (5, 7, 12, 10))
    assert out.sum() == window.sum() and out[7, 5, 0] == 1 and out[6, 5, 0] == 0


def test_the_target_window_holds_the_target_and_stays_in_the_image():
    resampler = cam.Resampler(cam.Camera(64, 48, 60.0, 60.0, 31.5, 23.5))
    p_C = np.array([[-0.1, -0.1, 2.0], [0.1, 0.1, 2.0]])
    x0, y0, width, height = resampler.target_window(p_C)
    assert x0 <= 28.5 - 4 and x0 + width >= 34.5 + 4 and y0 <= 20.5 - 4 and y0 + height >= 26.5 + 4
    assert resampler.target_window(p_C + [50.0, 0, 0]) is None
    assert resampler.target_window(p_C * [400, 400, 1]) == (0, 0, 64, 48)


@pytest.mark.parametrize("distortion, fine", [(LENS, True), ((-0.9, 0.0, 0.0, 0.0), False)])
def test_distortion_that_folds_over_is_noticed(distortion, fine):
    camera = cam.Camera(640, 480, 400.0, 400.0, 319.5, 239.5, distortion)
    assert cam.scene_margin_is_invertible(camera) is fine


def test_shared_samples_keep_the_light_and_spread_it_as_blenders_filter_does():
    spot = np.zeros((9, 11, 4), dtype=np.float32)
    spot[4, 5] = 3.0
    out = cam.share_samples(spot)
    assert out.shape == spot.shape and out.dtype == np.float32
    assert out[..., 0].sum() == pytest.approx(3.0, rel=1e-6)
    assert np.argwhere(out[..., 0] > 0).min(axis=0).tolist() == [3, 4]
    # A pixel's own square and the spread together: the variance of a Blackman-Harris window 3 px wide.
    x = np.linspace(-1.5, 1.5, 3001)
    phase = 2 * np.pi * (x / 3 + 0.5)
    window = 0.35875 - 0.48829 * np.cos(phase) + 0.14128 * np.cos(2 * phase) - 0.01168 * np.cos(3 * phase)
    for axis, weights in enumerate((out[:, 5, 0] / out[:, 5, 0].sum(), out[4, :, 0] / out[4, :, 0].sum())):
        offsets = np.arange(len(weights)) - (4, 5)[axis]
        variance_px2 = 1 / 12 + np.sum(weights * offsets**2)
        assert variance_px2 == pytest.approx(np.sum(window * x**2) / np.sum(window), rel=0.07)


def test_shared_samples_leave_an_even_picture_as_it_is_to_its_edges():
    even = np.full((5, 4, 3), 0.7, dtype=np.float32)
    assert np.allclose(cam.share_samples(even), 0.7, rtol=1e-6)
