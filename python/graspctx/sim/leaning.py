"""Lean an object on another one: put it up at a slant, and let physics settle it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .geometry import surface_points
from .gl import load_mujoco

if TYPE_CHECKING:
    from .placing import PlacedObject

TRIES = 4
LONGEST_S, STEP_S = 2.0, 0.002
AT_REST = (0.002, 0.02)  # m/s, rad/s
DEEPEST_M = 0.0005  # of one body in another
FLATTEST_M = 2e-5  # pieces thinner than this have no hull
LOWEST_SUPPORT_M = 0.015  # lying with one end on a glass's foot is not leaning
LEAST_SHARE_CARRIED = 0.03  # of the weight, by what it leans on


def lean(rng, item: PlacedObject, prop: PlacedObject, others: list[PlacedObject]) -> np.ndarray | None:
    """Where an object comes to rest that leans on another one.

    Only the leaning object moves. At the end it is at rest, stands on the table, is carried in part by the
    prop, touches nothing else, and is nowhere deeper than half a millimetre in anything.

    Args:
        rng: of the slant, and of the side of the prop.
        item: the object; its pose does not matter.
        prop: what it leans on.
        others: what stands in the way.

    Returns:
        (4, 4) table_from_object, or None if it slips, falls or does not reach.
    """
    from scipy.spatial import cKDTree

    mujoco = load_mujoco()
    model = _build_model(mujoco, item, prop, others)
    data = mujoco.MjData(model)
    surface = surface_points(item.shape.mesh, 2500)
    carrier = surface_points(prop.shape.mesh, 5000)
    carrier = carrier @ prop.table_from_object[:3, :3].T + prop.table_from_object[:3, 3]
    tree = cKDTree(carrier)
    for _ in range(TRIES):
        heading = rng.uniform(0, 2 * np.pi)
        rotation = _slanted(rng, item, heading)
        points = surface @ rotation.T
        start = _push_against(rng, points, heading, carrier, tree)
        if start is None:
            continue
        mujoco.mj_resetData(model, data)
        data.qpos[:3] = start
        mujoco.mju_mat2Quat(data.qpos[3:7], np.ascontiguousarray(rotation).reshape(9))
        if _settles(mujoco, model, data) and _leans(mujoco, model, data):
            return _pose(mujoco, data, item)
    return None


def _slanted(rng, item, heading_rad):
    """(3, 3) table_from_object: the object's long axis up, slanted in the direction it leans in."""
    size = np.ptp(item.shape.mesh.vertices_m, axis=0)
    standing = any(pose.name == "standing" for pose in item.shape.resting_poses)
    upright = 2 if standing and size[2] > 0.6 * size.max() else int(size.argmax())
    along = np.zeros(3)
    along[upright] = 1 if standing or rng.random() < 0.5 else -1
    side = np.eye(3)[(upright + 1) % 3]
    object_axes = np.stack([along, side, np.cross(along, side)], axis=1)
    slant, spin = rng.uniform(np.radians(15), np.radians(55)), rng.uniform(0, 2 * np.pi)
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    up = np.array([np.sin(slant) * c, np.sin(slant) * s, np.cos(slant)])
    across = np.array([-s, c, 0.0])
    if size[np.arange(3) != upright].max() > 2.5 * size[np.arange(3) != upright].min():
        # Flat things lean on their flat sides.
        flat = int(np.argsort(size)[0])
        spin = 0.0 if flat == (upright + 2) % 3 else np.pi / 2
        spin += np.pi * rng.integers(2) + rng.normal(0, 0.1)
    c, s = np.cos(spin), np.sin(spin)
    second = c * across + s * np.cross(up, across)
    table_axes = np.stack([up, second, np.cross(up, second)], axis=1)
    return table_axes @ object_axes.T


def _push_against(rng, points_m, heading_rad, carrier_m, tree):
    """(3,) where the slanted object, points about its origin, nearly touches the prop; None if it misses."""
    ahead = np.array([np.cos(heading_rad), np.sin(heading_rad), 0.0])
    across = np.array([-ahead[1], ahead[0], 0.0])
    width = np.ptp(carrier_m @ across)
    middle = (carrier_m.min(axis=0) + carrier_m.max(axis=0)) / 2
    top = points_m[points_m[:, 2].argmax()]  # this end has to meet the prop
    sideways = (middle - top) @ across + rng.uniform(-0.25, 0.25) * width
    back = (carrier_m @ ahead).min() - (points_m @ ahead).max() - 0.01
    at = ahead * back + across * sideways
    at[2] = 0.0003 - points_m[:, 2].min()
    for _ in range(60):
        gap = tree.query(points_m + at)[0].min()
        if gap < 0.003:
            return at
        at = at + ahead * (gap - 0.0015)
        if (points_m @ ahead).min() + at @ ahead > (carrier_m @ ahead).max():
            return None
    return None


def _build_model(mujoco, item, prop, others):
    spec = mujoco.MjSpec()
    option = spec.option
    option.timestep = STEP_S
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio, option.noslip_iterations = 10, 4
    contact = {"friction": [1.0, 0.01, 0.0005], "solref": [0.005, 1], "solimp": [0.98, 0.998, 0.0005, 0.5, 2]}
    hull = {"type": mujoco.mjtGeom.mjGEOM_MESH, "condim": 4, **contact}
    world = spec.worldbody
    world.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], condim=4, **contact)
    for k, other in enumerate([prop, *others]):
        name = "prop" if k == 0 else f"other{k}"
        body = world.add_body(name=name, pos=other.table_from_object[:3, 3])
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(other.table_from_object[:3, :3]).reshape(9))
        body.quat = quaternion
        _add_solids(mujoco, spec, body, other.shape, name, hull)
    body = world.add_body(name="leaning")
    body.add_freejoint()
    _add_solids(mujoco, spec, body, item.shape, "leaning", {**hull, "density": 600})
    return spec.compile()


def _add_solids(mujoco, spec, body, shape, name, hull):
    for k, corners in enumerate(shape.solids_m or (shape.mesh.vertices_m,)):
        if np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)[-1] < FLATTEST_M:
            continue
        mesh = spec.add_mesh(name=f"{name}{k}", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
        mesh.uservert = np.asarray(corners, np.float32).reshape(-1)
        body.add_geom(meshname=f"{name}{k}", **hull)


def _settles(mujoco, model, data):
    steps, every = round(LONGEST_S / STEP_S), 50
    for step in range(0, steps, every):
        mujoco.mj_step(model, data, every)
        if np.abs(data.qpos[:3]).max() > 0.6:
            return False
        speed, spin = np.linalg.norm(data.qvel[:3]), np.linalg.norm(data.qvel[3:6])
        if step >= 100 and speed < AT_REST[0] and spin < AT_REST[1]:
            return True
    return False


def _leans(mujoco, model, data):
    """Whether table and prop carry the object, nothing else touches it and nothing is too deep."""
    names = [model.body(model.geom_bodyid[geom]).name for geom in range(model.ngeom)]
    carried = {"world": 0.0, "prop": 0.0}
    highest_m = 0.0
    force = np.empty(6)
    for number in range(data.ncon):
        contact = data.contact[number]
        other = next((names[geom] for geom in contact.geom if names[geom] != "leaning"), "leaning")
        if contact.dist < -DEEPEST_M or other not in carried:
            return False
        mujoco.mj_contactForce(model, data, number, force)
        carried[other] += float(np.linalg.norm(force[:3]))
        highest_m = max(highest_m, float(contact.pos[2]))
    weight = model.body("leaning").subtreemass[0] * 9.81
    return highest_m > LOWEST_SUPPORT_M and min(carried.values()) > LEAST_SHARE_CARRIED * weight


def _pose(mujoco, data, item):
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, data.qpos[3:7])
    table_from_object = np.eye(4)
    table_from_object[:3, :3] = rotation.reshape(3, 3)
    table_from_object[:3, 3] = data.qpos[:3]
    # Contacts give way by tenths of a millimetre: onto the table, exactly.
    lowest = (item.shape.mesh.vertices_m @ table_from_object[2, :3]).min()
    table_from_object[2, 3] = -lowest
    return table_from_object
