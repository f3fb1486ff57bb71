"""The page in viser's own server and client: each part is updated at a rate of its own, and only where it has changed."""

import contextlib
import io
import logging
import threading
import time

import numpy as np
import viser

from polhode_ground.busgen.table import Table
from polhode_ground.common.errors import BadInput
from polhode_ground.watching import body, words
from polhode_ground.watching.state import RATES_S, State

TEXT_S, PLOT_S = 0.2, 0.5  # from one update to the next: nobody reads faster
STOP_S = 1.0
IMAGE_WIDTH_PX = 640
JPEG_QUALITY = 80
PLOT_POINTS_MAX = 300
RIGHT_PX, LEFT_PX = 420, 360
FOV_RAD = 0.75
FITTED_FACTOR = 2.5  # a distance so many times another is looked at anew: the unit of length has changed
CAMERA_RGB, CLOUD_RGB, BOX_RGB = (60, 60, 60), (59, 91, 122), (230, 160, 0)


def start_server(host: str, port: int) -> viser.ViserServer:
    """@errors BadInput: the port was taken in the meantime."""
    logging.getLogger("websockets.server").setLevel(logging.CRITICAL + 1)  # a browser that looks ahead connects and says nothing
    with contextlib.redirect_stdout(io.StringIO()):  # it prints a table of its own
        server = viser.ViserServer(host=host, port=port, label="Polhode", verbose=False)
    if port not in (0, server.get_port()):  # it goes on to the next free one
        stop_server(server)
        raise BadInput(f"--port {port}: Address already in use; --port 0 takes a free one")
    return server


def stop_server(server: viser.ViserServer) -> None:
    """Gives viewers a moment to part: the library would wait 6 s for a busy browser. Its threads end with the process."""
    stopping = threading.Thread(target=server.stop, daemon=True)
    with contextlib.redirect_stdout(io.StringIO()):
        stopping.start()
        stopping.join(STOP_S)


class Page:
    def __init__(self, server: viser.ViserServer, table: Table, apid_first: int, address: str, has_images: bool):
        self._server, self._table = server, table
        self._text_s = self._plot_s = self._fitted = 0.0
        self._drawn_shape, self._drawn_cloud = None, (-2, -2)  # a packet, and State.cloud_number
        server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(31, 119, 180))
        server.gui.set_panel_label(f"Polhode {address}")
        self._make_right(has_images)
        self._make_left(apid_first)
        self._make_scene()

    def _make_right(self, has_images: bool) -> None:
        gui = self._server.gui
        gui.main_panel.dock_right()
        gui.main_panel.set_width(RIGHT_PX)
        self._head = gui.add_html("")
        self._image = None
        if has_images:
            self._image = gui.add_image(np.full((480, 640, 3), 40, np.uint8), jpeg_quality=JPEG_QUALITY)
        self._noted = (
            ""
            if has_images
            else words.block(
                '<p class="dim">No images: packets carry none. Start with <code>--images FOLDER</code>, the recording '
                "of the run or the sequence that it plays.</p>"
            )
        )
        self._note = gui.add_html(self._noted)
        self._motion = gui.add_html("")
        series = (
            {},
            *({"stroke": colour, "width": 1.5} for colour in words.AXIS_COLOURS),
            *({"stroke": "rgba(0,0,0,0)", "width": 0} for _ in range(6)),
        )
        bands = tuple({"series": (4 + 2 * i, 5 + 2 * i), "fill": f"{colour}30"} for i, colour in enumerate(words.AXIS_COLOURS))
        self._plot = gui.add_uplot(
            self._plotted([], 0),
            series,
            bands=bands,
            height=170,
            padding=(10, 24, 0, 0),
            legend={"show": False},
            cursor={"show": False},
            scales={"x": {"time": False, "range": (-RATES_S, 0.0)}},
            axes=(
                {"label": "s before the last frame", "labelSize": 16, "size": 28},
                {"label": "rate in T, deg/s", "labelSize": 16, "size": 44},
            ),
        )

    def _make_left(self, apid_first: int) -> None:
        panel = self._server.gui.add_panel()
        with panel.add_tab("Health and events"):
            self._health = self._server.gui.add_html("")
            self._server.gui.add_html(words.block("<p><b>Events</b></p>"))
            self._events = self._server.gui.add_html("")
        with panel.add_tab("Commands"):
            self._server.gui.add_html(words.commands(self._table, apid_first))
        panel.dock_left()
        panel.set_width(LEFT_PX)

    def _make_scene(self) -> None:
        scene = self._server.scene
        scene.set_up_direction("-y")  # C has y down
        self._server.initial_camera.fov = FOV_RAD
        self._frustum = scene.add_camera_frustum("/camera", fov=FOV_RAD, aspect=4 / 3, scale=1.0, color=CAMERA_RGB, visible=False)
        self._target = scene.add_frame("/target", show_axes=False, visible=False)
        self._axes = scene.add_frame("/target/axes", axes_length=1.0, axes_radius=0.03)

    def draw(self, state: State, silence_s: float, image: np.ndarray | None, note: str) -> None:
        """@param image  RGB, a new one; None: the last one stays. @param note  on the image, as HTML; empty: the last one stays."""
        now = time.monotonic()
        self._noted = words.block(f"<p>{note}</p>") if note else self._noted
        with self._server.atomic():
            self._draw_scene(state)
        if image is not None and self._image is not None:
            self._image.image = image
        if now - self._text_s >= TEXT_S:
            self._text_s = now
            self._say(self._head, words.head(state, silence_s))
            self._say(self._note, self._noted)
            self._say(self._motion, words.motion_rows(state))
            self._say(self._health, words.health(state, self._table))
            self._say(self._events, words.events(state))
        if now - self._plot_s >= PLOT_S:
            self._plot_s = now
            self._plot.data = self._plotted(state.rates, state.latest["motion"].timestamp_ns if "motion" in state.latest else 0)

    @staticmethod
    def _say(place, text: str) -> None:
        if place.content != text:
            place.content = text

    @staticmethod
    def _plotted(rates, now_ns: int) -> tuple[np.ndarray, ...]:
        """Seconds before now_ns, w_T of x, y, z, and for each above and below by a sigma."""
        kept = list(rates)[::-1][:: max(1, len(rates) // PLOT_POINTS_MAX)][::-1]
        if not kept:
            return tuple(np.zeros(0) for _ in range(10))
        seconds = np.array([one.timestamp_ns - now_ns for one in kept]) * 1e-9
        w = np.array([one.w_T_deg_s for one in kept])
        sigma = np.array([one.sigma_deg_s for one in kept])
        return (seconds, *w.T, *(bound for i in range(3) for bound in (w[:, i] + sigma, w[:, i] - sigma)))

    def _draw_scene(self, state: State) -> None:
        pose = state.pose
        if pose is None:
            self._target.visible = False
            return
        distance = max(float(np.linalg.norm(pose.p_CT)), 1e-9)
        if not self._fitted / FITTED_FACTOR < distance < self._fitted * FITTED_FACTOR:
            self._fit(distance)
        self._target.wxyz, self._target.position, self._target.visible = pose.q_CT, pose.p_CT, True
        shape = state.latest.get("shape")
        if shape is not self._drawn_shape or state.cloud_number != self._drawn_cloud:
            self._drawn_shape, self._drawn_cloud = shape, state.cloud_number
            self._draw_body(body.body_of(state, distance), np.array(state.cloud_T, dtype=np.float32).reshape(-1, 3))

    def _draw_body(self, target: body.Body, cloud: np.ndarray) -> None:
        length = float(np.linalg.norm(target.axes[0]))
        self._axes.wxyz = tuple(body.quaternion(target.axes / length))
        self._axes.position, self._axes.axes_length, self._axes.axes_radius = target.origin, length, 0.02 * length
        self._axes.origin_radius = 0.04 * length
        scene = self._server.scene
        if len(target.corners):
            scene.add_line_segments("/target/box", target.corners[body.EDGES], BOX_RGB, thickness=2.0, thickness_units="screen")
        else:
            scene.remove_by_name("/target/box")
        if len(cloud):
            scene.add_point_cloud("/target/cloud", cloud, CLOUD_RGB, point_size=0.012 * length, point_shape="circle", precision="float32")
        else:
            scene.remove_by_name("/target/cloud")

    def _fit(self, distance: float) -> None:
        """Camera and target both in view, from behind and beside the camera."""
        self._fitted = distance
        self._frustum.scale, self._frustum.visible = 0.05 * distance, True
        eye, to = (-0.3 * distance, -0.6 * distance, -0.55 * distance), (0.0, 0.0, 0.55 * distance)
        self._server.initial_camera.position, self._server.initial_camera.look_at = eye, to
        for client in self._server.get_clients().values():
            client.camera.position, client.camera.look_at = eye, to
