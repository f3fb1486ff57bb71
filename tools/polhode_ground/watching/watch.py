"""Shows a live run in a browser: image, camera and target in 3-D, rates, health, events.

ADDRESS is one that `polhode bus follow` takes: shm:/NAME, beside other readers; unix:PATH, udp:PORT or udp:HOST:PORT, which are bound here and
have one reader; file:PATH, which is read from its beginning. The page's address is printed first. It reads only: the run does not
know of it, and where the page is slow it shows fewer frames, always the newest. Lengths are in m, or in map units until a scale is known.
The outline is that of the box of the shape's dimensions, before a shape that of a requested cloud.

Without a password, whoever reaches --host and --port sees the page. SIGINT or SIGTERM ends it.

Examples:
  tools/watch.py shm:/polhode
  tools/watch.py shm:/polhode --images /var/lib/polhode/recording
  tools/watch.py udp:10015 --port 9000
"""

import argparse
import pathlib
import signal
import threading

from polhode_ground.common.venv import REPOSITORY, enter_venv, run_main


def arguments() -> argparse.Namespace:
    from polhode_ground.common.ranges import whole

    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 ended by a signal; 1 the address can't be read any more; 2 unusable input (one line says which).",
    )
    parser.add_argument(
        "address", metavar="ADDRESS", help="where the packets are: unix:PATH, udp:PORT, udp:HOST:PORT, shm:/NAME, file:PATH"
    )
    parser.add_argument(
        "--images",
        metavar="FOLDER",
        type=pathlib.Path,
        help="recording.folder of the run, or the sequence that it plays: the newest image is shown",
    )
    parser.add_argument(
        "--host", metavar="HOST", default="127.0.0.1", help="own address that the page is served at; 0.0.0.0: all (default: 127.0.0.1)"
    )
    parser.add_argument("--port", metavar="PORT", type=whole(0, 65535), default=8080, help="0: one that is free (default: 8080)")
    parser.add_argument("--apid-first", metavar="N", type=whole(1, 2031), default=416, help="bus.apid_first of the run (default: 416)")
    return parser.parse_args()


def main() -> int:
    asked, ended = arguments(), threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    from polhode_ground.watching.serve import serve

    return serve(asked, REPOSITORY, ended)


def command() -> None:
    enter_venv()
    run_main(main, "watch")
