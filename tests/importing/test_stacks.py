"""Stacks of pages, as microscopes' programs write them: the time between frames, and pages that are of one moment."""

import numpy as np
import pytest
from PIL import Image
from polhode_ground.common.errors import BadInput
from polhode_ground.importing.recognise import open_source
from polhode_ground.importing.source import Options

ROWS = np.add.outer(np.arange(48), np.arange(64))


def stack(path, count, text):
    """The first level of each page is its number."""
    pages = [Image.fromarray(np.uint8((ROWS + i) % 251)) for i in range(count)]
    pages[0].save(path, save_all=True, append_images=pages[1:], tiffinfo={270: text})
    return path


OME_TEXT = '<OME><Image><Pixels DimensionOrder="XYZCT" SizeT="{frames}" SizeZ="1" TimeIncrement="250" TimeIncrementUnit="ms"/></Image></OME>'


# verifies: GND-03
@pytest.mark.parametrize(("text", "step_s", "says"), [
    ("ImageJ=1.54\nimages=4\nframes=4\nfinterval=0.25\n", 0.25, "as ImageJ's finterval says"), ("ImageJ=1.54\nfinterval=2\ntunit=min\n", 120, "ImageJ's finterval"),
    (OME_TEXT.format(frames=4), 0.25, "as OME's TimeIncrement says"),
    (OME_TEXT.replace('250" TimeIncrementUnit="ms', '250000" TimeIncrementUnit="µs').format(frames=4).encode(), 0.25, "OME's"),
    (OME_TEXT.format(frames=1), 1, "pages tell no time"),
    ("ImageJ=1.54\nimages=4\nslices=4\n", 1, "pages tell no time"),
    ("ImageJ=1.54\nfinterval=0.0\n", 1, "pages tell no time"), ("finterval=0.25", 1, "pages tell no time")])
def test_the_interval_of_a_stack_is_read(tmp_path, text, step_s, says):
    source = open_source(stack(tmp_path / "stack.tif", 4, text), Options())
    assert source.times_ns == [round(i * step_s * 1e9) for i in range(4)] and says in source.account.assumed[0] and source.nominal_time == ("no time" in says)
    asked = open_source(tmp_path / "stack.tif", Options(rate_hz=8.0))
    assert asked.times_ns[1] == 125_000_000 and ("says 0.25 s" in asked.account.assumed[0]) == (step_s == 0.25)


IMAGEJ = "ImageJ=1.54\nimages=12\n{}\nhyperstack=true\nfinterval=0.25\n"
OME = ('<OME><Image><Pixels DimensionOrder="{}" SizeC="2" SizeT="{}" SizeZ="{}" TimeIncrement="0.25"><Channel Name="vis"/><Channel ID="1" Name="dark"/></Pixels>'
       "</Image></OME>")


# verifies: GND-03
@pytest.mark.parametrize(("text", "camera", "pages", "asks"), [
    (IMAGEJ.format("channels=2\nframes=6"), "c2", range(1, 12, 2), "2 channels of 6 moments: choose by --camera c1 ... c2; --camera pages takes all"),
    (IMAGEJ.format("slices=3\nframes=4"), "z3", range(2, 12, 3), "3 slices of 4 moments: choose by --camera z1 ... z3"),
    (IMAGEJ.format("channels=2\nslices=3\nframes=2"), "C2Z3", range(5, 12, 6), "2 channels and 3 slices of 2 moments: choose by --camera c1z1 ... c2z3"),
    (IMAGEJ.format("channels=12"), "c3", range(2, 3), "12 channels of 1 moments"),
    (IMAGEJ.format("channels=2\nframes=5"), "pages", range(12), "2 channels of 5 moments: these are 10"),
    (OME.format("XYCZT", 6, 1), "Dark", range(1, 12, 2), r"2 channels of 6 moments \(channels 1: vis, 2: dark\): choose by --camera c1"),
    (OME.format("XYZTC", 6, 1), "c2", range(6, 12), "2 channels of 6 moments"), (OME.format("XYZCT", 3, 2), "c2z1", range(2, 12, 4), "2 channels and 2 slices of 3 moments")])
def test_pages_of_one_moment_are_chosen_from(tmp_path, text, camera, pages, asks):
    path = stack(tmp_path / "stack.tif", 12, text)
    for wrong in (Options(), Options(camera="c99"), Options(rate_hz=2.0)):
        with pytest.raises(BadInput, match=f"says that the 12 pages are {asks}"):
            open_source(path, wrong)
    source = open_source(path, Options(camera=camera))
    frames = list(source.frames)
    assert [int(frame.pixels[0, 0]) for frame in frames] == list(pages) and source.count == len(pages)
    step_s = 1 if camera == "pages" else 0.25
    assert [frame.timestamp_ns for frame in frames] == source.times_ns == [round(i * step_s * 1e9) for i in range(len(pages))]
    assert "as --camera says" in source.account.assumed[1] and source.account.dropped.total() == 12 - len(pages)


def test_colours_of_a_page_and_slices_alone_are_frames(tmp_path):
    colours = stack(tmp_path / "stack.tif", 4, '<Pixels DimensionOrder="XYCZT" SizeC="3" SizeT="4" SizeZ="1" TimeIncrement="0.5"/>')
    assert open_source(colours, Options()).times_ns[1] == 500_000_000
    slices = open_source(stack(tmp_path / "slices.tif", 4, "ImageJ=1.54\nimages=4\nslices=4\n"), Options())
    assert len(slices.times_ns) == 4 and "ImageJ calls the pages slices, which are heights: they are taken for frames" in slices.account.assumed
