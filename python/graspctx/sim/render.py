"""Render a drawn scene with MuJoCo: colour, and the truth: instances, grasp regions, depth."""

import os
import subprocess
import sys
from dataclasses import dataclass

import numpy as np

from .mesh import Mesh, corner_normals
from .scene import PlacedObject, Scene
from .splits import split_number
from .textures import object_texture, surface_texture

_COLOUR, _TRUTH, _ROOM = 0, 1, 2  # geom groups: what the picture, the truth, and both are made of
_SUPERSAMPLING = 2


def choose_gl() -> str:
    """Set MUJOCO_GL, unless it is set: EGL where a context can be made, else OSMesa.

    Must come before `import mujoco`. A trial process decides: a failed attempt cannot be undone in this one.
    """
    if "MUJOCO_GL" not in os.environ and "mujoco" not in sys.modules and sys.platform.startswith("linux"):
        trial = "import mujoco; context = mujoco.GLContext(8, 8); context.make_current(); context.free()"
        works = subprocess.run(
            [sys.executable, "-c", trial],
            env={**os.environ, "MUJOCO_GL": "egl"},
            capture_output=True,
            check=False,
        )
        os.environ["MUJOCO_GL"] = "egl" if works.returncode == 0 else "osmesa"
    return os.environ.get("MUJOCO_GL", "")


@dataclass(frozen=True)
class View:
    """One rendered view, (H, W) each.

    Attributes:
        colour: (H, W, 3) uint8 RGB.
        instances: uint8, object id, 0 for the background.
        region: bool, visible grasp region.
        depth_m: float64, Z along the optical axis; the far plane where nothing is.
    """

    colour: np.ndarray
    instances: np.ndarray
    region: np.ndarray
    depth_m: np.ndarray


class Renderer:
    """Holds the graphics context; renders any number of scenes."""

    def __init__(self) -> None:
        choose_gl()
        import mujoco

        self._mujoco = mujoco
        self._gl = mujoco.GLContext(64, 64)
        self._gl.make_current()

    def close(self) -> None:
        """Free the graphics context."""
        self._gl.free()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def render(self, scene: Scene) -> tuple[View, View]:
        """The (left, right) views of a scene."""
        mujoco = self._mujoco
        model, owners = _build_model(mujoco, scene)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        try:
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
            context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
            drawer = _Drawer(mujoco, model, data, context, owners)
            entropy = [scene.seed, scene.index, split_number(scene.split), 1]
            sensor_rng = np.random.default_rng(np.random.SeedSequence(entropy))
            (left_colour, left), (right_colour, right) = (drawer.draw(scene, side) for side in (0, 1))
            exposure = _exposure(left_colour[::8, ::8], scene.sensor.brightness)
        finally:
            context.free()
        return (
            View(_sensor(left_colour, scene.sensor, exposure * scene.sensor.gain[0], sensor_rng), *left),
            View(_sensor(right_colour, scene.sensor, exposure * scene.sensor.gain[1], sensor_rng), *right),
        )


class _Drawer:
    """Draws the two cameras of one compiled model."""

    def __init__(self, mujoco, model, data, context, owners):
        self.mujoco, self.model, self.data, self.context, self.owners = mujoco, model, data, context, owners
        self.view = mujoco.MjvScene(model, maxgeom=200)

    def draw(self, scene: Scene, side: int):
        """One camera: the supersampled colour (2H, 2W, 3), and (instances, region, depth_m) as in View."""
        mujoco = self.mujoco
        width, height = scene.camera.image_size
        self._select(side, _COLOUR)
        big = mujoco.MjrRect(0, 0, width * _SUPERSAMPLING, height * _SUPERSAMPLING)
        colour = np.empty((big.height, big.width, 3), np.uint8)
        mujoco.mjr_render(big, self.view, self.context)
        mujoco.mjr_readPixels(colour, None, big, self.context)

        self._select(side, _TRUTH)
        flags = self.view.flags
        flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = True
        rect = mujoco.MjrRect(0, 0, width, height)
        code, depth = np.empty((height, width, 3), np.uint8), np.empty((height, width), np.float32)
        mujoco.mjr_render(rect, self.view, self.context)
        mujoco.mjr_readPixels(code, depth, rect, self.context)
        flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = False

        instance_of, region_of = np.zeros(257, np.uint8), np.zeros(257, bool)
        for geom in self.view.geoms[: self.view.ngeom]:
            owner, region = self.owners.get(geom.objid, (0, False))
            instance_of[geom.segid + 1], region_of[geom.segid + 1] = owner, region
        ids = np.flipud(code[..., 0])  # fewer than 255 geoms: the first byte is the number
        return np.flipud(colour), (instance_of[ids], region_of[ids], self._metres(np.flipud(depth)))

    def _select(self, side, group):
        mujoco = self.mujoco
        camera, option = mujoco.MjvCamera(), mujoco.MjvOption()
        camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, side
        option.geomgroup[:] = 0
        option.geomgroup[[group, _ROOM]] = 1
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self.model, self.data, option, None, camera, everything, self.view)

    def _metres(self, buffer):
        near = self.model.vis.map.znear * self.model.stat.extent
        far = self.model.vis.map.zfar * self.model.stat.extent
        # Reversed depth: 1 at the near plane, 0 at the far one.
        return near * far / (near + buffer.astype(np.float64) * (far - near))


def _exposure(colour: np.ndarray, brightness: float) -> float:
    """The factor that brings the mean to `brightness`, within reason, without burning out highlights."""
    highlights = max(float(np.quantile(colour, 0.995)), 1.0)
    return float(
        np.clip(brightness / max(float(colour.mean()), 1.0), 0.8, min(2.0, max(0.8, 245 / highlights)))
    )


def _sensor(big: np.ndarray, sensor, gain: float, rng) -> np.ndarray:
    """Average the samples of each pixel, then gain, blur and noise. (2H, 2W, 3) to (H, W, 3) uint8."""
    summed = big[0::2, 0::2].astype(np.float32)
    for row, column in ((0, 1), (1, 0), (1, 1)):
        summed += big[row::2, column::2]
    image = summed * np.float32(gain / 4)
    if sensor.blur_px > 0.1:
        tail = np.exp(-0.5 / sensor.blur_px**2)
        centre, tail = np.float32(1 / (1 + 2 * tail)), np.float32(tail / (1 + 2 * tail))
        for _ in range(2):
            padded = np.pad(image, ((1, 1), (0, 0), (0, 0)), mode="edge")
            image = (centre * image + tail * (padded[:-2] + padded[2:])).swapaxes(0, 1)
    image = image + rng.standard_normal(image.shape, dtype=np.float32) * np.float32(sensor.noise)
    return np.clip(image + 0.5, 0, 255).astype(np.uint8)


def _build_model(mujoco, scene: Scene):
    """The compiled scene, and {geom id: (object id, is grasp region)} of the geoms that carry the truth."""
    spec = mujoco.MjSpec()
    width, height = scene.camera.image_size
    visual = spec.visual
    visual.global_.offwidth, visual.global_.offheight = width * _SUPERSAMPLING, height * _SUPERSAMPLING
    visual.quality.offsamples, visual.quality.shadowsize = 0, 2048
    visual.map.znear, visual.map.zfar = 0.15, 8.0
    visual.headlight.ambient = [scene.ambient] * 3
    visual.headlight.diffuse = visual.headlight.specular = [0, 0, 0]
    spec.stat.extent = 1.0
    spec.stat.center = [0, 0, 0]

    _add_cameras(mujoco, spec, scene)
    _add_lights(mujoco, spec, scene)
    _add_room(mujoco, spec, scene)
    names = {}
    for placed in scene.objects:
        names.update(_add_object(mujoco, spec, placed))
    model = spec.compile()
    return model, {model.geom(name).id: truth for name, truth in names.items()}


def _quaternion(mujoco, rotation) -> np.ndarray:
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation, float).reshape(9))
    return quaternion


def _add_cameras(mujoco, spec, scene):
    table_from_cam = np.linalg.inv(scene.cam_from_table)
    height = scene.camera.image_size[1]
    for name, offset_m in (("left", 0.0), ("right", scene.camera.baseline_m)):
        spec.worldbody.add_camera(
            name=name,
            pos=table_from_cam[:3, 3] + offset_m * table_from_cam[:3, 0],
            # MuJoCo's cameras look along -z with y up.
            quat=_quaternion(mujoco, table_from_cam[:3, :3] * [1, -1, -1]),
            fovy=np.degrees(2 * np.arctan(height / 2 / scene.camera.focal_px)),
        )


def _add_lights(mujoco, spec, scene):
    for light in scene.lights:
        spec.worldbody.add_light(
            pos=light.position_m,
            dir=-light.position_m / np.linalg.norm(light.position_m),
            type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
            diffuse=light.strength,
            specular=light.strength * 0.8,
            castshadow=light.casts_shadow,
        )
    # Tighter shadow maps, and those of spot lights, stripe the table with its own shadow far from the middle.
    spec.visual.map.shadowclip = 1.2


def _add_texture(mujoco, spec, name, pixels, **material):
    texture = spec.add_texture(
        name=name,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        width=pixels.shape[1],
        height=pixels.shape[0],
        nchannel=3,
    )
    texture.data = pixels.tobytes()
    material = spec.add_material(name=name, **material)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name


def _add_room(mujoco, spec, scene):
    """Table, floor and four walls."""
    world = spec.worldbody
    geom = mujoco.mjtGeom
    common = {"contype": 0, "conaffinity": 0, "group": _ROOM}
    repeat = 1 / scene.table_texture_size_m
    _add_texture(
        mujoco,
        spec,
        "table",
        surface_texture(scene.table_texture_seed, scene.table_texture),
        texrepeat=[repeat, repeat],
        texuniform=True,
        specular=0.05,
    )
    half = np.array(scene.table_half_size_m)
    turn = scene.table_turn_rad
    world.add_geom(
        type=geom.mjGEOM_PLANE,
        size=[*half, 0.1],
        pos=[0, 0, 0],
        quat=[np.cos(turn / 2), 0, 0, np.sin(turn / 2)],
        material="table",
        **common,
    )
    distance, table_height = scene.room_m
    for name, seed in zip(("floor", "wall"), scene.surface_seeds):
        pixels = surface_texture(seed, "textured", 256)
        _add_texture(mujoco, spec, name, pixels, texrepeat=[0.6, 0.6], texuniform=True, specular=0.0)
    size = [4.0, 4.0, 0.1]
    world.add_geom(type=geom.mjGEOM_PLANE, size=size, pos=[0, 0, -table_height], material="floor", **common)
    for side in range(4):
        angle = turn + side * np.pi / 2
        inward = -np.array([np.cos(angle), np.sin(angle), 0])
        rotation = np.stack([np.cross([0, 0, 1], inward), [0, 0, 1], inward], axis=1)
        world.add_geom(
            type=geom.mjGEOM_PLANE,
            size=size,
            pos=-inward * distance,
            quat=_quaternion(mujoco, rotation),
            material="wall",
            **common,
        )


def _add_mesh(mujoco, spec, name, mesh: Mesh, faces_kept, *, shaded: bool):
    faces = mesh.faces[faces_kept]
    added = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    if not shaded:
        used, local = np.unique(faces, return_inverse=True)
        added.uservert = mesh.vertices_m[used].astype(np.float32).reshape(-1)
        added.userface = local.reshape(-1).astype(np.int32)
        return
    # One vertex for each corner: MuJoCo 4.0 overwrites separate indices of given normals.
    corners = np.concatenate(
        [
            mesh.vertices_m[faces].reshape(-1, 3),
            corner_normals(mesh.vertices_m, faces).reshape(-1, 3),
            mesh.uv[faces_kept].reshape(-1, 2),
        ],
        axis=1,
    ).astype(np.float32)
    added.uservert = corners[:, :3].reshape(-1)
    added.usernormal = corners[:, 3:6].reshape(-1)
    added.usertexcoord = corners[:, 6:].reshape(-1)
    added.userface = np.arange(len(corners), dtype=np.int32)


def _add_object(mujoco, spec, placed: PlacedObject):
    """One textured mesh for the picture; the same mesh cut along the region's border for the truth."""
    mesh, pose = placed.shape.mesh, placed.table_from_object
    name = f"object{placed.id}"
    _add_texture(
        mujoco,
        spec,
        name,
        object_texture(placed.shape, placed.texture_seed),
        specular=placed.gloss,
        shininess=0.2 + 0.6 * placed.gloss,
    )
    pieces = {
        name: (_COLOUR, np.ones(len(mesh.faces), bool)),
        name + "_region": (_TRUTH, mesh.region),
        name + "_rest": (_TRUTH, ~mesh.region),
    }
    for piece, (group, kept) in pieces.items():
        _add_mesh(mujoco, spec, piece, mesh, kept, shaded=group == _COLOUR)
        spec.worldbody.add_geom(
            name=piece,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=piece,
            material=name if group == _COLOUR else "",
            pos=pose[:3, 3],
            quat=_quaternion(mujoco, pose[:3, :3]),
            group=group,
            contype=0,
            conaffinity=0,
        )
    return {name + "_region": (placed.id, True), name + "_rest": (placed.id, False)}
