"""Splits: every seed of a shape or texture belongs to exactly one of train, validation and test."""

SEED_LIMIT = 2**48  # seeds stay exact in JSON readers that use doubles
_MODULUS = 16
_REMAINDERS = {"train": range(12), "validation": range(12, 14), "test": range(14, 16)}

SPLITS = tuple(_REMAINDERS)
"""Names; `train` is for developing too: for whatever is looked at to make a choice."""


def split_of(seed: int) -> str:
    """The split that a shape or texture seed belongs to: its remainder by 16 says it.

    0 to 11: train; 12, 13: validation; 14, 15: test.
    """
    return next(split for split, remainders in _REMAINDERS.items() if seed % _MODULUS in remainders)


def split_number(split: str) -> int:
    """Place of a split in SPLITS; ValueError if there is no such split."""
    if split not in SPLITS:
        raise ValueError(f"unknown split '{split}'; known: {', '.join(SPLITS)}")
    return SPLITS.index(split)


def draw_seed(rng, split: str) -> int:
    """A seed of `split` below SEED_LIMIT, drawn from a numpy Generator."""
    remainders = list(_REMAINDERS.values())[split_number(split)]
    draws = SEED_LIMIT // _MODULUS * len(remainders)
    block, which = divmod(int(rng.integers(draws)), len(remainders))
    return block * _MODULUS + remainders[which]


def shared_seeds(first: list[dict], second: list[dict]) -> dict[str, list]:
    """What two lists of scene.json contents have in common: {"shapes": …, "textures": …}.

    A shape is (family, seed); a texture is a seed, whatever it is on.
    """

    def shapes(scenes):
        return {(entry["family"], entry.get("shape_seed")) for scene in scenes for entry in scene["objects"]}

    def textures(scenes):
        return {entry.get("texture_seed") for scene in scenes for entry in scene["objects"]} - {None}

    return {
        "shapes": sorted(shape for shape in shapes(first) & shapes(second) if shape[1] is not None),
        "textures": sorted(textures(first) & textures(second)),
    }
