"""The classifier from Python: training, the formula it stands for, files, progress."""

import hashlib
import signal

import graspctx as gc
import numpy as np
import pytest


def shells(seed: int, rows: int = 240, groups: int = 12):
    """Two classes that no plane separates: an inner and an outer shell in 120 dimensions."""
    rng = np.random.default_rng(seed)
    labels = rng.integers(0, 2, rows)
    directions = rng.normal(size=(rows, 120))
    radii = np.where(labels == 1, 1.0, 1.6) + rng.normal(scale=0.15, size=rows)
    features = directions / np.linalg.norm(directions, axis=1, keepdims=True) * radii[:, None]
    return features.astype(np.float32), labels, rng.permutation(np.arange(rows) % groups)


@pytest.fixture(scope="module")
def shell_model() -> gc.GraspModel:
    return gc.train_model(*shells(1), name="shells", classes=["shell"], provenance={"command": "test"})


def test_it_learns_what_no_plane_separates(shell_model):
    features, labels, _ = shells(2)
    probability = shell_model.predict_probability(features)
    assert gc.roc_area(probability, labels) > 0.9
    assert gc.roc_area(probability[::-1].copy(), labels) < 0.7


def test_probabilities_follow_the_formula(model):
    """The formula of the class's docstring, in double precision."""
    features = np.random.default_rng(4).random((50, 120)).astype(np.float32)
    standardised = (features.astype(float) - model.mean) / model.scale
    squared = ((standardised[:, None] - model.support_vectors[None].astype(float)) ** 2).sum(axis=2)
    values = np.exp(-model.gamma * squared) @ model.coefficients - model.rho
    np.testing.assert_allclose(model.decision_values(features), values, atol=1e-4)
    expected = 1 / (1 + np.exp(model.sigmoid_a * values + model.sigmoid_b))
    np.testing.assert_allclose(model.predict_probability(features), expected, atol=1e-5)


def test_same_rows_same_model(shell_model):
    again = gc.train_model(*shells(1), name="shells", classes=["shell"], provenance={"command": "test"})
    assert again.to_bytes() == shell_model.to_bytes()


def test_the_rows_of_a_training_are_bounded_as_asked():
    features, labels, groups = shells(1)
    search = {"svm_c": [1], "gamma_times_dimension": [1]}
    one_and_two = {"max_positives_per_group": 1, "max_negatives_per_group": 2}
    model = gc.train_model(features, labels, groups, **one_and_two, **search)
    assert int(model.provenance["training.rows_of_svm"]) == 12 * (1 + 2)
    model = gc.train_model(features, labels, groups, max_rows=72, **search)
    assert int(model.provenance["training.rows_of_svm"]) == 72


def test_it_comes_back_from_a_file(shell_model, tmp_path):
    path = tmp_path / "shells.safetensors"
    shell_model.save(path)
    loaded = gc.load_model(path)
    assert loaded.to_bytes() == shell_model.to_bytes() == path.read_bytes()
    assert loaded.sha256 == shell_model.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert (loaded.name, loaded.classes) == ("shells", ["shell"])
    assert loaded.provenance["command"] == "test"
    assert loaded.descriptor == shell_model.descriptor
    features, _, _ = shells(3)
    np.testing.assert_array_equal(
        loaded.predict_probability(features), shell_model.predict_probability(features)
    )
    with pytest.raises(gc.InvalidInput, match="shells"):
        shell_model.save(tmp_path / "no" / "shells.safetensors")


def test_shipped_models_load_by_name():
    assert {"mug", "pencil", "wineglass", "bowl", "eraser", "box", "book"} <= set(gc.shipped_models())
    for name in gc.shipped_models():
        model = gc.load_model(name)
        bins = model.descriptor["angular_bins"] * model.descriptor["radial_bins"]
        assert model.dimension == 3 * 2 * bins  # of all points, and of the outline
        assert model.classes
        assert hashlib.sha256(model.to_bytes()).hexdigest() == model.sha256


@pytest.mark.parametrize(("outline_px", "width"), [(0, 60), (4, 120)])
def test_the_descriptor_s_options_go_with_the_model(pair, mask, tmp_path, outline_px, width):
    options = {"angular_bins": 4, "samples": 150, "windows_patches": (1, 3, 5), "outline_px": outline_px}
    view = gc.foveal_view(pair[0], mask)
    rows = gc.describe_view(view, **options).features
    assert rows.shape[1] == width
    features = np.tile(rows, (3, 1))
    labels, groups = np.arange(len(features)) % 2, np.repeat([0, 1, 2], len(rows))
    search = {"folds": 3, "svm_c": [1], "gamma_times_dimension": [1]}
    model = gc.train_model(features, labels, groups, descriptor=options, **search)
    assert {name: model.descriptor[name] for name in options} == options
    np.testing.assert_array_equal(gc.describe_view(view, **model.descriptor).features, rows)
    model.save(tmp_path / "model.safetensors")
    assert gc.load_model(tmp_path / "model.safetensors").descriptor == model.descriptor
    with pytest.raises(TypeError, match="'sample'"):
        gc.train_model(features, labels, groups, descriptor={"sample": 3}, **search)


def test_progress_is_told_and_can_stop_it():
    told = []
    gc.train_model(*shells(1), progress=lambda share, what: told.append((share, what)))
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert shares[0] >= 0 and shares[-1] == pytest.approx(1)
    assert all(isinstance(what, str) and what for _, what in told)

    class StopError(Exception):
        pass

    def stop(share, what):
        raise StopError(what)

    with pytest.raises(StopError):
        gc.train_model(*shells(1), progress=stop)
    views = [gc.LabelledView(np.zeros((40, 40), np.uint8), *[np.ones((40, 40), np.uint8)] * 2)]
    with pytest.raises(StopError):
        gc.build_training_set(views, progress=lambda share: stop(share, ""))


def test_ctrl_c_ends_a_training():
    calls = []

    def interrupt(share, what):
        calls.append(share)
        signal.raise_signal(signal.SIGINT)

    # A shell starts what runs in the background with SIGINT ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            gc.train_model(*shells(1), progress=interrupt)
            raise AssertionError("the training went on to its end")
    finally:
        signal.signal(signal.SIGINT, before)
    assert len(calls) <= 2


def test_a_warm_start_is_trained_on_its_base_and_the_rows(shell_model):
    features, labels, groups = shells(5, rows=60, groups=5)
    warm = gc.train_model(features, labels, groups, base=shell_model)
    assert warm.provenance["base.name"] == "shells"
    assert warm.provenance["base.sha256"] == shell_model.sha256
    assert (warm.svm_c, warm.descriptor) == (shell_model.svm_c, shell_model.descriptor)
    assert warm.to_bytes() == gc.train_model(features, labels, groups, base=shell_model).to_bytes()
    # Each support vector is a row of the base or of the caller.
    rows = np.concatenate([features, shell_model.support_vectors * shell_model.scale + shell_model.mean])
    vectors = warm.support_vectors * warm.scale + warm.mean
    distances = ((vectors[:, None] - rows[None]) ** 2).sum(2)
    assert distances.min(1).max() < 1e-8
    nearest = distances.argmin(1)
    assert 0 < (nearest < len(features)).sum() < len(vectors)
    other = gc.train_model(features, labels, groups, base=shell_model, svm_c=[7])
    assert other.svm_c == 7


def test_a_base_that_does_not_fit_is_refused(shell_model):
    features, labels, groups = shells(5, rows=60, groups=5)
    with pytest.raises(TypeError, match="base"):
        gc.train_model(features, labels, groups, base="mug")
    with pytest.raises(gc.InvalidInput, match="120 features, the rows have 60"):
        gc.train_model(features[:, :60].copy(), labels, groups, base=shell_model)
    with pytest.raises(gc.InvalidInput, match="outline_px is 3, expected 0"):
        gc.train_model(features, labels, groups, base=shell_model, descriptor={"outline_px": 3})
    same = gc.train_model(features, labels, groups, base=shell_model, descriptor={"outline_px": 0})
    assert same.descriptor == shell_model.descriptor


def test_a_data_set_s_way_to_a_model(pair, mask):
    label = mask.copy()
    label[110:] = 0
    views = [
        gc.LabelledView(image, mask, label, class_name="disc", group=group, source=f"view {group}")
        for group, image in enumerate([pair[0], pair[0][:, ::-1].copy(), pair[0][::-1].copy()])
    ]
    assert (views[1].group, views[1].class_name, views[1].source) == (1, "disc", "view 1")
    described = gc.describe_labelled_view(views[0])
    assert described.labels.shape == described.label_share.shape == (len(described.patches),)
    np.testing.assert_array_equal(described.labels > 0, described.label_share > 0)
    assert described.visible_label_share == pytest.approx(label.sum() / mask.sum())

    plain = gc.build_training_set(views, degraded_masks=0)
    np.testing.assert_array_equal(plain.features[: len(described.labels)], described.patches.features)
    np.testing.assert_array_equal(plain.labels[: len(described.labels)], described.labels)
    assert set(plain.groups) == {0, 1, 2}
    more = gc.build_training_set(views, degraded_masks=2, seed=5)
    assert len(more.labels) > 2 * len(plain.labels)
    copies = gc.augment_views(views, degraded_masks=2, seed=5)
    assert [copy.group for copy in copies] == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    assert len({copy.mask.tobytes() for copy in copies[:3]}) == 3
    features = [gc.describe_labelled_view(copy).patches.features for copy in copies]
    np.testing.assert_array_equal(np.concatenate(features), more.features)

    model = gc.train_model(
        more.features, more.labels, more.groups, folds=3, svm_c=[10], gamma_times_dimension=[1]
    )
    (row,) = gc.evaluate_model(model, views)
    assert (row.class_name, row.views, row.patches) == ("disc", 3, len(plain.labels))
    assert row.average_precision > row.label_prior
    low, high = row.top1_interval
    assert 0 <= low <= row.top1 <= high <= 1


def test_measures_on_known_cases():
    labels = np.array([1, 0, 1, 0])
    assert gc.roc_area(np.array([0.9, 0.8, 0.7, 0.1]), labels) == pytest.approx(0.75)
    assert gc.average_precision(np.array([0.9, 0.8, 0.7, 0.1]), labels) == pytest.approx(0.5 * (1 + 2 / 3))
    assert gc.expected_calibration_error(np.array([0.5, 0.5, 0.5, 0.5]), labels) == pytest.approx(0)
    low, high = gc.wilson_interval(90, 100)
    assert (low, high) == (pytest.approx(0.8256, abs=1e-4), pytest.approx(0.9448, abs=1e-4))
    with pytest.raises(TypeError, match="scores: expected a float64 array"):
        gc.roc_area(labels, labels)
