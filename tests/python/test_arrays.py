"""Arrays in and out: dtypes, shapes, memory, threads."""

import gc as garbage
import sys
import threading
import time
import tracemalloc

import graspctx as gc
import numpy as np
import pytest

RNG = np.random.default_rng(3)
GREY = RNG.integers(0, 256, (120, 160), dtype=np.uint8)
COLOUR = RNG.integers(0, 256, (120, 160, 3), dtype=np.uint8)
MASK = np.zeros((120, 160), np.uint8)
MASK[30:90, 40:120] = 255
POINTS = RNG.uniform(0, 100, (80, 2)).astype(np.float32)


# ---- What is refused ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("image", "error", "came"),
    [
        (COLOUR.astype(np.float32), TypeError, r"float32 array of shape \(120, 160, 3\)"),
        (COLOUR.astype(np.uint16), TypeError, "uint16 array"),
        (GREY.astype(bool), TypeError, "bool array"),
        (GREY.tolist(), TypeError, "list"),
        (None, TypeError, "NoneType"),
        ("left.png", TypeError, "str"),
        (COLOUR[..., :2], ValueError, r"uint8 array of shape \(120, 160, 2\)"),
        (COLOUR[None], ValueError, r"uint8 array of shape \(1, 120, 160, 3\)"),
        (GREY[0], ValueError, r"uint8 array of shape \(160,\)"),
        (GREY[:0], ValueError, r"uint8 array of shape \(0, 160\)"),
        (np.zeros((1, 40000), np.uint8), ValueError, r"uint8 array of shape \(1, 40000\)"),
    ],
)
def test_bad_images(image, error, came, camera, model):
    expected = rf"expected a uint8 array of shape \(H, W, 3\) or \(H, W\).*got {came}"
    with pytest.raises(error, match="image: " + expected):
        gc.sample_contour(image)
    for function in (
        gc.compute_disparity,
        lambda left, right: gc.rectify(left, right, camera),
        lambda left, right: gc.segment_objects(left, right, camera),
        lambda left, right: gc.detect_grasps(left, right, camera, model),
    ):
        with pytest.raises(error, match="left: " + expected):
            function(image, GREY)
        with pytest.raises(error, match="right: " + expected):
            function(GREY, image)


@pytest.mark.parametrize(
    ("mask", "error", "came"),
    [
        (MASK.astype(np.int32), TypeError, "int32 array"),
        (MASK.astype(float), TypeError, "float64 array"),
        (MASK.tolist(), TypeError, "list"),
        (MASK[..., None], ValueError, r"uint8 array of shape \(120, 160, 1\)"),
        (MASK[:-1], ValueError, "160x119"),
    ],
)
def test_bad_masks(mask, error, came):
    for function in (gc.sample_contour, gc.foveal_view):
        with pytest.raises(error, match=rf"mask: expected .*got {came}"):
            function(GREY, mask)


@pytest.mark.parametrize(
    ("points", "error", "came"),
    [
        (POINTS.astype(float), TypeError, r"float64 array of shape \(80, 2\)"),
        (POINTS.astype(int), TypeError, "int64 array"),
        (POINTS.astype(">f4"), TypeError, ">f4 array"),
        (POINTS.tolist(), TypeError, "list"),
        (POINTS[:, :1], ValueError, r"float32 array of shape \(80, 1\)"),
        (POINTS[0], ValueError, r"float32 array of shape \(2,\)"),
    ],
)
def test_bad_points(points, error, came):
    for function in (gc.shape_contexts, gc.Contour):
        with pytest.raises(error, match=rf"points: expected a float32 array of shape \(N, 2\), got {came}"):
            function(points)


def test_bad_values():
    with pytest.raises(ValueError, match="image size: expected sides of 1 to 32767 px"):
        gc.patch_descriptors(gc.Contour(POINTS), (2**31 - 1, 2**31 - 1))
    for bad in (np.nan, np.inf):
        points = POINTS.copy()
        points[3, 1] = bad
        with pytest.raises(gc.InvalidInput, match="points"):
            gc.shape_contexts(points)
    with pytest.raises(ValueError, match="gradients: expected one for each of the 80 points, got 79"):
        gc.Contour(POINTS, np.zeros(79, np.float32))
    with pytest.raises(gc.InvalidInput, match="gradients"):
        gc.shape_contexts(POINTS, relative_to_gradient=True)
    with pytest.raises(gc.InvalidInput, match="outside"):
        gc.patch_descriptors(gc.Contour(POINTS), (50, 50))
    with pytest.raises(gc.InvalidInput, match="size"):
        gc.patch_descriptors(gc.Contour(POINTS), (0, 50))
    with pytest.raises(gc.InvalidInput, match="empty"):
        gc.foveal_view(GREY, np.zeros_like(MASK))


@pytest.mark.parametrize(
    ("features", "error", "came"),
    [
        (lambda f: f.astype(float), TypeError, "float64 array"),
        (lambda f: f.tolist(), TypeError, "list"),
        (lambda f: f[0], ValueError, r"float32 array of shape \(120,\)"),
        (lambda f: f[:, :119].copy(), ValueError, "119"),
        (lambda f: np.where(np.arange(120) == 7, np.float32(np.nan), f), ValueError, "finite"),
    ],
)
def test_bad_features(model, features, error, came):
    good = np.zeros((4, 120), np.float32)
    for function in (model.predict_probability, model.decision_values):
        with pytest.raises(error, match=f"features: .*{came}"):
            function(features(good))


def test_bad_training_rows():
    features = RNG.normal(size=(60, 12)).astype(np.float32)
    labels, groups = np.arange(60) % 2, np.arange(60) // 10
    with pytest.raises(TypeError, match=r"labels: expected an integer array.*float64"):
        gc.train_model(features, labels.astype(float), groups)
    with pytest.raises(TypeError, match=r"groups: expected an integer array.*list"):
        gc.train_model(features, labels, groups.tolist())
    with pytest.raises(ValueError, match="labels: expected an integer array of shape"):
        gc.train_model(features, labels[:, None], groups)
    with pytest.raises(ValueError, match="groups: expected 32-bit integers, got 9999999999"):
        gc.train_model(features, labels, groups + 9999999999)
    for bad in (labels[:-1], labels + 1, np.zeros(60, int)):
        with pytest.raises(gc.InvalidInput):
            gc.train_model(features, bad, groups)
    with pytest.raises(gc.InvalidInput):
        gc.train_model(features, labels, np.zeros(60, int))


# ---- What is accepted --------------------------------------------------------------------------------------


def all_layouts(array: np.ndarray) -> list[np.ndarray]:
    """The same values in other memory."""
    padded = np.zeros((array.shape[0], array.shape[1] + 7, *array.shape[2:]), array.dtype)
    padded[:, 3:-4] = array
    readonly = array.copy()
    readonly.flags.writeable = False
    unaligned = np.frombuffer(b"x" + array.tobytes(), array.dtype, offset=1).reshape(array.shape)
    every_other = np.repeat(np.repeat(array, 2, axis=0), 2, axis=1)[::2, ::2]
    return [
        padded[:, 3:-4],
        readonly,
        unaligned,
        every_other,
        np.asfortranarray(array),
        np.ascontiguousarray(array[::-1])[::-1],
        np.ascontiguousarray(array[:, ::-1])[:, ::-1],
    ]


@pytest.mark.parametrize("image", [GREY, COLOUR], ids=["grey", "colour"])
def test_memory_layout_of_images_does_not_matter(image):
    expected = gc.sample_contour(image, MASK)
    assert len(expected) == 300
    for layout in all_layouts(image):
        np.testing.assert_array_equal(gc.sample_contour(layout, MASK).points, expected.points)
    for layout in [*all_layouts(MASK), *all_layouts(MASK > 0)]:
        np.testing.assert_array_equal(gc.sample_contour(image, layout).points, expected.points)


def test_memory_layout_of_rows_does_not_matter(model):
    contexts = gc.shape_contexts(POINTS)
    for layout in all_layouts(POINTS):
        np.testing.assert_array_equal(gc.shape_contexts(layout), contexts)
    features = RNG.random((9, 120)).astype(np.float32)
    probabilities = model.predict_probability(features)
    for layout in all_layouts(features):
        np.testing.assert_array_equal(model.predict_probability(layout), probabilities)
    np.testing.assert_array_equal(model.predict_probability(features[4:5]), probabilities[4:5])
    assert model.predict_probability(features[:0]).shape == (0,)


def test_images_are_rgb(detection, pair, mask):
    """A red image and a blue one differ in grey; a channel out of place would show."""
    np.testing.assert_array_equal(detection.left, pair[0])
    np.testing.assert_array_equal(detection.right, pair[1])
    view = gc.foveal_view(pair[0], mask, object_px=85, margin_px=0)  # scale 1
    assert view.scale == 1
    u, v = (int(x) for x in view.origin_px)
    crop = pair[0][v : v + view.image.shape[0], u : u + view.image.shape[1]]
    np.testing.assert_array_equal(view.image, crop)


def test_result_types(pair, camera, mask, detection, model):
    height, width = mask.shape

    def check(array, dtype, shape):
        assert isinstance(array, np.ndarray)
        assert array.dtype == dtype
        assert array.shape == shape

    for reliable in (False, True):
        check(gc.compute_disparity(*pair, reliable=reliable), np.float32, (height, width))
    check(gc.segment_objects(*pair, camera), np.uint8, (height, width))
    contour = gc.sample_contour(pair[0], mask, samples=200)
    check(contour.points, np.float32, (200, 2))
    check(contour.gradients, np.float32, (200,))
    assert len(contour) == 200
    check(gc.shape_contexts(contour.points), np.float32, (200, 40))
    check(gc.shape_contexts(contour.points, angular_bins=12), np.float32, (200, 60))
    patches = gc.patch_descriptors(contour, image_size=(width, height))
    check(patches.centres, np.float32, (len(patches), 2))
    check(patches.cells, np.int32, (len(patches), 2))
    check(patches.features, np.float32, (len(patches), 120))
    assert patches.grid == (32, 24)
    check(model.predict_probability(patches.features), np.float64, (len(patches),))
    check(model.decision_values(patches.features), np.float64, (len(patches),))
    check(model.support_vectors, np.float32, (len(model.coefficients), 120))
    check(detection.disparity, np.float32, (height, width))
    check(detection.reliable_disparity, np.float32, (height, width))
    check(detection.segmentation.instance_ids, np.uint8, (height, width))
    check(detection.draw(), np.uint8, (720, 960, 3))
    grasp = detection.objects[0].grasps[0]
    check(grasp.cam_from_hand, np.float64, (4, 4))
    for name in ("position_m", "position_stddev_m", "approach", "closing"):
        check(getattr(grasp, name), np.float64, (3,))
    for name in ("left_px", "right_px"):
        check(getattr(grasp, name), np.float64, (2,))
    check(detection.objects[0].intermediates.fovea.left.mask, np.uint8, (280, 280))


def test_nothing_is_an_answer(pair):
    flat = np.full((50, 60), 128, np.uint8)
    contour = gc.sample_contour(flat)
    assert contour.points.shape == (0, 2)
    assert gc.shape_contexts(contour.points).shape == (0, 40)
    patches = gc.patch_descriptors(contour, (60, 50))
    assert patches.features.shape == (0, 120)
    assert patches.centres.shape == (0, 2)


# ---- Memory ------------------------------------------------------------------------------------------------


def test_results_are_moved_not_copied():
    for result in (
        gc.shape_contexts(POINTS),
        gc.compute_disparity(np.hstack([GREY, GREY]), np.hstack([GREY, GREY])),
        gc.foveal_view(COLOUR, MASK).image,
    ):
        base = result.base
        while isinstance(base, np.ndarray):
            base = base.base
        assert type(base).__name__ == "PyCapsule"
        assert not result.flags.owndata
        assert result.flags.writeable


def test_properties_are_views_that_keep_their_owner(pair, camera, model, mask):
    contour = gc.sample_contour(GREY)
    assert np.shares_memory(contour.points, contour.points)
    assert not contour.points.flags.writeable
    points, expected = contour.points, contour.points.copy()
    references = sys.getrefcount(contour)
    more = contour.gradients
    assert sys.getrefcount(contour) == references + 1
    del contour, more
    garbage.collect()
    np.testing.assert_array_equal(points, expected)

    def deep():
        found = gc.detect_grasps(*pair, camera, model, mask=mask)
        return found.objects[0].grasps[0], found.objects[0].intermediates.patches.features

    grasp, features = deep()
    garbage.collect()
    junk = [np.full(features.shape, 7, np.float32) for _ in range(20)]
    np.testing.assert_array_equal(features, deep()[1])
    assert grasp.rank == 1
    assert len(junk) == 20


def test_results_do_not_depend_on_the_arguments_afterwards(pair, camera, model, mask):
    """Grey images and masks are used where they lie: what is kept of them must have been copied."""
    left, right = (np.ascontiguousarray(image[..., 1]) for image in pair)
    own_mask = mask.copy()
    detection = gc.detect_grasps(left, right, camera, model, mask=own_mask)
    view = gc.foveal_view(left, own_mask)
    labelled = gc.LabelledView(left, own_mask, own_mask)
    expected = left.copy()
    picture, view_image = detection.draw(), view.image
    for array in (left, right, own_mask):
        array[:] = 77
    np.testing.assert_array_equal(detection.left, expected)
    np.testing.assert_array_equal(detection.segmentation.instance_ids, mask)
    np.testing.assert_array_equal(detection.draw(), picture)
    np.testing.assert_array_equal(view.image, view_image)
    np.testing.assert_array_equal(labelled.image, expected)
    np.testing.assert_array_equal(labelled.mask, mask)


def numpy_memory(function) -> int:
    """Peak of what Python and numpy allocate during a call; what C++ allocates is not seen."""
    tracemalloc.start()
    try:
        function()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_features_and_masks_are_not_copied(model):
    features = RNG.random((4000, 120)).astype(np.float32)
    assert numpy_memory(lambda: model.predict_probability(features)) < features.nbytes / 10
    assert numpy_memory(lambda: model.predict_probability(features[::2])) < features.nbytes / 10
    # The same measure sees a copy where there has to be one.
    scattered = np.asfortranarray(features)
    assert numpy_memory(lambda: model.predict_probability(scattered)) >= features.nbytes

    grey, mask = np.zeros((1000, 1000), np.uint8), np.zeros((1000, 1000), bool)
    grey[300:700, 300:700] = mask[300:700, 300:700] = 1
    assert numpy_memory(lambda: gc.sample_contour(grey, mask)) < grey.nbytes / 10
    assert numpy_memory(lambda: gc.sample_contour(grey, np.asfortranarray(mask))) >= grey.nbytes


def test_arguments_are_left_alone(pair, camera, model, mask):
    left, right, own_mask = pair[0].copy(), pair[1].copy(), mask.copy()
    gc.detect_grasps(left, right, camera, model, mask=own_mask)
    gc.sample_contour(left, own_mask)
    np.testing.assert_array_equal(left, pair[0])
    np.testing.assert_array_equal(right, pair[1])
    np.testing.assert_array_equal(own_mask, mask)


# ---- Threads -----------------------------------------------------------------------------------------------


def steps_meanwhile(call) -> int:
    """How often another thread (here: this one) gets to run while `call` computes."""
    starting, done = threading.Event(), threading.Event()

    def work():
        starting.set()
        call()
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    starting.wait()
    steps = 0
    while not done.is_set():
        time.sleep(0.001)
        steps += 1
    thread.join()
    return steps


def grown_until_slow(make_call):
    """A call that takes long enough for other threads to have their turn, on any machine."""
    size = 1
    while True:
        call = make_call(size)
        start = time.perf_counter()
        call()
        if time.perf_counter() - start > 0.15:
            return call
        size *= 2


def test_other_threads_go_on(pair, camera, model, mask):
    features = RNG.random((500, 120)).astype(np.float32)

    def contexts(size):
        points = RNG.uniform(0, 999, (500 * size, 2)).astype(np.float32)
        return lambda: gc.shape_contexts(points)

    def disparity(size):
        images = [np.tile(image, (size, 1, 1)) for image in pair]
        return lambda: gc.compute_disparity(*images)

    def probability(size):
        rows = np.tile(features, (size, 1))
        return lambda: model.predict_probability(rows)

    def contour(size):
        image = np.tile(COLOUR, (4 * size, 4, 1))
        return lambda: gc.sample_contour(image)

    def detections(size):
        images = [np.tile(image, (size, 1, 1)) for image in pair]
        ids = np.vstack([mask] + [np.zeros_like(mask)] * (size - 1))
        tall = gc.StereoCamera(focal_px=300, centre_px=(159.5, 119.5), baseline_m=0.08)
        return lambda: gc.detect_grasps(*images, tall, model, mask=ids)

    for make_call in (contexts, disparity, probability, contour, detections):
        call = grown_until_slow(make_call)
        # If the call held the interpreter, this thread would wake once or twice.
        assert steps_meanwhile(call) >= 5, make_call.__name__


def test_calls_from_many_threads_agree(pair, camera, model, mask):
    expected = gc.detect_grasps(*pair, camera, model, mask=mask).to_dict()
    del expected["timings_ms"]
    results = []

    def work():
        found = gc.detect_grasps(*pair, camera, model, mask=mask).to_dict()
        del found["timings_ms"]
        results.append(found)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [expected] * 4
