"""Render a drawn scene with MuJoCo: colour, and the truth: instances, grasp regions, depth."""

from dataclasses import dataclass

import numpy as np

from .gl import load_mujoco
from .mesh import Mesh, corner_normals
from .placing import PlacedObject
from .scene import Scene
from .sensor import exposure_factor, photograph
from .surfaces import surface_texture
from .textures import object_texture

_COLOUR, _TRUTH, _ROOM, _ALONE = 0, 1, 2, 3
"""Geom groups: what the picture, the truth, both, and the truth of a single object are made of."""
_SUPERSAMPLING = 1.5


@dataclass(frozen=True)
class View:
    """One rendered view, (H, W) each.

    Attributes:
        colour: (H, W, 3) uint8 RGB.
        instances: uint8, object id, 0 for the background.
        region: bool, visible grasp region.
        depth_m: float64, Z along the optical axis; the far plane where nothing is.
        unhidden_px: for each object id the number of pixels it would cover if it stood there alone.
    """

    colour: np.ndarray
    instances: np.ndarray
    region: np.ndarray
    depth_m: np.ndarray
    unhidden_px: dict[int, int]


class Renderer:
    """Holds the graphics context; renders any number of scenes."""

    def __init__(self) -> None:
        self._mujoco = mujoco = load_mujoco()
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
            light, truths = zip(*(drawer.draw(scene, side) for side in (0, 1)))
        finally:
            context.free()
        rng = np.random.default_rng(np.random.SeedSequence([scene.seed, scene.index, 1]))
        exposure = exposure_factor(light[0][::8, ::8], scene.sensor.brightness)
        left, right = (
            View(photograph(light[side], scene.camera.image_size, scene.sensor, factor, rng), *truths[side])
            for side, factor in enumerate((exposure, exposure * scene.sensor.exposure_ratio))
        )
        return left, right


class _Drawer:
    """Draws the two cameras of one compiled model."""

    def __init__(self, mujoco, model, data, context, owners):
        self.mujoco, self.model, self.data, self.context, self.owners = mujoco, model, data, context, owners
        self.view = mujoco.MjvScene(model, maxgeom=200)

    def draw(self, scene: Scene, side: int):
        """One camera: the light on a finer grid than the image's, and the truth, in the order of View."""
        mujoco = self.mujoco
        width, height = scene.camera.image_size
        self._select(scene, side, _COLOUR, _ROOM)
        fine = mujoco.MjrRect(0, 0, *_fine_size(scene))
        light = np.empty((fine.height, fine.width, 3), np.uint8)
        mujoco.mjr_render(fine, self.view, self.context)
        mujoco.mjr_readPixels(light, None, fine, self.context)

        flags = self.view.flags
        flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = True
        self._select(scene, side, _TRUTH, _ROOM)
        depth = np.empty((height, width), np.float32)
        ids, instance_of, region_of = self._truth(width, height, depth)
        instances, region = instance_of[ids], region_of[ids]
        unhidden_px = {}
        for placed in scene.objects:
            unhidden_px[placed.id] = (
                int(np.count_nonzero(instances == placed.id))
                if len(scene.objects) == 1
                else self._alone_px(scene, side, placed.id)
            )
        flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = False
        return np.flipud(light), (instances, region, self._metres(np.flipud(depth)), unhidden_px)

    def _truth(self, width, height, depth=None):
        """(H, W) numbers of what is selected; for each number the object's id, and whether it is region."""
        mujoco = self.mujoco
        rect, code = mujoco.MjrRect(0, 0, width, height), np.empty((height, width, 3), np.uint8)
        mujoco.mjr_render(rect, self.view, self.context)
        mujoco.mjr_readPixels(code, depth, rect, self.context)
        instance_of, region_of = np.zeros(257, np.uint8), np.zeros(257, bool)
        for geom in self.view.geoms[: self.view.ngeom]:
            owner, region = self.owners.get(geom.objid, (0, False))
            instance_of[geom.segid + 1], region_of[geom.segid + 1] = owner, region
        return np.flipud(code[..., 0]), instance_of, region_of  # under 255 geoms: one byte is the number

    def _alone_px(self, scene, side, object_id):
        own = [geom for geom, (owner, _) in self.owners.items() if owner == object_id]
        self.model.geom_group[own] = _ALONE
        self._select(scene, side, _ALONE, _ROOM)  # the table hides what it touches
        self.model.geom_group[own] = _TRUTH
        ids, instance_of, _ = self._truth(*scene.camera.image_size)
        return int(np.count_nonzero(instance_of[ids]))

    def _select(self, scene, side, *groups):
        mujoco = self.mujoco
        camera, option = mujoco.MjvCamera(), mujoco.MjvOption()
        camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, side
        option.geomgroup[:] = 0
        option.geomgroup[list(groups)] = 1
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self.model, self.data, option, None, camera, everything, self.view)
        if side == 1:
            # Lower in the picture is a window that is shifted up.
            for eye in self.view.camera:
                shift = scene.sensor.vertical_offset_px / scene.camera.focal_px * eye.frustum_near
                eye.frustum_bottom += shift
                eye.frustum_top += shift

    def _metres(self, buffer):
        near = self.model.vis.map.znear * self.model.stat.extent
        far = self.model.vis.map.zfar * self.model.stat.extent
        # Reversed depth: 1 at the near plane, 0 at the far one.
        return near * far / (near + buffer.astype(np.float64) * (far - near))


def _fine_size(scene):
    """(width, height) of the grid that colour is rendered on."""
    return tuple(round(_SUPERSAMPLING * size) for size in scene.camera.image_size)


def _build_model(mujoco, scene: Scene):
    """The compiled scene, and {geom id: (object id, is grasp region)} of the geoms that carry the truth."""
    spec = mujoco.MjSpec()
    visual = spec.visual
    visual.global_.offwidth, visual.global_.offheight = _fine_size(scene)
    visual.quality.offsamples, visual.quality.shadowsize = 0, 2048
    visual.map.znear, visual.map.zfar = 0.15, 12.0
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
    """Table, floor and walls."""
    table, background = scene.table, scene.background
    plane = {
        "type": mujoco.mjtGeom.mjGEOM_PLANE,
        "contype": 0,
        "conaffinity": 0,
        "group": _ROOM,
    }
    repeat = 1 / table.texture_size_m
    pixels = surface_texture(table.texture_seed, table.texture)
    _add_texture(mujoco, spec, "table", pixels, texrepeat=[repeat, repeat], texuniform=True, specular=0.05)
    world = spec.worldbody
    world.add_geom(
        size=[*table.half_size_m, 0.1],
        quat=[np.cos(table.turn_rad / 2), 0, 0, np.sin(table.turn_rad / 2)],
        material="table",
        **plane,
    )
    for name, seed in zip(("floor", "wall"), background.texture_seeds):
        close = name == "wall" and background.kind == "wall"
        pixels = surface_texture(seed, background.texture, 512 if close else 256)
        repeat = 1.0 if close else 0.6
        _add_texture(mujoco, spec, name, pixels, texrepeat=[repeat, repeat], texuniform=True, specular=0.0)
    size = [7.0, 7.0, 0.1]
    world.add_geom(size=size, pos=[0, 0, -background.floor_m], material="floor", **plane)
    for angle, distance in background.walls:
        inward = -np.array([np.cos(angle), np.sin(angle), 0])
        rotation = np.stack([np.cross([0, 0, 1], inward), [0, 0, 1], inward], axis=1)
        world.add_geom(
            size=size,
            pos=-inward * distance,
            quat=_quaternion(mujoco, rotation),
            material="wall",
            **plane,
        )


def _add_mesh(mujoco, spec, name, mesh: Mesh, faces_kept, *, shaded: bool):
    faces = mesh.faces[faces_kept]
    # MuJoCo takes numbers one by one: from lists it takes half the time of arrays.
    added = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    if not shaded:
        used, local = np.unique(faces, return_inverse=True)
        added.uservert = mesh.vertices_m[used].astype(np.float32).reshape(-1).tolist()
        added.userface = local.reshape(-1).tolist()
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
    added.uservert = corners[:, :3].reshape(-1).tolist()
    added.usernormal = corners[:, 3:6].reshape(-1).tolist()
    added.usertexcoord = corners[:, 6:].reshape(-1).tolist()
    added.userface = list(range(len(corners)))


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
