"""From packets to the page, until it is ended."""

import argparse
import contextlib
import errno
import html
import math
import pathlib
import socket
import sys
import threading
import time

from polhode_ground.busgen.table import read_table
from polhode_ground.common.errors import BadInput
from polhode_ground.watching.body import body_of, picture_of
from polhode_ground.watching.feed import Feed, silence_s
from polhode_ground.watching.images import open_images
from polhode_ground.watching.page import IMAGE_WIDTH_PX, Page, start_server, stop_server
from polhode_ground.watching.words import image_note

DRAW_S = 1 / 30
QUIET_S = 0.5  # from one drawing to the next where nothing comes


def check_port(host: str, port: int) -> None:
    """@errors BadInput: in use, or no address of this machine."""
    try:
        family, kind, protocol, _, place = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with contextlib.closing(socket.socket(family, kind, protocol)) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(place)
    except OSError as problem:
        busy = "; --port 0 takes a free one" if problem.errno == errno.EADDRINUSE else ""
        raise BadInput(f"--host {host} --port {port}: {problem.strerror or problem}{busy}") from None


def draw_until(ended: threading.Event, feed: Feed, page: Page, images, has_viewers) -> None:
    """Draws the newest at a steady rate, whatever has come in between."""
    seen, at_s = -1, 0.0
    while not ended.is_set() and not feed.problem:
        begin_s = time.monotonic()
        state = feed.snapshot()
        if has_viewers() and (state.packets != seen or begin_s - at_s > QUIET_S):
            seen, at_s = state.packets, begin_s
            page.draw(state, silence_s(state), *newest_picture(state, images))
        ended.wait(max(0.005, DRAW_S - (time.monotonic() - begin_s)))


def newest_picture(state, images):
    """(RGB or None where there is no new one, a note on it as HTML)."""
    motion = state.latest.get("motion")
    if images is None or motion is None:
        return None, ""
    found = images.newest(motion.timestamp_ns)
    if found is None:
        return None, html.escape(images.problem)
    stamp, gray = found
    pose = state.poses.get(stamp)
    body = body_of(state, math.dist(pose.p_CT, (0, 0, 0)) if pose else 1.0)
    return picture_of(gray, images.camera, pose, body, IMAGE_WIDTH_PX), image_note(stamp, pose is not None)


def serve(asked: argparse.Namespace, repository: pathlib.Path, ended: threading.Event) -> int:
    """@errors BadInput: an argument that can't be used. @return the exit status."""
    images = open_images(asked.images) if asked.images is not None else None
    check_port(asked.host, asked.port)
    feed = Feed(asked.address, asked.apid_first)
    try:
        server = start_server(asked.host, asked.port)
        page = Page(server, read_table(repository / "config/bus"), asked.apid_first, asked.address, images is not None)
        host = f"[{asked.host}]" if ":" in asked.host else asked.host
        print(f"http://{host}:{server.get_port()}", flush=True)
        draw_until(ended, feed, page, images, server.get_clients)
        stop_server(server)
    finally:
        feed.close()
    if feed.problem:
        print(f"watch: {feed.problem}", file=sys.stderr)
    return 1 if feed.problem else 0
