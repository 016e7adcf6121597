"""Plots with matplotlib, which is imported when a plot is made: install it to use them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graspctx import _core

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


def plot_detection(detection: _core.Detection, axes: Axes | None = None, **options: Any) -> Axes:
    """The picture of a detection in matplotlib axes; the options are those of Detection.draw."""
    import matplotlib.pyplot as plt

    axes = axes if axes is not None else plt.figure().add_subplot()
    axes.imshow(detection.draw(**options))
    axes.set_axis_off()
    return axes


def plot_cue_levels(
    left: NDArray[np.uint8], right: NDArray[np.uint8], camera: _core.StereoCamera, **options: Any
) -> Figure:
    """The segmentation at its three cue levels, side by side (Fig. 2).

    left, right: uint8 (H, W, 3) RGB or (H, W). The options are those of segment_objects but cues.
    Returns a figure of three axes.
    """
    import matplotlib.pyplot as plt

    view = _core.rectify(left, right, camera)[0]
    figure, panels = plt.subplots(1, 3, figsize=(15, 4.2), layout="constrained")
    for axes, cues in zip(panels, ("disparity", "plane", "colour")):
        scene = _core.segment_scene(left, right, camera, cues=cues, **options)
        axes.imshow(view, cmap="gray", alpha=0.4)
        for index, found in enumerate(scene.objects):
            mask = scene.instance_ids == found.id
            colour = f"C{index % 10}"
            axes.contourf(mask, levels=[0.5, 1.5], colors=[colour], alpha=0.4)
            axes.contour(mask, levels=[0.5], colors=[colour])
            axes.annotate(str(found.id), found.centroid_px, color="white", ha="center", va="center")
        axes.set_title(f"{cues}: {len(scene.objects)} object{'' if len(scene.objects) == 1 else 's'}")
        axes.set_axis_off()
    return figure


def plot_descriptor(
    image: NDArray[np.uint8],
    mask: NDArray[np.uint8] | NDArray[np.bool_],
    sample: int | None = None,
    **options: Any,
) -> Figure:
    """How an object is described, step by step (Fig. 3).

    The foveal view, its contour samples with their gradients, the log-polar bins around one sample, that
    sample's histogram, and the three scales of the descriptor of its patch. image: uint8 (H, W, 3) or (H, W);
    mask: uint8 or bool (H, W). sample: index of the contour sample; by default the one farthest to the right.
    The options are those of describe_view.
    """
    import matplotlib.pyplot as plt

    known = _descriptor_options(options)
    view = _core.foveal_view(image, mask, **known["fovea"])
    contour = _core.sample_contour(view.image, view.mask, **known["contour"])
    points = contour.points
    if len(points) < 2:
        raise ValueError(f"image: expected an object with a contour, got {len(points)} contour samples")
    sample = int(np.argmax(points[:, 0])) if sample is None else sample
    contexts = _core.shape_contexts(
        points,
        gradients=contour.gradients,
        border_distances=contour.border_distances,
        **known["shape_context"],
    )
    patches = _core.describe_view(view, **options)
    patch = int(np.argmin(np.linalg.norm(patches.centres - points[sample], axis=1)))

    bins = known["shape_context"]
    figure, panels = plt.subplots(1, 5, figsize=(20, 4.2), layout="constrained")
    _show_view(panels[0], view, "segment")
    panels[0].contour(view.mask > 0, levels=[0.5], colors="orange")
    _show_view(panels[1], view, f"{len(points)} contour samples, gradients")
    panels[1].quiver(
        *points.T,
        np.cos(contour.gradients),
        np.sin(contour.gradients),
        angles="xy",
        color="tab:blue",
        width=0.004,
    )
    _show_view(panels[2], view, "log-polar bins at one sample")
    limits = panels[2].axis()
    _draw_bins(panels[2], points, sample, bins, float(contour.gradients[sample]))
    panels[2].axis(limits)
    _show_histogram(panels[3], contexts[sample], bins, "its histogram")
    scales = patches.features[patch].reshape(3, -1)
    joined = np.vstack([_histogram_picture(scale, bins) for scale in scales])
    panels[4].imshow(joined, cmap="magma", aspect="auto")
    for scale in (1, 2):
        panels[4].axhline(scale * bins["radial_bins"] - 0.5, color="white")
    panels[4].set(
        title="descriptor of its patch, 3 scales", xlabel="angle bin", ylabel="log-radius bin", yticks=[]
    )
    return figure


def _descriptor_options(options: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The options of describe_view by the stage that takes them, with the defaults of the core."""
    defaults = _core.descriptor_defaults()
    unknown = set(options) - {name for stage in defaults.values() for name in stage}
    if unknown:
        raise TypeError(f"plot_descriptor() got an unexpected option '{min(unknown)}'")
    return {
        stage: {name: options.get(name, default) for name, default in names.items()}
        for stage, names in defaults.items()
    }


def _show_view(axes: Axes, view: _core.FovealView, title: str) -> None:
    axes.imshow(view.image, cmap="gray", alpha=0.6)
    axes.set_title(title)
    axes.set_axis_off()


def _draw_bins(
    axes: Axes, points: NDArray[np.float32], sample: int, bins: dict[str, Any], gradient: float
) -> None:
    import matplotlib.pyplot as plt

    origin = points[sample]
    axes.plot(*points.T, ".", color="black", markersize=2)
    differences = points[:, None].astype(np.float64) - points[None]
    distances = np.linalg.norm(differences, axis=2)
    mean_distance = distances.sum() / (len(points) * (len(points) - 1))
    # From the outer radius inwards: a single ring ends at the outer one.
    radii = mean_distance * np.geomspace(bins["outer_radius"], bins["inner_radius"], bins["radial_bins"])
    for radius in radii:
        axes.add_patch(plt.Circle(tuple(origin), radius, fill=False, color="tab:red"))
    turned = gradient if bins["relative_to_gradient"] else 0.0
    for angle in turned + 2 * np.pi * np.arange(bins["angular_bins"]) / bins["angular_bins"]:
        end = origin + radii[0] * np.array([np.cos(angle), np.sin(angle)])
        axes.plot(*np.transpose([origin, end]), color="tab:red", linewidth=0.8)


def _histogram_picture(histogram: NDArray[np.float32], bins: dict[str, Any]) -> NDArray[np.float32]:
    """Log-radii upwards, angles to the right; with outline_px that of all, then of the outline."""
    # Columns are angle-major: angle * radial_bins + radius.
    parts = histogram.reshape(-1, bins["angular_bins"], bins["radial_bins"])
    return np.hstack([part.T[::-1] for part in parts])


def _show_histogram(axes: Axes, context: NDArray[np.float32], bins: dict[str, Any], title: str) -> None:
    axes.imshow(_histogram_picture(context, bins), cmap="magma", aspect="auto")
    axes.set(title=title, xlabel="angle bin", ylabel="log-radius bin", yticks=[])
