"""The data card: what a data set holds, counted, as a Markdown file beside it."""

from __future__ import annotations

import collections
import os
from pathlib import Path

import numpy as np

from .checksum import files_checksum, scenes_checksum
from .stored import read_header, read_scenes

CARD = "README.md"
_MOST_VALUES = 12
"""A named axis with more values than this is told by its quantiles, if they are numbers."""
_BARS = 10
_BAR_LENGTH = 40


def write_card(dataset: str | os.PathLike) -> Path:
    """Write DATASET/README.md. It depends on the data set alone, so it is the same wherever it is written.

    Raises:
        DatasetError: there is no data set.
    """
    file = Path(dataset) / CARD
    partial = file.with_name(CARD + ".partial")
    partial.write_text(card_text(dataset))
    partial.replace(file)
    return file


def card_text(dataset: str | os.PathLike) -> str:
    """The card's Markdown."""
    header, scenes = read_header(dataset), read_scenes(dataset)
    objects = [entry for scene in scenes for entry in scene["objects"]]
    sections = [
        f"# {_count(len(scenes), 'stereo scene')} of {_count(len(objects), 'object')}",
        _origin(header, scenes),
        "## Classes\n\n" + _classes(scenes),
        "## Visible shares\n\n" + _visible_shares(objects),
    ]
    axes = _axes(scenes)
    if axes:
        sections.append("## Axes\n\n" + axes)
    sections.append("## Checksums\n\n" + _checksums(dataset))
    return "\n\n".join(sections) + "\n"


def make_command(header: dict) -> str | None:
    """The command that makes a data set with this header; None for one that was not rendered."""
    if "looks" not in header:
        return None
    few, most = header["objects"]
    width, height = header["image_size"]
    return (
        f"python -m graspctx.sim make OUT --scenes {header['scenes']} --seed {header['seed']}"
        f" --families {','.join(header['families'])} --objects {few}-{most}"
        f" --resolution {width}x{height} --split {header['split']}"
        f" --difficulty {header['difficulty']}" + "".join(f" --axis {axis}" for axis in header["axes"])
    )


def _origin(header, scenes):
    lines = []
    command = make_command(header)
    if command:
        lines += [f"Rendered by graspctx (looks {header['looks']}, MuJoCo {header['mujoco']}):", ""]
        lines += ["```", command, "```", ""]
        if any("@" in name for name in header["families"]):
            lines += ["`NAME@…` stands for the object file of a mesh; the number is its shape's.", ""]
        missing = header["scenes"] - len(scenes)
        if missing > 0:
            lines += [f"**Unfinished**: {_count(missing, 'scene')} missing. The command above goes on.", ""]
        lines += [
            f"Split `{header['split']}`: sets of other splits share no shape and no texture with it.",
            f"The scenes are numbered; each follows from the seed {header['seed']} and its number.",
        ]
    else:
        lines += ["Not rendered by `graspctx.sim`."]
    return "\n".join(lines)


def _classes(scenes):
    rows = []
    families = sorted({entry["family"] for scene in scenes for entry in scene["objects"]})
    for family in families:
        entries = [entry for scene in scenes for entry in scene["objects"] if entry["family"] == family]
        within = sum(any(entry["family"] == family for entry in scene["objects"]) for scene in scenes)
        seen = {
            side: sum(_px(entry, "label_px", side) > 0 for entry in entries) for side in ("left", "right")
        }
        rows.append(
            [
                family,
                within,
                len(entries),
                len({entry.get("shape_seed") for entry in entries}),
                len({entry.get("texture_seed") for entry in entries}),
                f"{seen['left']} / {seen['right']}",
                round(float(np.median([_px(entry, "visible_px", "left") for entry in entries]))),
            ]
        )
    names = "class", "scenes", "objects", "shapes", "textures", "region seen, left / right", "median px, left"
    return _table(names, rows)


def _visible_shares(objects):
    """Histograms over the objects that the left view sees: of their region, and of their whole outline."""
    seen = [entry for entry in objects if _px(entry, "visible_px", "left") > 0]
    labelled = [_px(entry, "label_px", "left") / _px(entry, "visible_px", "left") for entry in seen]
    text = "Share of an object's visible pixels that are grasp region, left view:\n\n" + _histogram(labelled)
    unhidden = [_px(entry, "visible_share", "left") for entry in seen if "visible_share" in entry]
    if unhidden:
        text += "\n\nShare of an object's outline that nothing else hides, left view:\n\n" + _histogram(
            unhidden
        )
    missing = len(objects) - len(seen)
    return text + (f"\n\n{_count(missing, 'object')} not visible at all." if missing else "")


def _axes(scenes):
    """What the named axes of the scenes, and of their objects, hold."""
    values = collections.defaultdict(list)
    for scene in scenes:
        for name, value in _items(scene):
            values[f"{name}"].append(value)
        for entry in scene["objects"]:
            for name, value in _object_items(entry):
                values[f"{name} (object)"].append(value)
    parts = []
    numeric = []
    for name, found in values.items():
        numbers = [
            value for value in found if isinstance(value, (int, float)) and not isinstance(value, bool)
        ]
        distinct = set(map(str, found))
        if len(numbers) == len(found) and (
            len(distinct) > _MOST_VALUES or any(isinstance(value, float) for value in found)
        ):
            quantiles = np.quantile(numbers, [0, 1 / 3, 0.5, 2 / 3, 1])
            numeric.append([name, len(found), *(f"{value:.4g}" for value in quantiles)])
        else:
            counts = collections.Counter(map(_name, found)).most_common()
            shown = counts[:_MOST_VALUES]
            rows = [[value, count, f"{100 * count / len(found):.0f} %"] for value, count in shown]
            if len(counts) > len(shown):
                rest = sum(count for _, count in counts[len(shown) :])
                rows.append([f"{len(counts) - len(shown)} others", rest, f"{100 * rest / len(found):.0f} %"])
            parts.append(_table((name, "count", "share"), rows))
    if numeric:
        names = "axis", "count", "least", "1st third", "median", "2nd third", "most"
        parts.insert(0, _table(names, numeric))
    return "\n\n".join(parts)


def _items(record):
    """The named axes of a scene or of an object."""
    axes = record.get("axes")
    return axes.items() if isinstance(axes, dict) else ()


def _object_items(entry):
    yield from _items(entry)
    for name in ("pose", "low", "height_m"):
        if name in entry:
            yield name, entry[name]


def _checksums(dataset):
    return (
        "```\n"
        f"files   {files_checksum(dataset)}\n"
        f"scenes  {scenes_checksum(dataset)}\n"
        "```\n\n"
        "`files` is what the shell prints for "
        "`find dataset.json scene_* -type f | LC_ALL=C sort | xargs sha256sum | sha256sum`.\n"
        "`scenes` covers what was drawn, not the pixels; it is the same for any CPU and Mesa.\n"
        "`python -m graspctx.sim checksum DATASET` prints both."
    )


def _px(entry, key, side):
    count = entry.get(key)
    return count.get(side, 0) if isinstance(count, dict) else 0


def _name(value):
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "none"}[value]
    return str(value)


def _count(number, noun):
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _histogram(shares):
    counts, edges = np.histogram(shares, _BARS, (0, 1))
    lines = []
    for count, low, high in zip(counts, edges, edges[1:]):
        bar = "█" * int(np.ceil(_BAR_LENGTH * count / max(counts.max(), 1)))
        lines.append(f"{100 * low:3.0f} to {100 * high:3.0f} % {count:6d} {bar}".rstrip())
    return "\n".join(["```", *lines, "```"])


def _table(names, rows):
    lines = ["| " + " | ".join(names) + " |", "|---" + "|--:" * (len(names) - 1) + "|"]
    lines += ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in rows]
    return "\n".join(lines)
