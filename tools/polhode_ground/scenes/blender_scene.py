"""The only module that talks to Blender: meshes, materials, lights, and one rendered window at a time.

Blender's world axes are the camera's: x right, y down, z forward, with the camera at the origin. The target and the
lights move; the camera never does. Light directions are unit vectors from the target towards the light.
"""

import contextlib
import math
import os

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .materials import normal_image

SUN_ANGLE_RAD = math.radians(0.53)
# How many threads draw changes no pixel. The entry point sets another number before the first scene.
threads = 2
PIXEL_FILTER = "BLACKMAN_HARRIS"
ADAPTIVE_STEP = 16


def reset(samples):
    """An empty scene with Cycles on the CPU, linear output and a transparent background."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = samples
    # Cycles looks every 16 samples whether a pixel has enough: with no more than that, the bookkeeping is all it does.
    cycles.use_adaptive_sampling = samples > ADAPTIVE_STEP
    cycles.adaptive_threshold = 0.06
    cycles.adaptive_min_samples = min(samples, 4)
    cycles.use_denoising = False
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 2, 1, 1
    cycles.transmission_bounces, cycles.transparent_max_bounces = 0, 2
    cycles.caustics_reflective = cycles.caustics_refractive = False
    # Lights that are mirrored twice make single bright pixels; a real lens spreads them.
    cycles.sample_clamp_indirect, cycles.sample_clamp_direct = 2.0, 12.0
    cycles.pixel_filter_type, cycles.filter_width = PIXEL_FILTER, 1.5
    scene.render.film_transparent = True
    scene.render.use_persistent_data = True
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
    settings.exr_codec = "NONE"
    scene.render.use_file_extension = False
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.sensor_fit, camera.data.sensor_width = "HORIZONTAL", 36.0
    camera.data.clip_start, camera.data.clip_end = 0.01, 5000.0
    # Blender's camera looks along its -z with y up: turn it about x to look along +z with y down.
    camera.matrix_world = Matrix.Rotation(math.pi, 4, "X")
    scene.collection.objects.link(camera)
    scene.camera = camera
    return scene


def _image(name, array, color_space):
    """Blender image from (H, W) or (H, W, 3) values in [0, 1], row 0 at the bottom."""
    if array.ndim == 2:
        array = np.repeat(array[..., None], 3, axis=2)
    height, width = array.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=False)
    image.colorspace_settings.name = color_space
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = array
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def _socket(tree, socket, name, value, color_space="Non-Color"):
    """Sets a socket to a constant or links an image texture to it."""
    if isinstance(value, np.ndarray) and value.ndim >= 2:
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = _image(name, value, color_space)
        node.extension = "EXTEND"
        tree.links.new(node.outputs["Color"], socket)
        return
    socket.default_value = value


def _linear(color):
    """Linear RGBA of an sRGB triple."""
    c = np.asarray(color, dtype=float)
    c = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return (*c.tolist(), 1.0)


def make_material(name, spec):
    """Blender material of a Material."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    surface = tree.nodes["Principled BSDF"]
    if isinstance(spec.color, np.ndarray):
        _socket(tree, surface.inputs["Base Color"], name + "_color", spec.color, "sRGB")
    else:
        surface.inputs["Base Color"].default_value = _linear(spec.color)
    _socket(tree, surface.inputs["Roughness"], name + "_roughness", spec.roughness)
    _socket(tree, surface.inputs["Metallic"], name + "_metallic", spec.metallic)
    surface.inputs["Specular"].default_value = spec.specular
    surface.inputs["Clearcoat"].default_value = spec.clearcoat
    surface.inputs["Clearcoat Roughness"].default_value = 0.04
    if spec.emission > 0:
        surface.inputs["Emission"].default_value = (1, 1, 1, 1)
        surface.inputs["Emission Strength"].default_value = spec.emission
    if spec.slopes is not None:
        node = tree.nodes.new("ShaderNodeNormalMap")
        _socket(tree, node.inputs["Color"], name + "_normal", normal_image(spec.slopes))
        tree.links.new(node.outputs["Normal"], surface.inputs["Normal"])
    return material


def add_parts(parts, materials, name="target", origin_m=(0.0, 0.0, 0.0)):
    """One empty object that carries all parts; vertices are shifted so that origin_m becomes its origin."""
    root = bpy.data.objects.new(name, None)
    bpy.context.scene.collection.objects.link(root)
    made = {key: make_material(key, spec) for key, spec in materials.items()}
    for part in parts:
        data = bpy.data.meshes.new(part.name)
        data.from_pydata((part.vertices_G_m - np.asarray(origin_m)).tolist(), [], part.faces.tolist())
        layer = data.uv_layers.new(name="uv")
        layer.data.foreach_set("uv", part.uv.astype(np.float32).ravel())
        data.materials.append(made[part.material])
        if part.smooth:
            data.polygons.foreach_set("use_smooth", np.ones(len(data.polygons), dtype=bool))
        data.update()
        child = bpy.data.objects.new(part.name, data)
        child.parent = root
        bpy.context.scene.collection.objects.link(child)
    return root


def place(thing, R, p_m):
    """Puts an object at rotation R (3, 3) and position p_m (3,) in camera axes."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = R, p_m
    thing.matrix_world = Matrix(matrix.tolist())


def add_sun(strength):
    """Sun of 0.53 deg; strength 1 gives radiance 1 on a white matt surface that faces it."""
    light = bpy.data.lights.new("sun", "SUN")
    light.energy = math.pi * strength
    light.angle = SUN_ANGLE_RAD
    sun = bpy.data.objects.new("sun", light)
    bpy.context.scene.collection.objects.link(sun)
    return sun


def aim_sun(sun, direction_C):
    """Lets the sunlight come from direction_C."""
    sun.matrix_world = Vector(direction_C).to_track_quat("Z", "Y").to_matrix().to_4x4()


def add_earthshine(radiance, half_angle_rad):
    """World light: a cap of blue-white clouded radiance around a direction, black elsewhere. Returns the node that
    holds the direction, for aim_earthshine."""
    world = bpy.data.worlds.new("world")
    bpy.context.scene.world = world
    world.use_nodes = True
    # The cap is so wide that scattered rays find it well enough; sampling it as a light doubles the cost.
    world.cycles.sampling_method = "NONE"
    tree = world.node_tree
    nodes, links = tree.nodes, tree.links
    where = nodes.new("ShaderNodeTexCoord")
    dot = nodes.new("ShaderNodeVectorMath")
    dot.operation = "DOT_PRODUCT"
    links.new(where.outputs["Generated"], dot.inputs[0])
    edge = nodes.new("ShaderNodeMapRange")
    edge.interpolation_type = "SMOOTHSTEP"
    cosine = math.cos(half_angle_rad)
    edge.inputs["From Min"].default_value, edge.inputs["From Max"].default_value = cosine - 0.02, cosine + 0.02
    links.new(dot.outputs["Value"], edge.inputs["Value"])
    clouds = nodes.new("ShaderNodeTexNoise")
    clouds.inputs["Scale"].default_value, clouds.inputs["Detail"].default_value = 3.5, 5.0
    links.new(where.outputs["Generated"], clouds.inputs["Vector"])
    ramp = nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[0].color = 0.42, (0.28, 0.42, 0.72, 1)
    ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.66, (1.7, 1.75, 1.8, 1)
    links.new(clouds.outputs["Fac"], ramp.inputs["Fac"])
    strength = nodes.new("ShaderNodeMath")
    strength.operation = "MULTIPLY"
    strength.inputs[1].default_value = radiance
    links.new(edge.outputs["Result"], strength.inputs[0])
    background = nodes["Background"]
    links.new(ramp.outputs["Color"], background.inputs["Color"])
    links.new(strength.outputs["Value"], background.inputs["Strength"])
    return dot


def aim_earthshine(node, direction_C):
    """Lets the Earthshine come from around direction_C."""
    d = np.asarray(direction_C, dtype=float)
    new = Vector(d / np.linalg.norm(d))
    # Any write to the world makes Cycles rebuild its importance map, at more than a second a frame.
    if (Vector(node.inputs[1].default_value) - new).length > 1e-6:
        node.inputs[1].default_value = new


def render_window(f_px, cu, cv, window, seed, scratch_path, samples=None, shared=False):
    """Linear RGBA (h, w, 4), row 0 at the top, of an ideal square-pixel camera's window (x0, y0, w, h).

    Alpha is premultiplied. Only the window is rendered: its camera has its own size and a shifted axis, which leaves
    no rounding of a crop's edges to chance. @param samples  a pixel; None: as the scene is set. @param shared  each pixel
    is the plain mean over its square, for camera.share_samples to take it to the usual filter's width.
    """
    x0, y0, width, height = window
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    data = scene.camera.data
    data.lens = f_px * data.sensor_width / width
    # Blender counts pixel centres from one half; a positive shift moves the picture left and down.
    data.shift_x = (width / 2 - 0.5 - (cu - x0)) / width
    data.shift_y = ((cv - y0) - (height / 2 - 0.5)) / width
    scene.cycles.seed = seed & 0x7FFFFFFF
    if samples is not None:
        scene.cycles.samples = samples
    scene.cycles.pixel_filter_type = "BOX" if shared else PIXEL_FILTER
    scene.render.filepath = scratch_path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scratch_path)
    image.colorspace_settings.name = "Non-Color"
    out = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(out)
    bpy.data.images.remove(image)
    os.remove(scratch_path)
    return out.reshape(height, width, 4)[::-1]


def add_ambient(radiance):
    """Even white light from all around."""
    world = bpy.data.worlds.new("ambient")
    bpy.context.scene.world = world
    world.use_nodes = True
    world.cycles.sampling_method = "NONE"
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = radiance


def add_lamp(root, place_m, width_m, strength):
    """Disc lamp under root at place_m (3,), shining along root's -z; strength is the irradiance at root's origin
    height below it in units of the sun's."""
    light = bpy.data.lights.new("lamp", "AREA")
    light.shape, light.size = "DISK", width_m
    # Irradiance below a small lamp is power / (pi d^2); the sun's unit is pi.
    light.energy = math.pi**2 * strength * float(place_m[2]) ** 2
    lamp = bpy.data.objects.new("lamp", light)
    lamp.location = [float(x) for x in place_m]
    lamp.parent = root
    bpy.context.scene.collection.objects.link(lamp)


def child_named(root, name):
    """The child of root whose name starts with name."""
    return next(thing for thing in root.children if thing.name.startswith(name))


def show_target_only(room, table):
    """The room is gone but for its lamps and the table, which gives the target its bounced light and isn't seen."""
    for thing in room.children:
        if thing.type == "MESH" and thing is not table:
            thing.hide_render = True
    table.visible_camera = False


@contextlib.contextmanager
def room_only(room, table, samples):
    """Within: the room alone is seen. After: the target alone."""
    scene = bpy.context.scene
    target = bpy.data.objects["target"]
    usual = scene.cycles.samples, scene.cycles.use_adaptive_sampling
    for thing in room.children:
        thing.hide_render = False
    table.visible_camera = True
    for thing in target.children:
        thing.hide_render = True
    scene.cycles.samples, scene.cycles.use_adaptive_sampling = samples, True
    try:
        yield
    finally:
        scene.cycles.samples, scene.cycles.use_adaptive_sampling = usual
        for thing in target.children:
            thing.hide_render = False
        show_target_only(room, table)


@contextlib.contextmanager
def table_only(table, matt, samples, shadowed):
    """Within: the table alone is seen, of the material matt, with the target's shadow if shadowed. After: the target.

    Every pixel gets the same random numbers whether the target is there or not, if the seed is the same.
    """
    cycles = bpy.context.scene.cycles
    target = bpy.data.objects["target"]
    usual, own = (cycles.samples, cycles.use_adaptive_sampling), table.data.materials[0]
    cycles.samples, cycles.use_adaptive_sampling = samples, False
    table.data.materials[0], table.visible_camera = matt, True
    for thing in target.children:
        thing.visible_camera, thing.hide_render = False, not shadowed
    try:
        yield
    finally:
        cycles.samples, cycles.use_adaptive_sampling = usual
        table.data.materials[0], table.visible_camera = own, False
        for thing in target.children:
            thing.visible_camera, thing.hide_render = True, False
