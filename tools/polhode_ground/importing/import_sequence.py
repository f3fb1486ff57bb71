"""Makes an image sequence, as `polhode replay` reads it, of what people have.

SOURCE is a video, a folder of pictures, a TUM or EuRoC sequence, a COLMAP project (text or binary), a ROS 1 or 2 bag or an
MCAP file; which of them is found out by itself. SEQ is made in the ASL/EuRoC layout. Standard output says what was read,
dropped and assumed; SEQ/import.json keeps it.

Examples:
  tools/import_sequence.py clip.mp4 SEQ --intrinsics calibration.yaml     a video, a calibration of OpenCV, Kalibr, ROS or COLMAP
  tools/import_sequence.py clip.mp4 SEQ --intrinsics auto --from 2 --to 30 --step 3
  tools/import_sequence.py stream.h264 SEQ --rate-hz 30 --intrinsics calibration.yaml
  tools/import_sequence.py photos/ SEQ --rate-hz 2                        pictures; the focal length from EXIF
  tools/import_sequence.py recording.bag SEQ --topic /cam/image_raw       intrinsics from its CameraInfo
  tools/import_sequence.py SEQ --intrinsics auto                          estimates the focal length of a sequence that is there
"""

import argparse
import pathlib
import sys

from polhode_ground.common.venv import enter_venv, run_main

PROGRESS_FRAMES = 100  # a line of progress after so many


def parse() -> argparse.Namespace:
    from polhode_ground.importing.arguments import at_least_one, positive, seconds

    parser = argparse.ArgumentParser(
        description=__doc__.strip(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="Exit status: 0 done, with a warning in the last line where a tenth of the frames is lost or missing; 1 half of the frames are lost, or the "
        "focal length can't be known from the pictures; 2 unusable arguments or source (one line says which).",
    )
    parser.add_argument("source", metavar="SOURCE", type=pathlib.Path)
    parser.add_argument(
        "sequence",
        metavar="SEQ",
        type=pathlib.Path,
        nargs="?",
        help="to be made; left out: SOURCE is a sequence, only its intrinsics change",
    )
    parser.add_argument(
        "--intrinsics",
        metavar="HOW",
        help="a calibration file (Kalibr, OpenCV, NumPy, ROS, EuRoC, COLMAP), 'fu,fv,cu,cv' in px, or 'auto': "
        "the focal length is estimated from the pictures (default: the source's own, else EXIF's)",
    )
    parser.add_argument(
        "--camera",
        default="cam0",
        help="which camera of an EuRoC sequence, a Kalibr file or COLMAP's cameras, the frame_id "
        "in a bag's topic, the word in the names of pictures (no-mask: those without it), the number, title or language of a video's track, "
        "the channel and slice of a TIFF's pages, as c2z1 (default: cam0)",
    )
    parser.add_argument("--topic", help="of a bag's pictures, where it has several")
    parser.add_argument("--rate-hz", type=positive, metavar="HZ", help="of pictures and bare video streams, which tell no time")
    parser.add_argument(
        "--stamp-unit",
        choices=("s", "ms", "us", "ns"),
        help="of the times in a list of pictures, or of the numbers in their names (default: as the kind of list has it; another "
        "is taken where that can't be)",
    )
    parser.add_argument(
        "--from",
        dest="from_s",
        type=seconds,
        default=0.0,
        metavar="S",
        help="leave out what is earlier than S seconds after the first frame",
    )
    parser.add_argument("--to", dest="to_s", type=seconds, metavar="S", help="leave out what is later")
    parser.add_argument("--unwrap", action="store_true", help="the stamps are those of a counter that begins again at its end")
    parser.add_argument("--allow-loss", action="store_true", help="write the sequence also where half of the frames or more are lost")
    parser.add_argument("--step", type=at_least_one, default=1, metavar="N", help="take every Nth frame only")
    return parser.parse_args()


def progress(count: int) -> None:
    if count and count % PROGRESS_FRAMES == 0:
        print(f"{count} frames", file=sys.stderr)


def chosen_lens(asked: argparse.Namespace, source):
    """(lens or None where it is to be estimated, where it is from)."""
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.arguments import lens_of_numbers
    from polhode_ground.importing.calibration_files import read_lens

    if asked.intrinsics == "auto":
        return None, "to be estimated"
    if asked.intrinsics is not None:
        numbers = lens_of_numbers(asked.intrinsics)
        return (numbers, "--intrinsics") if numbers else (read_lens(pathlib.Path(asked.intrinsics), asked.camera), asked.intrinsics)
    if source.lens is None and source.account.no_lens:
        raise BadInput(f"{asked.source}: {source.account.no_lens}")
    if source.lens is None:
        raise BadInput(f"{asked.source}: {source.kind}; it tells no intrinsics: give --intrinsics FILE, 'fu,fv,cu,cv' or auto")
    if source.lens_from.startswith("EXIF"):
        source.account.assumed.append(
            f"focal length {source.lens.intrinsics_px[0]:.1f} px, principal point in the middle and no distortion, by "
            f"{source.lens_from}: good to some per cent, --intrinsics auto is better"
        )
    return source.lens, source.lens_from


def tell(record: dict) -> None:
    print(f"read: {record['source']}, {record['kind']}")
    for reason, count in record["dropped"].items():
        print(f"dropped: {count} frames: {reason}")
    if record["missing"]:
        print(f"missing: {record['missing']}")
    for sentence in record["assumed"]:
        print(f"assumed: {sentence}")
    for sentence in record.get("doubtful", []):
        print(f"doubtful: {sentence}")


def import_source(asked: argparse.Namespace):
    """@return what was lost of the source's frames."""
    from polhode_ground.common.errors import BadInput
    from polhode_ground.importing.levels import Levels
    from polhode_ground.importing.plan import Part, Plan
    from polhode_ground.importing.recognise import open_source
    from polhode_ground.importing.source import Options
    from polhode_ground.importing.video import ROLLING
    from polhode_ground.importing.writing import Writer

    if asked.sequence.exists():
        raise BadInput(f"{asked.sequence}: is there already")
    if asked.sequence.is_symlink():
        raise BadInput(f"{asked.sequence}: a link to {asked.sequence.readlink()}, which is not there; remove the link or give another name")
    source = open_source(asked.source, Options(asked.rate_hz, asked.topic, asked.camera, asked.stamp_unit))
    lens, where = chosen_lens(asked, source)
    account = source.account
    try:
        plan = Plan(source, Part(asked.from_s, asked.to_s, asked.step, asked.unwrap))
    except BadInput as problem:
        raise BadInput(f"{asked.source}: {problem}") from None
    writer = Writer(asked.sequence, lens, where, account, beside_files=plan.files_beside(), line_time_ns=source.line_time_ns)
    if source.line_time_ns or lens and lens.line_time_ns:
        account.assumed = [sentence for sentence in account.assumed if sentence != ROLLING]
    try:
        writer.write_all(Levels(account).of(plan.frames()), progress)
        if not writer.rows:
            raise BadInput(
                f"{asked.source}: {source.kind}: no frame is left ({', '.join([*account.dropped, *writer.problems]) or 'it holds none'})"
            )
        loss = plan.loss()
        record = {
            "source": str(asked.source),
            "kind": source.kind,
            "dropped": dict(account.dropped),
            "missing": plan.gaps.said,
            "lost": loss.said if loss.frames else "",
            "assumed": account.assumed,
            "nominal_time": source.nominal_time,
        }
        if loss.is_refused and not asked.allow_loss:
            writer.abandon()
            tell(record)
            return loss
        record = writer.finish(record)
    except BaseException:
        writer.abandon()
        raise
    tell(record)
    span_s = (writer.rows[-1][0] - writer.rows[0][0]) * 1e-9
    print(
        f"written: {len(writer.rows)} frames of {writer.size[0]}x{writer.size[1]} over {span_s:.3f} s to {asked.sequence}; intrinsics: {where}"
    )
    return loss


def main() -> int:
    asked = parse()
    from polhode_ground.common.errors import BadInput

    if asked.to_s is not None and asked.to_s < asked.from_s:
        raise BadInput(f"--from {asked.from_s:g} --to {asked.to_s:g}: --to is before --from, allowed is at least that")
    if asked.sequence is None and asked.intrinsics != "auto":
        raise BadInput("SEQ is needed, or --intrinsics auto for a sequence that is there")
    loss = import_source(asked) if asked.sequence is not None else None
    if loss and loss.is_refused and not asked.allow_loss:
        print(f"import_sequence: {asked.source}: {loss.said}: nothing is written; --allow-loss takes what is left", file=sys.stderr)
        return 1
    status = 0
    if asked.intrinsics == "auto":
        from polhode_ground.importing import focal

        status = focal.estimate_and_write(asked.sequence or asked.source)
    if loss and loss.is_told:
        print(f"warning: {loss.said}", file=sys.stderr)
    return status


def command() -> None:
    enter_venv()
    run_main(main, "import_sequence")
