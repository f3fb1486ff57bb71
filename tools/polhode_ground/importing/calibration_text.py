"""The text of a calibration file as a table of fields: YAML, JSON, OpenCV's YAML and XML, in whichever encoding it came."""

import codecs
import collections
import pathlib
import re

from polhode_ground.common.errors import BadInput

# What begins so is no text that is read here: (first octets, what it is and what to do).
BINARY = (
    (
        b"MATLAB 5.0",
        "a MAT file: write its camera matrix, distortion and size as OpenCV does (cameraIntrinsicsToOpenCV), or by hand as YAML",
    ),
    (b"\x89HDF", "an HDF5 file (MATLAB 7.3 writes such): write its camera matrix, distortion and size as YAML"),
    (b"\x93NUMPY", "a single NumPy array: write matrix and distortion by numpy.savez(FILE, mtx=..., dist=...)"),
    (b"\x80", "a pickle, which is not opened as it may run code: write matrix and distortion by numpy.savez(FILE, mtx=..., dist=...)"),
)
COMMAS, POINTS = re.compile(r"\d,\d+\s*(?:,\s|<|\s+-?\d|\n|\])"), re.compile(r"\d\.\d")
OPENCV_KEY = re.compile(r"(?m)^([A-Za-z_]\w*)\s*:")


def text_of(path: pathlib.Path) -> str:
    """UTF-8 or, where it begins so, UTF-16."""
    octets = path.read_bytes()
    for begin, what in BINARY:
        if octets.startswith(begin):
            raise BadInput(f"{path}: {what}")
    if octets.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return octets.decode("utf-16", errors="replace")
    return octets.decode("utf-8-sig", errors="replace")


def with_hint(text: str) -> str:
    """What is to be added to a refusal."""
    body = text.partition("\n")[2]  # the first line has a version
    return "; where commas stand for decimal points, write points" if COMMAS.search(body) and not POINTS.search(body) else ""


def opencv_values(path: pathlib.Path) -> dict:
    """What cv::FileStorage wrote, if it did: XML, JSON, or YAML with matrices of its own type."""
    import cv2

    text = text_of(path)
    if "opencv" not in text:
        return {}
    _refuse_repeated(path, OPENCV_KEY.findall(text))
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)  # nodes do not keep it
        node = storage.root()
        return {key: _node_value(node.getNode(key)) for key in node.keys()}
    except (cv2.error, SystemError) as problem:
        why = str(problem.__cause__ or problem).strip().splitlines()[-1]
        raise BadInput(f"{path}: OpenCV can't read it: {why}{with_hint(text)}") from None


def _node_value(node):
    if node.isInt() or node.isReal():
        return node.real()
    if node.isString():
        return node.string()
    if node.isMap():
        if {"rows", "cols", "data"} <= set(node.keys()):
            return node.mat().ravel().tolist()
        return {key: _node_value(node.getNode(key)) for key in node.keys()}
    return [_node_value(node.at(i)) for i in range(node.size())] if node.isSeq() else None


def yaml_values(path: pathlib.Path) -> dict:
    """@errors BadInput of what is no table, or has a field twice"""
    import yaml

    whole = text_of(path)
    # EuRoC in the wild begins with OpenCV's "%YAML:1.0", which is no YAML.
    text = "\n".join(line for line in whole.splitlines() if not line.startswith("%")).replace("\t", " ")
    try:
        _refuse_twice(path, next(yaml.compose_all(text, yaml.SafeLoader), None))
        values = next(yaml.safe_load_all(text), None)  # a message that was printed ends by ---
    except (yaml.YAMLError, RecursionError) as problem:
        raise BadInput(f"{path}: not YAML: {' '.join(str(problem).split())}") from None
    if not isinstance(values, dict):
        raise BadInput(
            f"{path}: not a table of fields; read are YAML, JSON, XML and NumPy's .npz, as Kalibr, OpenCV, ROS, camodocal, mrcal, "
            "MATLAB (jsonencode) and Metashape write them, and COLMAP's cameras.txt and cameras.bin of these names"
        )
    return values


def _refuse_twice(path: pathlib.Path, root) -> None:
    import yaml

    waiting, seen = [root], set()
    while waiting:
        node = waiting.pop()
        if id(node) in seen or not isinstance(node, yaml.CollectionNode):
            continue
        seen.add(id(node))
        if isinstance(node, yaml.MappingNode):
            _refuse_repeated(path, [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode) and key.value != "<<"])
            waiting += [value for _, value in node.value]
        else:
            waiting += node.value


def _refuse_repeated(path: pathlib.Path, names: list[str]) -> None:
    name, count = collections.Counter(names).most_common(1)[0] if names else ("", 0)
    if count > 1:
        raise BadInput(f"{path}: {name}: field is there twice")
