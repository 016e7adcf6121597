"""explain_grasp: shapes, the formula behind the numbers, the nearest training images."""

import json

import graspctx as gc
import numpy as np
import pytest
import scenes

IMAGES = [f"disc_{group}" for group in range(6)]


@pytest.fixture(scope="module")
def named_model():
    return scenes.disc_model(image_names=dict(enumerate(IMAGES)))


@pytest.fixture(scope="module")
def found(pair, camera, named_model, mask):
    return gc.detect_grasps(*pair, camera, named_model, mask=mask)


@pytest.fixture(scope="module")
def explanation(found, named_model):
    return gc.explain_grasp(found, named_model)


def decision_value(model, features):
    """The formula of GraspModel's docstring."""
    standardised = (features.astype(float) - model.mean) / model.scale
    squared = ((standardised - model.support_vectors.astype(float)) ** 2).sum(axis=1)
    return np.exp(-model.gamma * squared) @ model.coefficients - model.rho


def test_it_is_of_the_best_grasp(found, explanation):
    best = found.objects[0].grasps[0]
    seen = found.objects[0].intermediates
    assert explanation.object_id == found.objects[0].id
    assert explanation.grasp.rank == 1
    assert explanation.probability == pytest.approx(best.probability_left, abs=1e-12)
    np.testing.assert_array_equal(explanation.centre_px, seen.patches.centres[best.patch])
    np.testing.assert_array_equal(explanation.contour.points, seen.contour.points)
    assert explanation.view.image.shape == seen.fovea.left.image.shape
    assert explanation.point_effects.shape == (len(seen.contour.points),)
    assert explanation.bin_effects.shape == (3, 1, 8, 5)
    assert explanation.other_effect is None
    assert np.abs(explanation.point_effects).max() > 0


def test_bin_effects_follow_the_formula(found, explanation, named_model):
    row = found.objects[0].intermediates.patches.features[explanation.grasp.patch]
    f = decision_value(named_model, row)
    assert explanation.decision_value == pytest.approx(f, abs=1e-5)
    for window, angle, ring in [(0, 0, 0), (1, 3, 2), (2, 7, 4), (2, 5, 3)]:
        column = 40 * window + 5 * angle + ring
        changed = row.copy()
        changed[column] = named_model.mean[column]
        expected = f - decision_value(named_model, changed)
        assert explanation.bin_effects[window, 0, angle, ring] == pytest.approx(expected, abs=1e-5)


def test_training_images_make_up_the_decision_value(found, named_model, explanation):
    assert named_model.training_images == IMAGES
    assert named_model.support_images.shape == named_model.coefficients.shape
    everything = gc.explain_grasp(found, named_model, max_images=6)
    images = everything.graspable + everything.not_graspable
    total = sum(image.contribution for image in images) - named_model.rho
    assert total == pytest.approx(everything.decision_value, abs=1e-9)
    for image in images:
        assert IMAGES[named_model.support_images[image.support_vector]] == image.name
    assert [image.name for image in explanation.graspable] == [
        image.name for image in everything.graspable[:5]
    ]


def test_the_document_says_the_same(explanation, named_model):
    document = explanation.to_dict()
    assert document == json.loads(explanation.to_json(indent=-1))
    assert document["model"] == {"name": "disc", "sha256": named_model.sha256}
    assert document["points"]["effects"] == pytest.approx(explanation.point_effects)
    bins = [window["effects"] for window in document["windows"]]
    np.testing.assert_allclose(bins, explanation.bin_effects[:, 0])
    view_px = np.array(document["points"]["view_px"])
    np.testing.assert_allclose(
        explanation.view.image_from_view(view_px), document["points"]["left_px"], atol=1e-9
    )


def test_a_model_keeps_its_images_in_its_file(named_model, tmp_path):
    named_model.save(tmp_path / "named.safetensors")
    loaded = gc.load_model(tmp_path / "named.safetensors")
    assert loaded.training_images == IMAGES
    np.testing.assert_array_equal(loaded.support_images, named_model.support_images)


def test_a_model_without_images_explains_the_rest(detection, model):
    assert model.training_images == [] and model.support_images.shape == (0,)
    explanation = gc.explain_grasp(detection, model)
    assert explanation.graspable == explanation.not_graspable == []
    assert explanation.to_dict()["nearest_images"] is None
    assert explanation.draw().dtype == np.uint8


def test_nearest_images_are_drawn_from_the_training_views(explanation):
    views = []
    for group, name in enumerate(IMAGES):
        left, _, mask = scenes.disc_scene(seed=100 + group)
        views.append(gc.LabelledView(left, mask, mask, group=group, image_name=name))
    assert gc.image_names(views) == dict(enumerate(IMAGES))
    plain, drawn = explanation.draw(), explanation.draw(training_views=views)
    assert drawn.shape[0] > plain.shape[0] and drawn.shape[1] == plain.shape[1]
    with pytest.raises(gc.InvalidInput, match="disc_"):
        explanation.draw(training_views=views[:1])


def test_what_cannot_be_explained(found, named_model, model):
    with pytest.raises(gc.InvalidInput, match="rank"):
        gc.explain_grasp(found, named_model, rank=99)
    with pytest.raises(gc.InvalidInput, match="no object 77"):
        gc.explain_grasp(found, named_model, object_id=77)
    with pytest.raises(gc.InvalidInput, match="expected 'disc'"):
        gc.explain_grasp(found, model)
    with pytest.raises(gc.InvalidInput, match="max_images"):
        gc.explain_grasp(found, named_model, max_images=0)
    with pytest.raises(TypeError, match="images"):
        gc.explain_grasp(found, named_model, images=3)


def test_names_must_fit_into_a_model():
    with pytest.raises(gc.InvalidInput, match="relative"):
        scenes.disc_model(image_names={group: f"/home/me/{group}" for group in range(6)})
    with pytest.raises(gc.InvalidInput, match="lacks group 5"):
        scenes.disc_model(image_names=dict(enumerate(IMAGES[:5])))
