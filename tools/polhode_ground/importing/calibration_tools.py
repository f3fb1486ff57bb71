"""Cameras as other tools' tables and files have them: named numbers, camodocal, mrcal, MATLAB, Metashape."""

import pathlib
import re

from polhode_ground.common.errors import BadInput
from polhode_ground.importing.lens import Lens, lens_of
from polhode_ground.importing.lens_models import model_named

FIELDS = {
    "fu": ("fx", "fu", "flx", "focallengthx", "focalx", "gamma1", "mu", "alphax", "f"),
    "fv": ("fy", "fv", "fly", "focallengthy", "focaly", "gamma2", "mv", "alphay", "f"),
    "cu": ("cx", "cu", "ppx", "u0", "principalpointx"),
    "cv": ("cy", "cv", "ppy", "v0", "principalpointy"),
}
TABLES = ("projection_parameters", "intrinsics", "intrinsic", "camera_matrix", "camera_intrinsics", "K")
OPENCV_ORDER = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4")
CAMODOCAL_FISHEYE = ("k2", "k3", "k4", "k5")
PREFIX = re.compile(r"^(camera|cam)[01]?")
DISTORTIONS = (
    "distortioncoefficients",
    "distcoeffs",
    "distcoeff",
    "distcoefs",
    "distcoef",
    "distortioncoeffs",
    "distortioncoeff",
    "distortioncoefs",
    "distortioncoef",
    "distortion",
    "distortionparameters",
    "distortionparams",
    "distortionvector",
    "dist",
    "d",
    "d1",
    "coeffs",
    "distcoefficients",
)
SIZES = (("width", "imagewidth", "w", "imgwidth", "cols"), ("height", "imageheight", "h", "imgheight", "rows"))
LOOKS_DISTORTED = re.compile(r"dist|coef")


def plain(name) -> str:
    return re.sub("[^a-z0-9]", "", str(name).lower())


def named(values: dict) -> dict:
    """By plain names, without the prefix that ORB-SLAM's have."""
    return {PREFIX.sub("", plain(name)) or plain(name): value for name, value in values.items()}


def intrinsics_of(values: dict) -> list | None:
    """fu, fv, cu, cv that stand as numbers of these names, at the top or in a table; None where they do not."""
    for table in [*(values[name] for name in TABLES if isinstance(values.get(name), dict)), values]:
        found = named(table)
        numbers = [next((found[name] for name in names if name in found), None) for names in FIELDS.values()]
        if all(number is not None for number in numbers):
            # Nerfstudio's pixel centres lie at + 0.5, as COLMAP's.
            return numbers if "flx" not in found else [*numbers[:2], *(float(place) - 0.5 for place in numbers[2:])]
    return None


def size_of(values: dict) -> list:
    """Width and height where they have names; zeros where they have not."""
    found = named(values)
    return [next((found[name] for name in names if name in found), 0) for names in SIZES]


def coefficients_of(values: dict, model: str, where: str) -> list | None:
    """In OpenCV's order; None where nothing tells them."""
    found = {plain(name): value for name, value in values.items()}
    given = next((found[name] for name in DISTORTIONS if found.get(name) is not None), None)
    if isinstance(given, str):
        raise BadInput(f"{where}: distortion '{given}', needed are numbers")
    if given is not None and not (isinstance(given, dict) and "data" not in given):
        return flat(given)
    single = {name: value for name, value in named(given if given is not None else values).items() if name in OPENCV_ORDER}
    if single:
        return _of_single(single, model, where)
    radial, tangential = (flat(found.get(name)) for name in ("radialdistortion", "tangentialdistortion"))
    if radial:
        return [*(radial + [0.0])[:2], *(tangential or [0.0, 0.0]), *radial[2:]]
    looks = [
        str(name)
        for name, value in values.items()
        if value and LOOKS_DISTORTED.search(plain(name)) and not re.search("model|type", plain(name))
    ]
    if looks:
        raise BadInput(f"{where}: {', '.join(looks)}: looks like a distortion, but is none that is read; write distortion_coefficients")
    return None


def _of_single(single: dict, model: str, where: str) -> list:
    if model and model_named(model, where) == "equidistant":
        return [single.get(name, 0.0) for name in ("k1", "k2", "k3", "k4")]
    if "k4" in single and not {"k5", "k6", "p1", "p2"} & set(single):
        raise BadInput(f"{where}: k1 to k4 without p1 and p2, and no distortion_model: name it (radtan, equidistant)")
    length = next(count for count in (4, 5, 8, 12) if not set(OPENCV_ORDER[count:]) & set(single))
    return [single.get(name, 0.0) for name in OPENCV_ORDER[:length]]


def flat(value) -> list:
    """Numbers of a list, of rows of lists, or of ROS' {rows, cols, data}."""
    if isinstance(value, dict):
        value = value.get("data", [])
    if not isinstance(value, (list, tuple)):
        return [] if value is None else [value]
    return [item for row in value for item in flat(row)]


def camodocal(path: pathlib.Path, values: dict) -> Lens:
    """As VINS has it, too: model_type and its parameters by name."""
    kind, numbers = str(values["model_type"]).upper(), values.get("projection_parameters") or {}
    size = size_of(values)
    distortion = [float((values.get("distortion_parameters") or {}).get(name, 0)) for name in ("k1", "k2", "p1", "p2")]
    pinhole = intrinsics_of(values)
    if kind in ("PINHOLE", "MEI", "KANNALA_BRANDT") and pinhole is None:
        raise BadInput(f"{path}: model_type {kind}: projection_parameters are not complete, they have {', '.join(numbers) or 'nothing'}")
    if kind == "PINHOLE":
        return lens_of(*size, pinhole, "radtan", distortion, str(path))
    if kind == "MEI":
        return lens_of(*size, pinhole, "omni", [(values.get("mirror_parameters") or {}).get("xi", 0), *distortion], str(path))
    if kind == "KANNALA_BRANDT":
        return lens_of(*size, pinhole, "equidistant", [numbers.get(name, 0) for name in CAMODOCAL_FISHEYE], str(path))
    raise BadInput(f"{path}: model_type {kind}, allowed are PINHOLE, MEI, KANNALA_BRANDT")


MRCAL = {"LENSMODEL_PINHOLE": 0, "LENSMODEL_OPENCV4": 4, "LENSMODEL_OPENCV5": 5, "LENSMODEL_OPENCV8": 8, "LENSMODEL_OPENCV12": 12}


def mrcal(path: pathlib.Path, values: dict) -> Lens:
    model, numbers = str(values["lensmodel"]), flat(values.get("intrinsics"))
    if model not in MRCAL:
        raise BadInput(f"{path}: {model}, allowed are {', '.join(MRCAL)}; convert it by mrcal-convert-lensmodel")
    if len(numbers) != 4 + MRCAL[model]:
        raise BadInput(f"{path}: {model}: {len(numbers)} numbers in intrinsics, needed are {4 + MRCAL[model]}")
    return lens_of(*(flat(values.get("imagersize")) or [0, 0])[:2], numbers[:4], "radtan", numbers[4:], str(path))


def matlab(path: pathlib.Path, values: dict) -> Lens:
    """MATLAB's cameraIntrinsics as jsonencode writes it: its first pixel is 1, its sizes are rows and columns."""
    if any(flat(values.get("Skew"))):
        raise BadInput(f"{path}: Skew: {values['Skew']}, allowed is 0: axes of pixels at a right angle")
    radial, tangential = flat(values.get("RadialDistortion")), flat(values.get("TangentialDistortion"))
    rows, columns = (flat(values.get("ImageSize")) or [0, 0])[:2]
    coefficients = [*(radial + [0, 0])[:2], *(tangential + [0, 0])[:2], *radial[2:]]
    try:
        focal, centre = flat(values["FocalLength"]), [float(place) - 1 for place in flat(values["PrincipalPoint"])]
    except (KeyError, TypeError, ValueError):
        raise BadInput(f"{path}: FocalLength and PrincipalPoint of MATLAB's cameraIntrinsics are needed as numbers") from None
    return lens_of(columns, rows, (*focal, *centre), "radtan", coefficients, str(path))


def xml_lens(path: pathlib.Path, text: str) -> Lens | None:
    """Of Metashape's XML; None where the text is no XML."""
    import xml.etree.ElementTree as trees

    if not text.lstrip().startswith("<"):
        return None
    try:
        root = trees.fromstring(text.lstrip().encode())
    except (trees.ParseError, ValueError) as problem:
        raise BadInput(f"{path}: not XML that can be read: {problem}") from None
    table = next((node for node in root.iter("calibration") if node.find("f") is not None), None)
    if table is None:
        raise BadInput(
            f"{path}: XML of a kind that is not read ({root.tag.split('}')[-1]}); read are OpenCV's and Metashape's; export the lens as OpenCV's"
        )
    return _metashape(path, {node.tag: (node.text or "").strip() for node in table} | dict(table.attrib))


def _metashape(path: pathlib.Path, fields: dict) -> Lens:
    """Agisoft Metashape's manual, appendix D: cx and cy from the picture's middle, p1 and p2 in the other order, pixel centres at + 0.5."""
    kind = fields.get("projection") or fields.get("type") or "frame"
    if kind != "frame":
        raise BadInput(f"{path}: Metashape's projection '{kind}', allowed is 'frame'; export it as OpenCV's")
    try:
        f, cx, cy, b1, b2, k1, k2, k3, k4, p1, p2 = (
            float(fields.get(name) or 0) for name in ("f", "cx", "cy", "b1", "b2", "k1", "k2", "k3", "k4", "p1", "p2")
        )
        width, height = int(fields["width"]), int(fields["height"])
    except (KeyError, ValueError) as problem:
        raise BadInput(f"{path}: Metashape's width, height, f, cx, cy and coefficients are needed as numbers: {problem}") from None
    if k4 or abs(b2) > 1e-3 * f:
        raise BadInput(
            f"{path}: Metashape's k4 {k4:g} and b2 {b2:g}, allowed are 0 and up to {1e-3 * f:.2g}: adjust without them, or export undistorted pictures"
        )
    return lens_of(width, height, (f + b1, f, width / 2 + cx - 0.5, height / 2 + cy - 0.5), "radtan", (k1, k2, p2, p1, k3), str(path))
