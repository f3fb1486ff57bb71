"""A model from a file: OBJ, STL, PLY or glTF with its own materials. G is the file's own frame, in metres * scale."""

from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from .. import mesh
from ..scene_file import SceneError


def build(path, scale):
    """Parts, no materials of ours, no known lengths. The imported objects stay in the scene, for adopt()."""
    kind = Path(path).suffix.lower()
    try:
        _import(path, kind)
    except RuntimeError as error:
        raise SceneError(f"target.path: {path} cannot be read: {_reason(str(error))}") from None
    objects = _mesh_objects()
    if not objects:
        raise SceneError(f"target.path: {path} holds no mesh")
    # The glTF importer turns the file's y-up axes into z-up ones; undo it.
    back = Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1))) if kind in (".gltf", ".glb") else Matrix.Identity(4)
    parts = []
    worlds = [(thing, back @ Matrix.Scale(scale, 4) @ thing.matrix_world.copy()) for thing in objects]
    for thing, world in worlds:
        thing.data = thing.data.copy()
        thing.parent = None
        thing.data.transform(world)
        thing.matrix_world = Matrix.Identity(4)
        parts.append(_part(thing))
    for thing in list(bpy.data.objects):
        if thing.type not in ("MESH", "CAMERA"):
            bpy.data.objects.remove(thing)
    return parts, {}, []


def _reason(trace):
    """The line of an importer's stack trace that says what went wrong."""
    lines = [line.strip() for line in trace.splitlines() if line.strip() and not line.startswith((" ", "Location"))]
    named = [line for line in lines if "Error: " in line and not line.startswith("Error: Python")]
    return (named or lines or ["no reason given"])[-1].removeprefix("Error: ")


def _import(path, kind):
    if kind == ".obj":
        bpy.ops.import_scene.obj(filepath=path, axis_forward="Y", axis_up="Z")
    elif kind == ".stl":
        bpy.ops.import_mesh.stl(filepath=path)
    elif kind == ".ply":
        bpy.ops.import_mesh.ply(filepath=path)
    else:
        # Debian's glTF importer is older than its NumPy and still asks for this alias.
        if not hasattr(np, "bool"):
            np.bool = bool
        bpy.ops.import_scene.gltf(filepath=path)


def _mesh_objects():
    return [thing for thing in bpy.data.objects if thing.type == "MESH" and len(thing.data.polygons)]


def _part(thing):
    data = thing.data
    data.calc_loop_triangles()
    vertices = np.empty(3 * len(data.vertices), dtype=np.float32)
    data.vertices.foreach_get("co", vertices)
    faces = np.empty(3 * len(data.loop_triangles), dtype=np.int32)
    data.loop_triangles.foreach_get("vertices", faces)
    faces = faces.reshape(-1, 3)
    return mesh.Part(thing.name, vertices.reshape(-1, 3).astype(float), faces, np.zeros((len(faces), 3, 2)), "imported")


def adopt(root, origin_m):
    """Hangs the imported objects under root, with origin_m (3,) becoming its origin."""
    for thing in [t for t in _mesh_objects() if t.parent is None]:
        thing.data.transform(Matrix.Translation([-float(x) for x in origin_m]))
        thing.parent = root
        if not thing.data.materials:
            thing.data.materials.append(_own_material(thing.data))


def _own_material(data):
    """Matt, of a mesh whose file names none: in its vertices' colours where it has them, else grey."""
    material = bpy.data.materials.new("own")
    material.use_nodes = True
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Specular"].default_value = 0.0
    surface.inputs["Base Color"].default_value = (0.5, 0.5, 0.5, 1)
    if data.vertex_colors:
        node = material.node_tree.nodes.new("ShaderNodeVertexColor")
        node.layer_name = data.vertex_colors[0].name
        material.node_tree.links.new(node.outputs["Color"], surface.inputs["Base Color"])
    return material
