"""Splits of the rendered scenes: by the seeds of shapes and textures."""

import collections

import numpy as np
import pytest
from graspctx.sim import draw_scene
from graspctx.sim.splits import SEED_LIMIT, SPLITS, draw_seed, split_of


def test_every_seed_belongs_to_one_split_in_fixed_shares():
    assert collections.Counter(split_of(seed) for seed in range(1600)) == {
        "train": 1200, "validation": 200, "test": 200,
    }  # fmt: skip
    assert [split_of(seed) for seed in (0, 11, 12, 13, 14, 15, 16)] == [
        "train", "train", "validation", "validation", "test", "test", "train",
    ]  # fmt: skip


@pytest.mark.parametrize("split", SPLITS)
def test_drawn_seeds_stay_in_their_split_and_fill_its_range(split):
    rng = np.random.default_rng(1)
    seeds = np.array([draw_seed(rng, split) for _ in range(4000)])
    assert {split_of(int(seed)) for seed in seeds} == {split}
    assert len(set(seeds.tolist())) == 4000
    assert 0 <= seeds.min() < 0.01 * SEED_LIMIT and 0.99 * SEED_LIMIT < seeds.max() < SEED_LIMIT
    # Every remainder of the split is drawn about as often.
    _, count = np.unique(seeds % 16, return_counts=True)
    assert len(count) == {"train": 12, "validation": 2, "test": 2}[split]
    assert count.min() > 0.8 * count.mean()


def test_scenes_of_two_splits_share_nothing_that_is_drawn():
    drawn = {
        split: [
            draw_scene(7, index, families=["mug", "pencil"], objects=(1, 3), split=split)
            for index in range(4)
        ]
        for split in SPLITS
    }
    for split, scenes in drawn.items():
        for scene in scenes:
            seeds = [scene.table.texture_seed, *scene.background.texture_seeds]
            for placed in scene.objects:
                seeds += [placed.shape.shape_seed, placed.texture_seed]
            assert {split_of(seed) for seed in seeds} == {split}
    for scenes in zip(*drawn.values()):
        assert len({scene.camera.focal_px for scene in scenes}) > 1
        assert not np.allclose(scenes[0].cam_from_table, scenes[1].cam_from_table)


def test_unknown_split_is_refused():
    with pytest.raises(ValueError, match="unknown split 'dev'; known: train, validation, test"):
        draw_scene(1, 0, families=["mug"], split="dev")
