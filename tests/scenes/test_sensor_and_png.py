"""Noise, response curve and the file format."""

import numpy as np
import pytest
from polhode_ground.scenes import png
from polhode_ground.scenes.sensor import Sensor, expose, response


def test_a_frame_depends_only_on_seed_and_index():
    radiance = np.full((20, 30, 3), 0.3, dtype=np.float32)
    first = expose(radiance, Sensor(), 5, 7)
    expose(radiance, Sensor(), 5, 8)
    assert np.array_equal(first, expose(radiance, Sensor(), 5, 7))
    assert not np.array_equal(first, expose(radiance, Sensor(), 5, 8))
    assert not np.array_equal(first, expose(radiance, Sensor(), 6, 7))


def test_shot_noise_has_the_deviation_of_its_electrons():
    sensor = Sensor(exposure=1.0, full_well_e=20000, read_noise_e=10, gamma=1.0, bits=16)
    image = expose(np.full((300, 300, 3), 0.25, dtype=np.float32), sensor, 1, 0).astype(float) / 65535 * 20000
    # 90000 samples: the deviation of the measured deviation is 0.24 %.
    assert abs(image.mean() - 5000) < 1.5
    assert abs(image.std() / np.sqrt(5000 + 100) - 1) < 0.012


def test_response_rises_steadily_from_black_to_white():
    x = np.linspace(0, 1, 4001)
    y = response(x, 2.2)
    assert y[0] == 0 and abs(y[-1] - 1) < 1e-6 and np.all(np.diff(y) > 0)


@pytest.mark.parametrize("shape, kind", [((37, 51), np.uint8), ((37, 51), np.uint16), ((20, 31, 3), np.uint8)])
def test_png_gives_back_what_was_written(shape, kind):
    image = np.random.default_rng(1).integers(0, np.iinfo(kind).max, shape).astype(kind)
    image[5:20] = 9
    assert np.array_equal(png.decode(png.encode(image)), image)


def test_png_is_read_by_others():
    image_module = pytest.importorskip("PIL.Image")
    import io

    image = (np.arange(48 * 64).reshape(48, 64) % 251).astype(np.uint8)
    assert np.array_equal(np.asarray(image_module.open(io.BytesIO(png.encode(image)))), image)


def test_colour_and_depth_come_out_as_asked():
    radiance = np.zeros((8, 9, 3), dtype=np.float32)
    radiance[..., 0] = 0.4
    rgb = expose(radiance, Sensor(color="rgb"), 1, 0)
    assert rgb.shape == (8, 9, 3) and rgb.dtype == np.uint8 and rgb[..., 0].mean() > 100 > 20 > rgb[..., 2].mean()
    assert expose(radiance, Sensor(bits=16), 1, 0).dtype == np.uint16
