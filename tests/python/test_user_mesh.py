"""Users' meshes: what is cut, measured and refused, on bodies of known answer; then the household set."""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

if importlib.util.find_spec("mujoco") is None:  # to import it would choose a graphics library for all
    pytest.skip("users' meshes need the extra 'sim' (mujoco)", allow_module_level=True)
trimesh = pytest.importorskip("trimesh", reason="users' meshes need the extra 'sim' (trimesh)")
Image = pytest.importorskip("PIL.Image", reason="users' meshes need the extra 'sim' (pillow)")

from graspctx.sim import Mesh, ObjectShape, draw_scene  # noqa: E402
from graspctx.sim.mesh_cut import Box, cut_by_boxes  # noqa: E402
from graspctx.sim.unwrap import unwrap  # noqa: E402
from graspctx.sim.user_mesh import MeshError, load_object, region_share  # noqa: E402

REPOSITORY = Path(__file__).resolve().parents[2]
NEW_SHAPES = sorted((REPOSITORY / "benchmarks" / "new_shapes").glob("*.json"))
MESHES = Path(os.environ.get("GRASPCTX_SHARED_DATA", REPOSITORY.parent / "shared" / "data")) / "meshes"
# A cube of 60 mm with a bar of 20 x 20 x 100 mm that sticks out of its +x side, standing on the cube.
CUBE_SURFACE_MM2 = 6 * 60 * 60
BAR_SURFACE_MM2 = 4 * 20 * 100 + 2 * 20 * 20


@pytest.fixture(autouse=True)
def no_folder_of_meshes(monkeypatch):
    monkeypatch.delenv("GRASPCTX_MESHES", raising=False)


def cube_and_bar(scale=0.001):
    cube = trimesh.creation.box((60, 60, 60))
    bar = trimesh.creation.box((100, 20, 20))
    bar.apply_translation([80, 0, 0])
    both = trimesh.util.concatenate([cube, bar])
    both.apply_scale(scale)
    return both


def write(folder, mesh=None, name="thing.stl", /, **changes):
    """An object file with its mesh; `changes` replace entries of the file."""
    if mesh is not None:
        mesh.export(folder / name)
    content = {
        "family": "thing",
        "mesh": name,
        "region": {"name": "bar", "boxes": [{"min": [0.05, -1, -1], "max": [1, 1, 1]}]},
    }
    content = {key: value for key, value in {**content, **changes}.items() if value is not None}
    file = folder / "thing.json"
    file.write_text(json.dumps(content))
    return file


def areas(mesh: Mesh):
    a, b, c = mesh.vertices_m[mesh.faces].swapaxes(0, 1)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def test_meshes_are_found_in_the_folder_given_or_that_of_the_environment(tmp_path, monkeypatch):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    cube_and_bar().export(elsewhere / "thing.stl")
    file = write(tmp_path)
    given = load_object(file, elsewhere)
    monkeypatch.setenv("GRASPCTX_MESHES", str(elsewhere))
    assert load_object(file).content_name() == given.content_name()
    # The file's own folder comes first.
    cube_and_bar(0.0011).export(tmp_path / "thing.stl")
    assert load_object(file).shape_seed != given.shape_seed


def open_edges(faces):
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return int((np.unique(edges, axis=0, return_counts=True)[1] % 2).sum())


def open_length(vertices, faces):
    """Length of the edges that an odd number of faces share."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    return np.linalg.norm(np.diff(vertices[edges[count % 2 == 1]], axis=1), axis=-1).sum()


def test_region_ends_exactly_at_the_box(tmp_path):
    shape = load_object(write(tmp_path, cube_and_bar()))
    assert isinstance(shape, ObjectShape)
    region = shape.mesh.region
    # The bar from x = 50 to its end at 130 mm: four sides and the end.
    assert areas(shape.mesh)[region].sum() * 1e6 == pytest.approx(4 * 20 * 80 + 20 * 20, rel=1e-6)
    assert areas(shape.mesh).sum() * 1e6 == pytest.approx(CUBE_SURFACE_MM2 + BAR_SURFACE_MM2, rel=1e-6)
    corners = shape.mesh.vertices_m[shape.mesh.faces]
    assert corners[region][..., 0].min() == pytest.approx(0.05, abs=1e-8)
    assert corners[~region][..., 0].max() == pytest.approx(0.05, abs=1e-8)
    assert open_edges(shape.mesh.faces) == 0
    assert shape.dimensions_m == pytest.approx({"height": 0.06, "length": 0.16, "width": 0.06})
    assert (shape.family, shape.region_name) == ("thing", "bar")


def test_several_boxes_add_up_and_may_overlap(tmp_path):
    boxes = [{"min": [x, -1, -1], "max": [x + 0.03, 1, 1]} for x in (0.06, 0.075, 0.11)]
    shape = load_object(write(tmp_path, cube_and_bar(), region={"name": "bar", "boxes": boxes}))
    # 60 to 105 and 110 to 130 mm, with the bar's end.
    expected = 4 * 20 * (45 + 20) + 20 * 20
    assert areas(shape.mesh)[shape.mesh.region].sum() * 1e6 == pytest.approx(expected, rel=1e-6)
    assert open_edges(shape.mesh.faces) == 0


def test_turned_box_cuts_a_diamond():
    plate = trimesh.creation.box((0.1, 0.1, 0.01))
    # A bar of 20 mm through the corners of the plate's top: a hexagon of the square.
    bar = Box((-1, -0.01, 0.0), (1, 0.01, 1), (0, 0, 45))
    vertices, faces, inside = cut_by_boxes(plate.vertices, plate.faces, [bar])
    mesh = Mesh(vertices, faces, None, inside)
    top = (vertices[faces][..., 2] > 0.00499).all(axis=1)
    half = 0.01 * np.sqrt(2)  # what the bar leaves of each side of the square at its corner
    assert areas(mesh)[inside & top].sum() == pytest.approx(0.1**2 - (0.1 - half) ** 2, rel=1e-9)
    # Turned by 45 degrees about z, the bar's length lies along x = y, not x = -y.
    centre = vertices[faces[inside & top]].mean(axis=1)
    assert np.abs(centre[:, 0] - centre[:, 1]).max() < 0.0142


def test_outward_leaves_the_inside_of_a_pipe_out(tmp_path):
    pipe = trimesh.creation.annulus(0.03, 0.04, 0.1, sections=64)
    box = {"min": [-1, -1, -0.02], "max": [1, 1, 0.02]}
    both = load_object(write(tmp_path, pipe, region={"name": "wall", "boxes": [box]}))
    box["outward"] = True
    outside = load_object(write(tmp_path, pipe, region={"name": "wall", "boxes": [box]}))
    side = 64 * 2 * np.sin(np.pi / 64) * 0.04  # around
    assert areas(outside.mesh)[outside.mesh.region].sum() == pytest.approx(side * 0.04, rel=1e-4)
    assert areas(both.mesh)[both.mesh.region].sum() == pytest.approx(side * 0.04 * 7 / 4, rel=1e-4)


numbers = st.floats(-0.06, 0.06)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.tuples(numbers, numbers, numbers),
            st.tuples(*[st.floats(0.002, 0.08)] * 3),
            st.tuples(*[st.sampled_from([0.0, 30.0, 45.0, 90.0, -77.0])] * 3),
        ),
        min_size=1,
        max_size=3,
    )
)
def test_cutting_keeps_the_surface_closed_and_in_place(drawn):
    ball = trimesh.creation.icosphere(2, 0.05)
    boxes = [Box(low, tuple(np.add(low, size)), turn) for low, size, turn in drawn]
    vertices, faces, inside = cut_by_boxes(ball.vertices, ball.faces, boxes)
    cut = Mesh(vertices, faces, None, inside)
    assert open_edges(faces) == 0
    assert areas(cut).sum() == pytest.approx(ball.area, rel=1e-6)
    a, b, c = vertices[faces].swapaxes(0, 1)
    assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(ball.volume, rel=1e-6)
    # Points on the faces are inside as a test of the point itself says.
    point = vertices[faces].mean(axis=1)
    truth = np.zeros(len(faces), bool)
    clear = np.ones(len(faces), bool)
    for box in boxes:
        normals, offsets = box.planes()
        depth = (point @ normals.T - offsets).min(axis=1)
        truth |= depth > 0
        clear &= np.abs(depth) > 1e-7
    assert (inside == truth)[clear].all()


@pytest.mark.parametrize("unit_m, suffix", [(0.001, "stl"), (0.01, "obj"), (0.0254, "ply")])
def test_units_and_formats_give_the_same_object(unit_m, suffix, tmp_path):
    metres = load_object(write(tmp_path, cube_and_bar()))
    box = {"min": [0.05 / unit_m, -100, -100], "max": [1000, 100, 100]}
    file = write(
        tmp_path,
        cube_and_bar(0.001 / unit_m),
        "other." + suffix,
        unit_m=unit_m,
        region={"name": "bar", "boxes": [box]},
    )
    same = load_object(file)
    assert same.dimensions_m == pytest.approx(metres.dimensions_m, rel=1e-5)
    assert same.shape_seed == metres.shape_seed < 2**48
    share = [region_share(s.mesh.vertices_m, s.mesh.faces, s.mesh.region) for s in (same, metres)]
    assert share[0] == pytest.approx(share[1], rel=1e-5)


@pytest.mark.parametrize("up", ["+x", "-x", "+y", "-y", "+z", "-z"])
def test_up_turns_the_object_and_not_the_boxes(up, tmp_path):
    shape = load_object(write(tmp_path, cube_and_bar(), up=up))
    bar = shape.mesh.vertices_m[np.unique(shape.mesh.faces[shape.mesh.region])]
    axis, sign = "xyz".index(up[1]), 1 if up[0] == "+" else -1
    if axis == 0:  # the bar points up, or down
        assert np.sort(sign * bar[:, 2])[[0, -1]] == pytest.approx([0.05, 0.13], abs=1e-6)
        assert shape.dimensions_m["height"] == pytest.approx(0.16)
    else:
        assert np.abs(bar[:, 2]).max() == pytest.approx(0.01, abs=1e-6)
        assert bar[:, 0].max() == pytest.approx(0.13, abs=1e-6)
    a, b, c = shape.mesh.vertices_m[shape.mesh.faces].swapaxes(0, 1)
    assert (a * np.cross(b, c)).sum() > 0  # turned, not mirrored
    for pose in shape.resting_poses:
        if pose.name == "standing":
            assert pose.table_from_object == pytest.approx(np.eye(3), abs=1e-6)


def test_shape_seed_follows_the_shape_and_the_content_name_the_region(tmp_path):
    first = load_object(write(tmp_path, cube_and_bar()))
    (tmp_path / "copy").mkdir()
    again = load_object(write(tmp_path / "copy", cube_and_bar(), family="other"))
    region = {"name": "bar", "boxes": [{"min": [0.06, -1, -1], "max": [1, 1, 1]}]}
    moved = load_object(write(tmp_path, region=region))
    larger = load_object(write(tmp_path, cube_and_bar(0.0011)))
    assert first.shape_seed == again.shape_seed == moved.shape_seed != larger.shape_seed
    # Another program may cut the faces otherwise and store other digits.
    finer = cube_and_bar().subdivide()
    finer.vertices += np.random.default_rng(1).uniform(-1e-8, 1e-8, finer.vertices.shape)
    assert load_object(write(tmp_path, finer)).shape_seed == first.shape_seed
    assert first.content_name().split("@")[1] == again.content_name().split("@")[1]
    assert len({shape.content_name() for shape in (first, moved, larger)}) == 3
    assert first.content_name().startswith("thing@")


def painted_obj(folder, *, library=False):
    """The cube and the bar as an OBJ whose bar has the material `grasp`; its library is absent."""
    cube, bar = cube_and_bar().split()
    lines = ["mtllib absent.mtl"] if library else []
    for mesh in (cube, bar):
        lines += ["v " + " ".join(f"{x:.6f}" for x in vertex) for vertex in mesh.vertices]
    lines += ["usemtl paint"]
    lines += ["f " + " ".join(str(i + 1) for i in face) for face in cube.faces]
    lines += ["usemtl grasp"]
    lines += ["f " + " ".join(str(i + 9) for i in face) for face in bar.faces]
    (folder / "thing.obj").write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("library", [False, True])
def test_painted_material(library, tmp_path):
    painted_obj(tmp_path, library=library)
    region = {"name": "bar", "material": "grasp"}
    shape = load_object(write(tmp_path, None, "thing.obj", region=region))
    assert areas(shape.mesh)[shape.mesh.region].sum() * 1e6 == pytest.approx(BAR_SURFACE_MM2, rel=1e-4)
    assert shape.mesh.vertices_m[shape.mesh.faces[shape.mesh.region]][..., 0].min() >= 0.03 - 1e-9


@pytest.mark.parametrize("suffix", ["ply", "obj"])
def test_painted_colour(suffix, tmp_path):
    mesh = cube_and_bar()
    colour = np.full((len(mesh.vertices), 4), 200, np.uint8)
    colour[mesh.vertices[:, 0] > 0.0301] = (250, 10, 20, 255)
    colour[8:] = (250, 10, 20, 255)
    mesh.visual = trimesh.visual.ColorVisuals(mesh, vertex_colors=colour)
    region = {"name": "bar", "colour": [255, 0, 0]}
    shape = load_object(write(tmp_path, mesh, "thing." + suffix, region=region))
    assert areas(shape.mesh)[shape.mesh.region].sum() * 1e6 == pytest.approx(BAR_SURFACE_MM2, rel=1e-4)


def test_faces_turned_inside_out_are_turned_back(tmp_path):
    right = cube_and_bar()
    faces = right.faces.copy()
    faces[::3] = faces[::3, ::-1]
    mixed = trimesh.Trimesh(right.vertices, faces, process=False)
    inverted = trimesh.Trimesh(right.vertices, right.faces[:, ::-1], process=False)
    for wrong in (mixed, inverted):
        shape = load_object(write(tmp_path, wrong))
        a, b, c = shape.mesh.vertices_m[shape.mesh.faces].swapaxes(0, 1)
        assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(right.volume, rel=1e-5)


def test_texture_is_even_on_every_face():
    ball = trimesh.creation.icosphere(3, 0.05)
    tall = trimesh.creation.cylinder(0.01, 0.15, sections=40)
    for mesh in (cube_and_bar(), ball, tall, trimesh.creation.box((0.2, 0.03, 0.05))):
        uv, unrolled_m = unwrap(mesh.vertices, mesh.faces)
        assert np.isfinite(uv).all()
        assert uv[..., 1].min() >= -1e-9 and uv[..., 1].max() <= 1 + 1e-9
        texture_m = uv * unrolled_m
        points = mesh.vertices[mesh.faces]
        # Singular values of the map from the surface to the texture, metres to metres.
        edges, on_texture = (
            np.stack([p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]], -1) for p in (points, texture_m)
        )
        flat = np.linalg.qr(edges).R
        rates = np.linalg.svd(on_texture @ np.linalg.inv(flat), compute_uv=False)
        assert rates.min() > 0.5, "stretched to more than twice its size"
        assert rates.max() < 7


def test_texture_has_no_seam_around_a_cylinder():
    tube = trimesh.creation.cylinder(0.03, 0.1, sections=32)
    uv, (around, along) = unwrap(tube.vertices, tube.faces)
    assert around == pytest.approx(64 * np.sin(np.pi / 32) * 0.03, rel=1e-3)
    assert along == pytest.approx(0.1)
    wrapped = np.abs(tube.face_normals[:, 2]) < 0.5
    u = uv[wrapped][..., 0] % 1
    # One place on the tube has one place on the texture, also where it comes round.
    vertex = tube.faces[wrapped]
    for index in np.unique(vertex):
        here = np.exp(2j * np.pi * u[vertex == index])
        assert np.abs(here - here[0]).max() < 1e-6


def test_resting_poses_are_physical_and_as_frequent_as_the_file_says(tmp_path):
    plate = trimesh.creation.box((0.1, 0.06, 0.02))
    region = {"name": "end", "boxes": [{"min": [0.02, -1, -1], "max": [1, 1, 1]}]}
    shape = load_object(write(tmp_path, plate, region=region))
    assert [pose.name for pose in shape.resting_poses].count("standing") == 1
    weights = {"standing": 1, "lying": 3}
    shape = load_object(write(tmp_path, region=region, resting=weights, up="+x"))
    assert {pose.name for pose in shape.resting_poses} == {"standing", "lying"}
    assert sum(pose.weight for pose in shape.resting_poses if pose.name == "lying") == pytest.approx(3)
    for pose in shape.resting_poses:
        height = shape.mesh.vertices_m @ pose.table_from_object[2]
        assert round(float(np.ptp(height)), 6) in (0.02, 0.06, 0.1)
        assert (pose.name == "standing") == (pose.table_from_object[2, 2] > 0.9)
    assert shape.dimensions_m["height"] == pytest.approx(0.1)


def test_solids_are_the_parts_given_or_the_hull(tmp_path):
    mesh = cube_and_bar()
    hull = load_object(write(tmp_path, mesh)).solids_m
    assert len(hull) == 1
    for index, part in enumerate(mesh.split()):
        part.export(tmp_path / f"part{index}.stl")
    parts = load_object(write(tmp_path, solids=["part*.stl"])).solids_m
    volumes = [trimesh.convex.convex_hull(points).volume for points in parts]
    assert sorted(volumes) == pytest.approx([20 * 20 * 100e-9, 60**3 * 1e-9], rel=1e-5)
    part.apply_translation([0.5, 0, 0])
    part.export(tmp_path / "part7.stl")
    with pytest.raises(MeshError, match=r"solids reach 0\.5 m beyond or short of thing\.stl"):
        load_object(write(tmp_path, solids=["part*.stl"]))


BOX = {"min": [0.05, -1, -1], "max": [1, 1, 1]}


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"mesh": "absent.stl"}, r"mesh 'absent\.stl' not found in .*GRASPCTX_MESHES"),
        ({"mesh": "thing.step"}, r"mesh 'thing\.step': unknown kind; expected \.stl"),
        ({"mesh": None}, "the file has no 'mesh'"),
        ({"colour": "red"}, "unknown 'colour'; known: family"),
        ({"family": "My Mug"}, "family 'My Mug'; expected small letters"),
        ({"unit_m": -1}, "unit_m -1; expected a length"),
        ({"unit_m": "mm"}, 'unit_m is "mm"; expected a number'),
        (
            {"unit_m": 0.001},
            r"0\.00016 m long with unit_m 0\.001; expected 0\.01 to 0\.45 m; .*\"unit_m\": 1$",
        ),
        ({"up": "z"}, r'up "z"; expected one of \+x'),
        ({"region": {"name": "bar"}}, "expected one of boxes, material and colour"),
        ({"region": {"name": "bar", "boxes": []}}, "expected a list of boxes"),
        ({"region": {"name": "bar", "boxes": [{"min": [0, 0, 0], "max": [0, 1, 1]}]}}, "expected min < max"),
        ({"region": {"name": "bar", "boxes": [{"min": [0, 0], "max": [0, 1, 1]}]}}, "three numbers"),
        ({"region": {"name": "bar", "boxes": [{**BOX, "turn": 3}]}}, "unknown 'turn'"),
        (
            {"region": {"name": "bar", "boxes": [{"min": [5, 5, 5], "max": [6, 6, 6]}]}},
            r"holds no surface; the mesh reaches from \[-0\.03, -0\.03, -0\.03\] to \[0\.13, 0\.03, 0\.03\]",
        ),
        (
            {"region": {"name": "bar", "boxes": [{"min": [-5, -5, -5], "max": [6, 6, 6]}]}},
            "the region is the whole surface",
        ),
        ({"region": {"name": "bar", "material": "grasp"}}, "expected an OBJ"),
        ({"region": {"name": "bar", "colour": [255, 0, 0]}}, "no vertex colours"),
        ({"region": {"name": "bar", "colour": [300, 0, 0]}}, "from 0 to 255"),
        ({"resting": {"standing": -1}}, "expected weights"),
        ({"resting": {"flying": 1}}, "unknown 'flying'; known: lying, standing, upside_down"),
        ({"up": "+x", "resting": {"standing": 1}}, None),
        ({"solids": ["part*.stl"]}, r"solids 'part\*\.stl' matches no file"),
    ],
)
def test_what_an_object_file_cannot_say(changes, message, tmp_path):
    file = write(tmp_path, cube_and_bar(), **changes)
    if message is None:
        load_object(file)  # the neighbour of a wrong file: this one is right
        return
    with pytest.raises(MeshError, match=message) as refused:
        load_object(file)
    assert "\n" not in str(refused.value)
    assert str(tmp_path) in str(refused.value)


@pytest.mark.parametrize(
    "name, content, message",
    [
        ("thing.stl", b"", "no faces; expected a triangle mesh"),
        ("thing.stl", b"what is this", "no faces|cannot be read as STL"),
        ("thing.ply", b"what is this", "cannot be read as PLY"),
        ("thing.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no faces"),
        (
            "thing.obj",
            b"v 0 0 0\nv nan 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n",
            "1 vertices are not finite",
        ),
        ("thing.obj", b"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", "every face is a line or a point"),
        ("thing.obj", b"v 0 0 0\nv .1 0 0\nv 0 .1 0\nf 1 2 9\n", "cannot be read as OBJ"),
        ("thing.obj", b"v 0 0 0\nv .1 0 0\nv 0 .1 0\nf 1 2 3\n", "lie in a plane"),
    ],
)
def test_broken_meshes(name, content, message, tmp_path):
    (tmp_path / name).write_bytes(content)
    region = {"name": "bar", "boxes": [{"min": [0.02, -1, -1], "max": [1, 1, 1]}]}
    with pytest.raises(MeshError, match=message) as refused:
        load_object(write(tmp_path, None, name, region=region))
    assert str(tmp_path / name) in str(refused.value)


def test_truncated_stl_and_millimetres_and_too_many_faces(tmp_path, monkeypatch):
    file = write(tmp_path, cube_and_bar())
    whole = (tmp_path / "thing.stl").read_bytes()
    (tmp_path / "thing.stl").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(MeshError, match=r"thing\.stl: (cannot be read|no faces)"):
        load_object(file)
    with pytest.raises(MeshError, match=r'160 m long .* in millimetres, set "unit_m": 0\.001'):
        load_object(write(tmp_path, cube_and_bar(1)))
    monkeypatch.setattr("graspctx.sim.user_mesh.MOST_FACES", 20)
    with pytest.raises(MeshError, match="24 faces; expected at most 20: simplify"):
        load_object(write(tmp_path, cube_and_bar()))


@pytest.mark.parametrize(
    "content", ["", "{", "[]", '"mug"', "\xff", 100_000 * "["], ids=lambda content: repr(content[:9])
)
def test_object_file_that_is_not_one(content, tmp_path):
    file = tmp_path / "thing.json"
    file.write_bytes(content.encode("latin-1"))
    with pytest.raises(MeshError, match=r"thing\.json: (not JSON|the file is)"):
        load_object(file)


def test_scenes_take_objects_beside_families(tmp_path):
    shape = load_object(write(tmp_path, cube_and_bar()))
    families = [
        placed.shape.family
        for i in range(4)
        for placed in draw_scene(5, i, families=[shape, "pencil"]).objects
    ]
    assert families == ["thing", "pencil", "thing", "pencil"]


def run(*arguments):
    """The command line in a process of its own: its graphics start afresh."""
    command = [sys.executable, "-m", "graspctx.sim", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_command_line_makes_a_data_set_and_takes_it_up_again(tmp_path):
    file = write(tmp_path, cube_and_bar())
    out = tmp_path / "set"
    options = ["--seed", 1, "--resolution", "320x240", "--families", f"{file},pencil"]
    made = run("make", out, "--scenes", 1, *options)
    assert made.returncode == 0, made.stderr
    first = (out / "scene_000000" / "left.png").read_bytes()
    made = run("make", out, "--scenes", 3, *options, "--workers", 2)
    assert made.returncode == 0, made.stderr
    assert (out / "scene_000000" / "left.png").read_bytes() == first
    header = json.loads((out / "dataset.json").read_text())
    shape = load_object(file)
    assert header["families"] == [shape.content_name(), "pencil"]
    for index in (0, 2):
        (entry,) = json.loads((out / f"scene_{index:06d}" / "scene.json").read_text())["objects"]
        assert (entry["family"], entry["shape_seed"]) == ("thing", shape.shape_seed)
    # Another region is another data set.
    write(tmp_path, region={"name": "bar", "boxes": [{"min": [0.06, -1, -1], "max": [1, 1, 1]}]})
    refused = run("make", out, "--scenes", 4, *options)
    assert refused.returncode == 3
    assert "made with other options: families" in refused.stderr


def test_command_line_shows_a_mesh(tmp_path):
    file = write(tmp_path, cube_and_bar())
    shown = run("mesh", file, "--picture", tmp_path / "thing.png")
    assert shown.returncode == 0, shown.stderr
    assert "height 60.0 mm, length 160.0 mm, width 60.0 mm" in shown.stdout
    share = (4 * 20 * 80 + 400) / (CUBE_SURFACE_MM2 + BAR_SURFACE_MM2)
    assert f"bar: {100 * share:.1f} % of the surface" in shown.stdout
    assert "standing" in shown.stdout
    picture = np.asarray(Image.open(tmp_path / "thing.png")).astype(int)
    red = (picture[..., 0] > picture[..., 1] + 60) & (picture[..., 0] > picture[..., 2] + 60)
    tiles = red.reshape(2, 400, 4, 400).sum(axis=(1, 3))
    # From +x the bar's end is seen; from -x the cube hides it.
    assert tiles[0, 0] > 300 and tiles[1, 0] < 100
    assert tiles[0, 2] > 1000


@pytest.mark.parametrize("command", ["mesh", "make"])
def test_command_line_refuses_what_is_no_object_file(command, tmp_path):
    absent = tmp_path / "absent.json"
    more = (
        [absent]
        if command == "mesh"
        else [tmp_path / "out", "--scenes", 1, "--seed", 1, "--families", absent]
    )
    refused = run(command, *more)
    assert refused.returncode == 3
    assert refused.stderr.splitlines() == [
        f"graspctx.sim: {absent}: No such file or directory; expected an object file (JSON)"
    ]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("file", NEW_SHAPES, ids=lambda file: file.stem)
def test_household_objects(file):
    if not (MESHES / "object_sim").is_dir():
        pytest.skip(f"{MESHES / 'object_sim'} is absent; GRASPCTX_SHARED_DATA names another folder")
    shape = load_object(file, MESHES)
    share = region_share(shape.mesh.vertices_m, shape.mesh.faces, shape.mesh.region)
    assert 0.02 < share < 0.7
    assert len(shape.solids_m) >= 1
    # Cutting opened nothing that was closed.
    before = trimesh.load_mesh(MESHES / json.loads(file.read_text())["mesh"], file_type="stl")
    before.merge_vertices()
    before = open_length(before.vertices, before.faces[before.nondegenerate_faces()])
    assert open_length(shape.mesh.vertices_m, shape.mesh.faces) == pytest.approx(before, abs=1e-5)
    assert shape.resting_poses
    # The region is one piece, or the two sides of one wall: no stray patches.
    cut = trimesh.Trimesh(shape.mesh.vertices_m, shape.mesh.faces[shape.mesh.region], process=False)
    pieces = sorted((piece.area for piece in cut.split(only_watertight=False)), reverse=True)
    assert sum(pieces[:2]) > 0.9 * sum(pieces)


def test_the_same_shape_under_two_names_has_one_seed(tmp_path):
    if not (MESHES / "object_sim").is_dir():
        pytest.skip(f"{MESHES / 'object_sim'} is absent; GRASPCTX_SHARED_DATA names another folder")
    mug = REPOSITORY / "benchmarks" / "new_shapes" / "mug.json"
    twin = tmp_path / "twin.json"
    content = json.loads(mug.read_text())
    content["mesh"] = "object_sim/coffeemug/coffeemug.stl"
    twin.write_text(json.dumps(content))
    assert load_object(mug, MESHES).shape_seed == load_object(twin, MESHES).shape_seed
