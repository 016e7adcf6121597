"""What is familiar to a model, and several models that vote."""

import json

import graspctx as gc
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st


def rows(place: float, seed: int, images: int = 12, patches: int = 8):
    """Patches of objects around a place: features, labels, groups, views (two of each image)."""
    rng = np.random.default_rng(seed)
    objects = rng.normal(place, 0.05, (2 * images, 1, 120))
    features = objects + rng.normal(0, 0.05, (2 * images, patches, 120))
    labels = np.tile(np.arange(patches) < patches // 2, 2 * images).astype(int)
    features[:, : patches // 2, :10] += 0.3
    views = np.repeat(np.arange(2 * images), patches)
    return features.reshape(-1, 120).astype(np.float32), labels, views // 2, views


@pytest.fixture(scope="module")
def models():
    search = {"svm_c": [10], "gamma_times_dimension": [1]}
    named = {"low": 0.0, "high": 1.0}
    made = []
    for name, place in named.items():
        features, labels, groups, views = rows(place, 1)
        made.append(gc.train_model(features, labels, groups, views=views, name=name, **search))
    return made


def nearest(features, views):
    return np.linalg.norm(views - features.astype(float).mean(axis=0), axis=1).min()


def test_familiarity_is_a_rank_among_held_out_distances(models):
    """The definition, from the training rows alone."""
    features, _, groups, views = rows(0.0, 1)
    means = np.array([features[views == view].astype(float).mean(axis=0) for view in range(24)])
    group = np.array([groups[views == view][0] for view in range(24)])
    distances = np.linalg.norm(means[:, None] - means[None], axis=2)
    distances[group[:, None] == group[None]] = np.inf
    held_out = distances.min(axis=1)
    others, _, _, other_views = rows(0.0, 2)
    for view in range(24):
        of_view = others[other_views == view]
        expected = (1 + (held_out >= nearest(of_view, means)).sum()) / 25
        assert models[0].familiarity(of_view) == pytest.approx(expected)


@given(shift=st.floats(0, 3), seed=st.integers(0, 50))
@settings(max_examples=40, deadline=None)
def test_familiarity_lies_between_0_and_1_and_drops_on_the_way_out(models, shift, seed):
    features = rows(0.0, seed, images=1)[0]
    near, far = (models[0].familiarity(features + np.float32(way)) for way in (shift, shift + 3))
    assert 0 < far <= near <= 1
    assert far == pytest.approx(1 / 25)


def test_the_model_that_knows_the_object_answers(models):
    for place, name in ((0.0, "low"), (1.0, "high")):
        features = rows(place, 5)[0][:8]
        choice = gc.choose_model(models, [features, features])
        assert models[choice.model].name == name and choice.familiar
        assert choice.familiarity == models[choice.model].familiarity(features)
    strange = np.full((4, 120), 9, np.float32)
    choice = gc.choose_model(models, [strange, strange], 0.1)
    assert not choice.familiar and models[choice.model].name == "high"


def test_it_comes_back_from_a_file(models, tmp_path):
    features = rows(0.0, 3)[0][:8]
    models[0].save(tmp_path / "low.safetensors")
    assert gc.load_model(tmp_path / "low.safetensors").familiarity(features) == models[0].familiarity(
        features
    )


def test_a_model_from_before_does_not_know(old_model):
    features = rows(0.0, 3)[0][:8]
    assert gc.load_model(old_model).familiarity(features) is None
    with pytest.raises(gc.InvalidInput, match="cannot tell"):
        gc.choose_model(gc.load_model(old_model), [features])


def test_wrong_arguments_are_named(models):
    features, labels, groups, views = rows(0.0, 1)
    with pytest.raises(TypeError, match="sequence of them"):
        gc.choose_model("mug", [features])
    with pytest.raises(TypeError, match="sequence of them"):
        gc.choose_model([models[0], 3], [features])
    with pytest.raises(gc.InvalidInput, match="for each of the 2"):
        gc.choose_model(models, [features])
    with pytest.raises(gc.InvalidInput, match="one or more"):
        gc.choose_model([], [])
    with pytest.raises(gc.InvalidInput, match="columns"):
        models[0].familiarity(features[:, :60].copy())
    with pytest.raises(gc.InvalidInput, match="none"):
        models[0].familiarity(features[:0])
    with pytest.raises(gc.InvalidInput, match="two groups"):
        gc.train_model(features, labels, groups, views=np.zeros(len(views), int))
    with pytest.raises(TypeError, match="views"):
        gc.train_model(features, labels, groups, views=views.astype(float))


def test_a_vote_says_who_answered(pair, camera, mask, models):
    detection = gc.detect_grasps(*pair, camera, models, mask=mask, min_familiarity=0)
    (item,) = detection.objects
    assert item.model_name in ("low", "high") and 0 < item.familiarity <= 1 and not item.unfamiliar
    assert detection.model_name == "low,high"
    assert detection.model_sha256 == ",".join(model.sha256 for model in models)
    (found,) = detection.to_dict()["objects"]
    assert (found["model"], found["familiarity"]) == (item.model_name, item.familiarity)
    refused = gc.detect_grasps(*pair, camera, models, mask=mask, min_familiarity=1)
    (item,) = refused.objects
    assert item.unfamiliar and item.grasps == []
    assert json.loads(refused.to_json())["objects"][0]["unfamiliar"] is True
    assert refused.draw().any()


def test_models_that_cannot_vote_are_refused(pair, camera, mask, models, model):
    with pytest.raises(gc.InvalidInput, match="several models expected"):
        gc.detect_grasps(*pair, camera, [models[0], model], mask=mask)
    with pytest.raises(gc.InvalidInput, match="different names"):
        gc.detect_grasps(*pair, camera, [models[0], models[0]], mask=mask)
    with pytest.raises(gc.InvalidInput, match="one or more"):
        gc.detect_grasps(*pair, camera, [], mask=mask)
    with pytest.raises(gc.InvalidInput, match="min_familiarity"):
        gc.detect_grasps(*pair, camera, models, mask=mask, min_familiarity=2.0)
    with pytest.raises(TypeError, match="min_familiarity"):
        gc.detect_grasps(*pair, camera, models, mask=mask, min_familiarity="most")


def test_one_model_without_familiarity_stays_as_it_was(pair, camera, mask, model):
    (item,) = gc.detect_grasps(*pair, camera, [model], mask=mask).objects
    assert item.familiarity is None and item.model_name == "" and not item.unfamiliar
    found = gc.detect_grasps(*pair, camera, model, mask=mask).to_dict()["objects"][0]
    assert list(found) == ["id", "bounding_box_px", "centroid_px", "pose", "grasps"]
