"""A picture of one object from eight sides: rulers in the mesh's own unit, the grasp region in red."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from .families import ObjectShape
from .gl import load_mujoco
from .render import _add_mesh, _quaternion
from .user_mesh import ObjectFile

TILE_PX = 400
MARGIN_PX = 34
BODY_RGBA, REGION_RGBA = (0.72, 0.74, 0.78, 1), (0.9, 0.16, 0.2, 1)
# Name, direction to the right, direction up; the viewer stands where their cross product points.
SIDES = (
    ("from +x", (0, 1, 0), (0, 0, 1)),
    ("from +y", (-1, 0, 0), (0, 0, 1)),
    ("from +z", (1, 0, 0), (0, 1, 0)),
    ("oblique", (-0.64, 0.77, 0), (-0.39, -0.32, 0.87)),
    ("from -x", (0, -1, 0), (0, 0, 1)),
    ("from -y", (1, 0, 0), (0, 0, 1)),
    ("from -z", (-1, 0, 0), (0, 1, 0)),
    ("oblique", (0.64, -0.77, 0), (0.39, 0.32, 0.87)),
)


def write_picture(said: ObjectFile, shape: ObjectShape, file: Path) -> None:
    """Write the picture as a PNG.

    Args:
        said: what the object file says: the rulers count in the unit and axes of its mesh.
        shape: the object that it describes.
        file: where to write.
    """
    tiles = [_with_rulers(*view, said.unit_m) for view in _views(said, shape)]
    half = len(tiles) // 2
    rows = [np.hstack(tiles[:half]), np.hstack(tiles[half:])]
    Image.fromarray(np.vstack(rows)).save(file, format="PNG")


def _views(said, shape):
    """(name, right, up, middle_m, metres a pixel, picture) of each side, orthographic."""
    mujoco = load_mujoco()

    mesh = replace(shape.mesh, vertices_m=said.to_mesh(shape.mesh.vertices_m) * said.unit_m)
    vertices_m = mesh.vertices_m
    middle = (vertices_m.min(axis=0) + vertices_m.max(axis=0)) / 2
    extent = (
        2 * np.linalg.norm(vertices_m - middle, axis=1).max() * 0.5 + 0.5 * np.ptp(vertices_m, axis=0).max()
    )
    inner_px = TILE_PX - 2 * MARGIN_PX
    metres_per_px = extent / inner_px
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth = spec.visual.global_.offheight = 2 * TILE_PX
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.35] * 3, [0.6] * 3
    spec.visual.headlight.specular = [0.1] * 3
    spec.visual.map.znear, spec.visual.map.zfar = 0.1, 10
    spec.stat.extent, spec.stat.center = extent, [0, 0, 0]
    texture = spec.add_texture(
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT, width=8, height=8
    )
    texture.rgb1 = texture.rgb2 = [1, 1, 1]
    for name, faces, rgba in (
        ("rest", ~mesh.region, BODY_RGBA),
        ("region", mesh.region, REGION_RGBA),
    ):
        _add_mesh(mujoco, spec, name, mesh, faces, shaded=True)
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, rgba=rgba, pos=-middle, contype=0, conaffinity=0
        )
    for index, (_, right, up) in enumerate(SIDES):
        axes = np.stack([right, up, np.cross(right, up)], axis=1).astype(float)
        axes /= np.linalg.norm(axes, axis=0)
        spec.worldbody.add_camera(
            name=f"side{index}",
            pos=axes[:, 2] * 2 * extent,
            quat=_quaternion(mujoco, axes),
            proj=mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC,
            fovy=TILE_PX * metres_per_px,
        )
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    gl = mujoco.GLContext(64, 64)
    gl.make_current()
    try:
        context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
        for index, (name, right, up) in enumerate(SIDES):
            pixels = _draw(mujoco, model, data, context, index)
            picture = Image.fromarray(pixels).resize((TILE_PX, TILE_PX), Image.Resampling.BOX)
            yield name, np.array(right), np.array(up), middle, metres_per_px, picture
        context.free()
    finally:
        gl.free()


def _draw(mujoco, model, data, context, camera_index):
    """(2 TILE_PX, 2 TILE_PX, 3) uint8 what a camera of the model sees."""
    camera, view = mujoco.MjvCamera(), mujoco.MjvScene(model, maxgeom=8)
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, camera_index
    everything = mujoco.mjtCatBit.mjCAT_ALL.value
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, camera, everything, view)
    rect = mujoco.MjrRect(0, 0, 2 * TILE_PX, 2 * TILE_PX)
    pixels = np.empty((rect.height, rect.width, 3), np.uint8)
    mujoco.mjr_render(rect, view, context)
    mujoco.mjr_readPixels(pixels, None, rect, context)
    return np.flipud(pixels)


def _with_rulers(name, right, up, middle_m, metres_per_px, picture, unit_m):
    draw = ImageDraw.Draw(picture)
    draw.text((6, 4), name, fill=(0, 0, 0))
    draw.rectangle([0, 0, TILE_PX - 1, TILE_PX - 1], outline=(190, 190, 190))
    if name != "oblique":
        for horizontal, direction in ((True, right), (False, up)):
            axis = int(np.abs(direction).argmax())
            _ruler(draw, horizontal, "xyz"[axis], direction[axis], middle_m[axis], metres_per_px, unit_m)
    return np.asarray(picture)


def _ruler(draw, horizontal, letter, sign, middle_m, metres_per_px, unit_m):
    """Ticks along the lower or the left side."""
    reach = (TILE_PX / 2 - MARGIN_PX) * metres_per_px / unit_m
    middle = middle_m / unit_m
    step = 10.0 ** np.floor(np.log10(reach / 2))
    step *= next(factor for factor in (1, 2, 5, 10) if reach / (step * factor) <= 3.5)
    far = TILE_PX - 22
    for count in range(int(np.ceil((middle - reach) / step)), int(np.floor((middle + reach) / step)) + 1):
        offset_px = sign * (count * step - middle) * unit_m / metres_per_px
        label = f"{count * step:.6g}"
        if horizontal:
            at = TILE_PX / 2 + offset_px
            draw.line([at, far, at, far + 5], fill=(0, 0, 0))
            draw.line([at, MARGIN_PX, at, far], fill=(225, 225, 225) if count else (180, 180, 180))
            draw.text((at, far + 6), label, fill=(0, 0, 0), anchor="ma")
        else:
            at = TILE_PX / 2 - offset_px
            draw.line([30, at, 35, at], fill=(0, 0, 0))
            draw.line([35, at, TILE_PX - MARGIN_PX, at], fill=(225, 225, 225) if count else (180, 180, 180))
            draw.text((29, at), label, fill=(0, 0, 0), anchor="rm")
    if horizontal:
        draw.text((TILE_PX - 12, far + 6), letter, fill=(200, 0, 0), anchor="ra")
    else:
        draw.text((6, 18), letter, fill=(200, 0, 0))
