# Made by tools/make_stubs.
"""
Grasp configurations from a stereo pair: the bindings of the C++ library.
"""

from __future__ import annotations

import collections.abc
import os
import typing

import numpy
import numpy.typing

__all__: list[str] = [
    "ClassEvaluation",
    "Contour",
    "DetectedObject",
    "Detection",
    "FovealPair",
    "FovealView",
    "GraspConfiguration",
    "GraspExplanation",
    "GraspModel",
    "GraspPoint",
    "InvalidInput",
    "LabelledPatches",
    "LabelledView",
    "ModelChoice",
    "NearImage",
    "ObjectHypothesis",
    "ObjectIntermediates",
    "ObjectPose",
    "PatchDescriptors",
    "RawView",
    "Segmentation",
    "StereoCamera",
    "TablePlane",
    "TrainingSet",
    "augment_views",
    "average_precision",
    "build_training_set",
    "check_dataset",
    "choose_model",
    "compute_disparity",
    "describe_labelled_view",
    "describe_view",
    "descriptor_defaults",
    "detect_grasps",
    "draw_detection",
    "draw_segmentation",
    "evaluate_model",
    "expected_calibration_error",
    "explain_grasp",
    "find_grasp_points",
    "foveal_view",
    "image_names",
    "load_dataset",
    "load_model",
    "patch_descriptors",
    "read_image",
    "rectify",
    "robust_descriptor",
    "roc_area",
    "sample_contour",
    "segment_objects",
    "segment_scene",
    "shape_contexts",
    "shipped_models",
    "train_model",
    "wilson_interval",
    "write_image",
]

class InvalidInput(ValueError):
    """
    Input that cannot be used: a missing or invalid file, an image of the wrong size, an option out of range.
    """

class RawView:
    """
    How one raw (unrectified, distorted) view becomes its rectified view.
    """

    def __init__(
        self,
        *,
        camera_matrix: numpy.typing.ArrayLike,
        rectified_from_raw: numpy.typing.ArrayLike,
        distortion_model: str = ...,
        distortion: collections.abc.Sequence[float] = ...,
    ) -> None:
        """
        camera_matrix, rectified_from_raw: (3, 3). distortion_model: 'plumb_bob' (0, 4, 5 or 8 coefficients) or 'equidistant' (4).
        """

    def __reduce__(self) -> tuple: ...
    @property
    def camera_matrix(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3, 3) raw intrinsics, px.
        """

    @property
    def distortion(self) -> list[float]:
        """
        The model's coefficients.
        """

    @property
    def distortion_model(self) -> str:
        """
        'plumb_bob' or 'equidistant'.
        """

    @property
    def rectified_from_raw(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3, 3) rotation.
        """

class StereoCamera:
    """
    A rectified stereo pair of pinhole cameras.

    Left is the reference view. The camera frame is the left rectified optical frame: x right, y down, z forward,
    metres. Pixel centres are at integers. Z = f · B / (d + doffs).
    """

    @staticmethod
    def load(
        path: os.PathLike | str | bytes, path2: os.PathLike | str | bytes | None = ..., rectified: bool = ...
    ) -> StereoCamera:
        """
        Load a Middlebury calib.txt, or a pair of ROS camera_info YAML files (left, right). rectified says that the images of a camera_info pair are rectified already. Raises InvalidInput naming the file.
        """

    def __init__(
        self,
        *,
        focal_px: float,
        centre_px: numpy.typing.ArrayLike,
        baseline_m: float,
        doffs_px: float = ...,
        width_px: int = ...,
        height_px: int = ...,
        raw: tuple[RawView, RawView] | None = ...,
    ) -> None:
        """
        centre_px: (u, v), principal point of the left view. doffs_px: the right one's u minus the left one's.
        width_px, height_px: 0 if unknown. raw: left and right, if the images still have to be rectified.
        Raises InvalidInput if a number is out of range.
        """

    def __reduce__(self) -> tuple: ...
    def __repr__(self) -> str: ...
    def depth_m(self, disparity_px: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
        """
        Depth (m) of disparities (px) of any shape. Infinity where disparity + doffs <= 0.
        """

    def disparity_px(self, depth_m: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> typing.Any:
        """
        Disparity (px) of depths (m) of any shape.
        """

    def project(self, point_m: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Pixels (..., 2) of the left view where points (..., 3) (m, z > 0) are seen.
        """

    def ray(self, left_px: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Unit viewing rays (..., 3) through pixels (..., 2) of the left view.
        """

    def triangulate(
        self, left_px: numpy.typing.ArrayLike, disparity_px: numpy.typing.ArrayLike
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        The points (..., 3) (m) seen at pixels (..., 2) of the left view with disparities (...) (px).
        """

    @property
    def baseline_m(self) -> float: ...
    @property
    def centre_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) principal point of the left view (u, v).
        """

    @property
    def doffs_px(self) -> float: ...
    @property
    def focal_px(self) -> float:
        """
        Of both rectified views.
        """

    @property
    def height_px(self) -> int:
        """
        Of the images; 0 if unknown.
        """

    @property
    def raw(self) -> tuple[RawView, RawView] | None:
        """
        The left and the right RawView if the images still have to be rectified, else None.
        """

    @property
    def width_px(self) -> int:
        """
        Of the images; 0 if unknown.
        """

class TablePlane:
    """
    The supporting plane.

    In the image d = alpha·u + beta·v + delta_px (III-A); in the camera frame normal·P + offset_m is the height (m)
    above it.
    """

    @property
    def alpha(self) -> float: ...
    @property
    def beta(self) -> float: ...
    @property
    def delta_px(self) -> float: ...
    @property
    def normal(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) unit, from the plane to the camera.
        """

    @property
    def offset_m(self) -> float:
        """
        The camera's height above the plane.
        """

    @property
    def sigma_px(self) -> float:
        """
        Robust deviation of the disparities from the plane.
        """

class ObjectHypothesis:
    """
    An object of a Segmentation.
    """

    @property
    def bounding_box_px(self) -> tuple[int, int, int, int]:
        """
        x, y, width, height.
        """

    @property
    def centroid_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) u, v.
        """

    @property
    def depth_m(self) -> float | None:
        """
        Median over its pixels, along the viewing axis; None where unknown.
        """

    @property
    def id(self) -> int:
        """
        Its value in Segmentation.instance_ids.
        """

    @property
    def leaves_table(self) -> bool:
        """
        Part of it stands or hangs beyond the table's edge. False without a plane.
        """

    @property
    def saliency(self) -> float:
        """
        The area surely seen (cm²) over the distance (m); the hypotheses are ordered by it. Of a caller's own mask: its pixels.
        """

    @property
    def size_m(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        (3,) length and width of what is seen of it from above, height over the table; None where unknown.
        """

    @property
    def touches_border(self) -> bool:
        """
        It is cut by the image.
        """

class Segmentation:
    """
    The objects of a scene and what they stand on.
    """

    @property
    def heights_m(self) -> numpy.typing.NDArray[numpy.float32] | None:
        """
        (H, W) float32 heights above the table, NaN where unknown; None without a table.
        """

    @property
    def instance_ids(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        (H, W) uint8, 0 = background, otherwise ObjectHypothesis.id.
        """

    @property
    def objects(self) -> list[ObjectHypothesis]:
        """
        The most salient first.
        """

    @property
    def table(self) -> TablePlane | None:
        """
        TablePlane, or None.
        """

    @property
    def vertical_offset_px(self) -> float | None:
        """
        How much lower the scene lies in the right view than in the left one, about 0 in a rectified pair; None if it cannot be measured.
        """

    @property
    def warnings(self) -> list[str]: ...

class FovealView:
    """
    A view re-sampled around one object at a fixed object size.

    view_px = scale · (image_px − origin_px)
    """

    def image_from_view(self, view_px: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Pixels (..., 2) of the full image.
        """

    def view_from_image(self, image_px: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]:
        """
        Pixels (..., 2) of the view.
        """

    @property
    def image(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        uint8, RGB or grey.
        """

    @property
    def mask(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        (H, W) uint8, 255 = object.
        """

    @property
    def origin_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) image pixel at the view's (0, 0).
        """

    @property
    def scale(self) -> float:
        """
        View pixels per image pixel.
        """

class FovealPair:
    """
    Both views of one object, fixated on it.
    """

    @property
    def fixation_disparity_px(self) -> float:
        """
        Left origin's u minus the right one's.
        """

    @property
    def left(self) -> FovealView: ...
    @property
    def right(self) -> FovealView: ...

class Contour:
    """
    Samples of an object's contour: its outline and its inner edges.
    """

    def __init__(
        self,
        points: numpy.typing.NDArray[numpy.float32],
        gradients: numpy.typing.NDArray[numpy.float32] | None = ...,
        border_distances: numpy.typing.NDArray[numpy.float32] | None = ...,
    ) -> None:
        """
        points: float32 (N, 2) px. gradients: float32 (N,) rad. border_distances: float32 (N,) px.
        """

    def __len__(self) -> int: ...
    def __repr__(self) -> str: ...
    @property
    def border_distances(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (N,) float32 px to the nearest pixel outside the mask, 0 outside it.
        """

    @property
    def gradients(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (N,) float32 rad, direction of the intensity gradient from +u towards +v.
        """

    @property
    def points(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (N, 2) float32 px, (u, v).
        """

class PatchDescriptors:
    """
    Descriptors of the patches of one view.
    """

    def __len__(self) -> int: ...
    @property
    def cells(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (M, 2) int32 column and row in the patch grid.
        """

    @property
    def centres(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (M, 2) float32 px of the view, (u, v).
        """

    @property
    def features(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (M, 120) float32.
        """

    @property
    def grid(self) -> tuple[int, int]:
        """
        Number of columns and rows.
        """

class GraspModel:
    """
    The trained classifier (III-C).

    C-SVC with an RBF kernel on standardised descriptors, and Platt's sigmoid:
    x' = (x − mean) / scale;  f(x) = Σ coefficient_i · exp(−gamma · ‖x' − s_i‖²) − rho;  P = 1 / (1 + exp(A·f + B)).
    Made by load_model or train_model.
    """

    def __getstate__(self) -> bytes: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, arg0: bytes) -> None: ...
    def decision_values(
        self, features: numpy.typing.NDArray[numpy.float32]
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        f(x) of each row: float32 (M, D) features give (M,) float64.
        """

    def familiarity(self, features: numpy.typing.NDArray[numpy.float32]) -> float | None:
        """
        How much an object looks like what the model was taught, 0 to 1, from the float32 (M, D) descriptors of its patches, M > 0: the share of the training views that are as far from the views of other images, the object counted among them. None if the model does not know.
        """

    def predict_probability(
        self, features: numpy.typing.NDArray[numpy.float32]
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        P(g = 1 | D) of each row: float32 (M, D) features give (M,) float64. Rows are not copied if contiguous. Raises InvalidInput for another width or values that are not finite.
        """

    def save(self, path: os.PathLike | str | bytes) -> None:
        """
        Write a .safetensors file, all or nothing. Raises InvalidInput naming the file.
        """

    def to_bytes(self) -> bytes:
        """
        The bytes of the model's file.
        """

    def to_libsvm(self) -> str:
        """
        libsvm's text format; it takes standardised features.
        """

    @property
    def classes(self) -> list[str]:
        """
        The object classes it was trained on.
        """

    @property
    def coefficients(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (S,) float64 y_i · α_i, positive class first.
        """

    @property
    def descriptor(self) -> dict:
        """
        The options of describe_view that its features were made with, by name.
        """

    @property
    def dimension(self) -> int:
        """
        Columns of its features.
        """

    @property
    def gamma(self) -> float:
        """
        Of the RBF kernel.
        """

    @property
    def mean(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (D,) float32.
        """

    @property
    def name(self) -> str:
        """
        Its name.
        """

    @property
    def provenance(self) -> dict[str, str]:
        """
        How it was made: command, data set, counts, cross-validation results.
        """

    @property
    def rho(self) -> float:
        """
        Bias of the decision value.
        """

    @property
    def scale(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (D,) float32, > 0.
        """

    @property
    def sha256(self) -> str:
        """
        Hexadecimal hash of the model's file.
        """

    @property
    def sigmoid_a(self) -> float:
        """
        A of Platt's sigmoid.
        """

    @property
    def sigmoid_b(self) -> float:
        """
        B of Platt's sigmoid.
        """

    @property
    def support_images(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (S,) int32 indices of training_images; empty if unknown.
        """

    @property
    def support_vectors(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (S, D) float32, standardised.
        """

    @property
    def svm_c(self) -> float:
        """
        C of the SVM.
        """

    @property
    def training_images(self) -> list[str]:
        """
        Names within the data set of the images that support vectors come from; empty if unknown.
        """

class ModelChoice:
    """
    The model that answers for an object, of several.
    """

    @property
    def familiar(self) -> bool:
        """
        The object is familiar enough to it.
        """

    @property
    def familiarity(self) -> float:
        """
        0 to 1, of the object to that model.
        """

    @property
    def model(self) -> int:
        """
        Its index.
        """

class GraspPoint:
    """
    A local maximum of the response in one view.
    """

    @property
    def centre_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) u, v of the view.
        """

    @property
    def patch(self) -> int:
        """
        Row in the PatchDescriptors.
        """

    @property
    def probability(self) -> float:
        """
        P(g = 1 | D) in this view.
        """

class ObjectPose:
    """
    A rough object pose (III-D): the plane through three matched points.
    """

    @property
    def centroid_m(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) camera frame.
        """

    @property
    def centroid_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) left image.
        """

    @property
    def major_axis_m(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) a_ma, from the centroid.
        """

    @property
    def major_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) left image.
        """

    @property
    def minor_axis_m(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) a_mi, from the centroid.
        """

    @property
    def minor_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) left image.
        """

    @property
    def normal(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) n_p, unit, towards the camera.
        """

    @property
    def source(self) -> str:
        """
        'stereo', or 'segment_depth' if some point matched badly.
        """

class GraspConfiguration:
    """
    A full grasp configuration in the camera frame.

    Hand frame: z = approach (palm towards the object), x = closing (from thumb to fingers), y = z × x; origin at the
    grasp point, between the pads.
    """

    def __repr__(self) -> str: ...
    @property
    def approach(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) unit, from the palm to the object.
        """

    @property
    def cam_from_hand(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (4, 4)
        """

    @property
    def closing(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) unit, from thumb to fingers.
        """

    @property
    def feasible(self) -> bool: ...
    @property
    def infeasible_because(self) -> str | None:
        """
        Why, or None.
        """

    @property
    def left_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) u, v.
        """

    @property
    def opening_m(self) -> float:
        """
        Between the pads before they close.
        """

    @property
    def patch(self) -> int:
        """
        Of the left foveal view: its row in ObjectIntermediates.patches.
        """

    @property
    def position_m(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,) the grasp point.
        """

    @property
    def position_stddev_m(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3,)
        """

    @property
    def probability(self) -> float:
        """
        Eq. 1: left · right.
        """

    @property
    def probability_left(self) -> float: ...
    @property
    def probability_right(self) -> float: ...
    @property
    def rank(self) -> int:
        """
        From 1, in its object.
        """

    @property
    def right_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) u, v.
        """

    @property
    def rule(self) -> str:
        """
        'plane_normal', 'major_axis' or 'minor_axis' (Eq. 3).
        """

class ObjectIntermediates:
    """
    What was looked at on the way.
    """

    @property
    def contour(self) -> Contour:
        """
        Of the left foveal view.
        """

    @property
    def fovea(self) -> FovealPair: ...
    @property
    def patches(self) -> PatchDescriptors:
        """
        Of the left foveal view.
        """

    @property
    def probabilities(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (M,) float64 P(g = 1 | D) of the patches.
        """

class DetectedObject:
    """
    An object and the grasps it offers.
    """

    def __repr__(self) -> str: ...
    @property
    def bounding_box_px(self) -> tuple[int, int, int, int]:
        """
        x, y, width, height.
        """

    @property
    def centroid_px(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (2,) u, v.
        """

    @property
    def familiarity(self) -> float | None:
        """
        0 to 1, of the object to that model; None if it cannot tell.
        """

    @property
    def grasps(self) -> list[GraspConfiguration]:
        """
        Feasible first, then by probability (Eq. 2).
        """

    @property
    def id(self) -> int:
        """
        Its value in Detection.segmentation.instance_ids.
        """

    @property
    def intermediates(self) -> ObjectIntermediates: ...
    @property
    def model_name(self) -> str:
        """
        The model that answers; '' if it cannot tell what is familiar.
        """

    @property
    def pose(self) -> ObjectPose | None:
        """
        ObjectPose, or None.
        """

    @property
    def unfamiliar(self) -> bool:
        """
        To all models: it has no grasps.
        """

class Detection:
    """
    What detect_grasps found, and what it looked at.
    """

    def __repr__(self) -> str: ...
    def draw(
        self,
        *,
        max_grasps: int = ...,
        contour: bool = ...,
        probabilities: bool = ...,
        pose: bool = ...,
        min_width_px: int = ...,
        max_opening_m: float = ...,
        opening_margin_m: float = ...,
        finger_length_m: float = ...,
        finger_width_m: float = ...,
        finger_thickness_m: float = ...,
        finger_spread_m: float = ...,
        palm_radius_m: float = ...,
        tip_beyond_m: float = ...,
        table_clearance_m: float = ...,
        retreat_m: float = ...,
    ) -> numpy.typing.NDArray[numpy.uint8]:
        """
        Overlay of the left view: segments, contour, probabilities, hands in perspective: uint8 RGB (H, W, 3).

        max_grasps: drawn for each object; a hand for the first, axes for the others (x closing red, y green, z approach
        blue, grey where infeasible). min_width_px: smaller images are enlarged.
        """

    def to_dict(self) -> dict[str, typing.Any]:
        """
        The same as a dict of plain Python values.
        """

    def to_json(self, indent: typing.SupportsInt | typing.SupportsIndex | None = ...) -> str:
        """
        The detection as JSON, schema 1 (docs/detection-json.md). indent < 0: one line.
        """

    @property
    def camera(self) -> StereoCamera: ...
    @property
    def disparity(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (H, W) float32 px, NaN where unknown: all that the matcher gave.
        """

    @property
    def image_size(self) -> tuple[int, int]:
        """
        Width and height of the rectified views.
        """

    @property
    def left(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        The left rectified image, RGB or grey.
        """

    @property
    def model_name(self) -> str: ...
    @property
    def model_sha256(self) -> str: ...
    @property
    def objects(self) -> list[DetectedObject]:
        """
        The one with the best grasp first.
        """

    @property
    def reliable_disparity(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (H, W) float32 px, NaN where unknown: left-right consistent and textured.
        """

    @property
    def right(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        The right rectified image, RGB or grey.
        """

    @property
    def segmentation(self) -> Segmentation:
        """
        Instance ids, table plane.
        """

    @property
    def timings_ms(self) -> dict[str, float]:
        """
        Stage and time, in order.
        """

    @property
    def warnings(self) -> list[str]:
        """
        What to know about the result.
        """

class LabelledView:
    """
    One labelled view of one object.
    """

    def __init__(
        self,
        image: numpy.typing.NDArray[numpy.uint8],
        mask: numpy.typing.NDArray[numpy.uint8] | numpy.typing.NDArray[numpy.bool_],
        label: numpy.typing.NDArray[numpy.uint8] | numpy.typing.NDArray[numpy.bool_],
        *,
        class_name: str = ...,
        group: int = ...,
        source: str = ...,
        image_name: str = ...,
    ) -> None:
        """
        image: uint8, RGB or grey. mask, label: uint8 or bool (H, W), > 0 = object, grasp region.
        """

    @property
    def class_name(self) -> str:
        """
        Object family.
        """

    @property
    def group(self) -> int:
        """
        The two views of one scene share a group.
        """

    @property
    def image(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        uint8, RGB or grey.
        """

    @property
    def image_name(self) -> str:
        """
        Of the image or scene, within its data set.
        """

    @property
    def label(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        (H, W) uint8, > 0 = grasp region.
        """

    @property
    def mask(self) -> numpy.typing.NDArray[numpy.uint8]:
        """
        (H, W) uint8, > 0 = the object.
        """

    @property
    def source(self) -> str:
        """
        File or scene it comes from.
        """

class LabelledPatches:
    """
    The patches of a labelled view (III-C).
    """

    @property
    def label_share(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (M,) float32 share of the patch's pixels that are labelled.
        """

    @property
    def labels(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (M,) int32, 1 if it overlaps the region.
        """

    @property
    def patches(self) -> PatchDescriptors: ...
    @property
    def visible_label_share(self) -> float:
        """
        Labelled pixels over object pixels.
        """

class TrainingSet:
    """
    Training rows gathered over many views, in order.
    """

    @property
    def features(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (R, D) float32.
        """

    @property
    def groups(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (R,) int32, LabelledView.group.
        """

    @property
    def labels(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (R,) int32, 0 or 1.
        """

    @property
    def views(self) -> numpy.typing.NDArray[numpy.int32]:
        """
        (R,) int32, number of the view: each mask of each labelled view is one.
        """

class ClassEvaluation:
    """
    What a model reaches on the views of one class.
    """

    @property
    def average_precision(self) -> float:
        """
        Strict.
        """

    @property
    def average_precision_border_ignored(self) -> float:
        """
        Patches labelled by less than half left out.
        """

    @property
    def calibration_error(self) -> float: ...
    @property
    def class_name(self) -> str: ...
    @property
    def label_prior(self) -> float:
        """
        Share of positive patches.
        """

    @property
    def patches(self) -> int: ...
    @property
    def roc_area(self) -> float: ...
    @property
    def top1(self) -> float:
        """
        Share of views whose most probable patch is positive.
        """

    @property
    def top1_chance(self) -> float: ...
    @property
    def top1_interval(self) -> tuple[float, float]:
        """
        95 % interval of top1.
        """

    @property
    def top1_large_label(self) -> float:
        """
        Of the views where the label is over 2 % of the object.
        """

    @property
    def views(self) -> int:
        """
        With at least one positive patch.
        """

    @property
    def views_large_label(self) -> int: ...
    @property
    def views_without_label(self) -> int: ...

class NearImage:
    """
    A training image as the model remembers it: its support vectors of one label.
    """

    def __repr__(self) -> str: ...
    @property
    def contribution(self) -> float:
        """
        Of all of them to f: Σ coefficient · K.
        """

    @property
    def name(self) -> str:
        """
        Of the image or scene, within its data set.
        """

    @property
    def similarity(self) -> float:
        """
        Its kernel value, 0 to 1.
        """

    @property
    def support_vector(self) -> int:
        """
        The nearest one: its row in GraspModel.support_vectors.
        """

    @property
    def support_vectors(self) -> int:
        """
        How many.
        """

class GraspExplanation:
    """
    What the decision value f of a grasp's patch in the left view rests on. Made by explain_grasp.

    An effect is by how much f falls when something is taken away: it speaks for a grasping point if positive.
    """

    def __repr__(self) -> str: ...
    def draw(
        self, *, training_views: collections.abc.Sequence[LabelledView] | None = ...
    ) -> numpy.typing.NDArray[numpy.uint8]:
        """
        One picture of it: uint8 RGB (H, W, 3).

        The view with its contour samples, blue where they speak for a grasping point, orange against; the patch and its
        windows; the bins of each window as seen in the image; the nearest training images by name.
        training_views: of the data set that the model was trained on; the nearest images are then drawn. Raises
        InvalidInput if one of them is missing.
        """

    def to_dict(self) -> dict[str, typing.Any]:
        """
        The same as a dict of plain Python values.
        """

    def to_json(self, indent: typing.SupportsInt | typing.SupportsIndex | None = ...) -> str:
        """
        The explanation as JSON, schema 1 (docs/explain.md). indent < 0: one line.
        """

    @property
    def bin_effects(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (3, 1 or 2, angular_bins, radial_bins) float64: of each bin of each window, put to its training mean; of all points, and with outline_px of the outline alone.
        """

    @property
    def centre_px(self) -> tuple[float, float]:
        """
        The patch's centre (u, v) in the view.
        """

    @property
    def contour(self) -> Contour:
        """
        Of the view.
        """

    @property
    def decision_value(self) -> float:
        """
        f of the patch.
        """

    @property
    def grasp(self) -> GraspConfiguration:
        """
        The grasp explained.
        """

    @property
    def graspable(self) -> list[NearImage]:
        """
        Training images whose graspable patches are like this one, the most similar first; empty if the model does not know its images.
        """

    @property
    def not_graspable(self) -> list[NearImage]:
        """
        The same for patches that are not graspable.
        """

    @property
    def object_id(self) -> int:
        """
        DetectedObject.id.
        """

    @property
    def other_effect(self) -> float | None:
        """
        Of all features behind the shape context, put to their means; None if there are none.
        """

    @property
    def point_effects(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (N,) float64: of each contour sample, left out.
        """

    @property
    def probability(self) -> float:
        """
        P(g = 1 | D) of the patch in the left view.
        """

    @property
    def ring_radii_px(self) -> list[float]:
        """
        Outer radius of each ring of the bins, in the view.
        """

    @property
    def view(self) -> FovealView:
        """
        The left foveal view.
        """

def augment_views(
    views: collections.abc.Sequence[LabelledView], *, degraded_masks: int = ..., seed: int = ...
) -> list[LabelledView]:
    """
    The views that build_training_set describes (METHOD 5).

    Each with its true mask, then its copies with masks that are too large, carry a wedge of the background or are cut off.
    degraded_masks: such copies of each view.
    """

def average_precision(
    scores: numpy.typing.NDArray[numpy.float64], labels: numpy.typing.NDArray[numpy.integer]
) -> float:
    """
    Area under the precision-recall curve by steps; NaN without positives. scores: float64 (M,), labels: integers (M,), 0 or 1.
    """

def build_training_set(
    views: collections.abc.Sequence[LabelledView],
    *,
    progress: collections.abc.Callable[[float], None] | None = ...,
    degraded_masks: int = ...,
    seed: int = ...,
    object_px: int = ...,
    margin_px: int = ...,
    refine_mask: bool = ...,
    canny_low: float = ...,
    canny_high: float = ...,
    samples: int = ...,
    mask_margin_px: int = ...,
    angular_bins: int = ...,
    radial_bins: int = ...,
    inner_radius: float = ...,
    outer_radius: float = ...,
    relative_to_gradient: bool = ...,
    outline_px: int = ...,
    patch_px: int = ...,
    windows_patches: tuple[int, int, int] = ...,
) -> TrainingSet:
    """
    Describe every view with its true mask, and again with masks as imperfect as those met later (METHOD 5).

    degraded_masks: such copies of each view. progress: called with the share done; what it raises ends the work.
    """

def check_dataset(
    path: os.PathLike | str | bytes,
    *,
    format: str = ...,
    object_labels: collections.abc.Sequence[str] = ...,
    grasp_labels: collections.abc.Sequence[str] = ...,
) -> list[str]:
    """
    The problems of a data set, one line each, the first 200; empty if it is sound. Options as for load_dataset.
    """

def choose_model(
    models: GraspModel | collections.abc.Sequence[GraspModel],
    features: collections.abc.Sequence[numpy.typing.NDArray[numpy.float32]],
    min_familiarity: float = ...,
) -> ModelChoice:
    """
    The vote: of the models that an object is familiar enough to, the one with the nearest training view.

    If there is none, the one with the nearest training view of all, and `familiar` is False.
    features: for each model float32 (M, D), the object's patch descriptors by the model's own descriptor options.
    Raises InvalidInput for no models, another number of features, or a model without familiarity.
    """

def compute_disparity(
    left: numpy.typing.NDArray[numpy.uint8],
    right: numpy.typing.NDArray[numpy.uint8],
    *,
    reliable: bool = ...,
    instance_ids: numpy.typing.NDArray[numpy.uint8] | numpy.typing.NDArray[numpy.bool_] | None = ...,
    max_disparity_px: int = ...,
    half_resolution: bool = ...,
    block_px: int = ...,
    uniqueness_percent: float = ...,
    speckle_px: int = ...,
    left_right_px: float = ...,
    texture_sigmas: float = ...,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Disparity (px) of the left view of a rectified pair: (H, W) float32, NaN where unknown (METHOD 1).

    left, right: uint8 images of the same size, RGB (H, W, 3) or grey (H, W).
    reliable: keep only what is consistent from right to left, and textured.
    instance_ids: uint8 or bool (H, W), match the pixels that are not 0 again at full resolution.
    max_disparity_px: 0 means a quarter of the width.
    Raises InvalidInput if the sizes differ or an option is out of range.
    """

def describe_labelled_view(
    view: LabelledView,
    *,
    object_px: int = ...,
    margin_px: int = ...,
    refine_mask: bool = ...,
    canny_low: float = ...,
    canny_high: float = ...,
    samples: int = ...,
    mask_margin_px: int = ...,
    angular_bins: int = ...,
    radial_bins: int = ...,
    inner_radius: float = ...,
    outer_radius: float = ...,
    relative_to_gradient: bool = ...,
    outline_px: int = ...,
    patch_px: int = ...,
    windows_patches: tuple[int, int, int] = ...,
) -> LabelledPatches:
    """
    The patches of a labelled view; a patch is positive if it overlaps the labelled region (III-C).
    """

def describe_view(
    view: FovealView,
    *,
    object_px: int = ...,
    margin_px: int = ...,
    refine_mask: bool = ...,
    canny_low: float = ...,
    canny_high: float = ...,
    samples: int = ...,
    mask_margin_px: int = ...,
    angular_bins: int = ...,
    radial_bins: int = ...,
    inner_radius: float = ...,
    outer_radius: float = ...,
    relative_to_gradient: bool = ...,
    outline_px: int = ...,
    patch_px: int = ...,
    windows_patches: tuple[int, int, int] = ...,
) -> PatchDescriptors:
    """
    Contour, shape contexts and patch descriptors of a foveal view. A model's own options are **model.descriptor.
    """

def descriptor_defaults() -> dict[str, dict[str, typing.Any]]:
    """
    The options of describe_view by the stage that takes them, with their defaults.
    """

def detect_grasps(
    left: numpy.typing.NDArray[numpy.uint8],
    right: numpy.typing.NDArray[numpy.uint8],
    camera: StereoCamera,
    model: GraspModel | collections.abc.Sequence[GraspModel],
    *,
    mask: numpy.typing.NDArray[numpy.uint8] | numpy.typing.NDArray[numpy.bool_] | None = ...,
    max_grasps: int = ...,
    threads: int = ...,
    approach_threshold: float = ...,
    min_probability: float = ...,
    min_familiarity: float | None = ...,
    cues: str = ...,
    max_objects: int = ...,
    min_height_m: float = ...,
    max_height_m: float = ...,
    min_extent_m: float = ...,
    max_extent_m: float = ...,
    min_reliable_share: float = ...,
    cell_m: float = ...,
    fixation_px: tuple[float, float] | None = ...,
    roi_px: tuple[int, int, int, int] | None = ...,
    table: TablePlane | tuple[float, float, float, float] | None = ...,
    gravity: tuple[float, float, float] | None = ...,
    max_disparity_px: int = ...,
    half_resolution: bool = ...,
    block_px: int = ...,
    uniqueness_percent: float = ...,
    speckle_px: int = ...,
    left_right_px: float = ...,
    texture_sigmas: float = ...,
    max_points: int = ...,
    neighbour_ratio: float = ...,
    window_px: int = ...,
    search_px: float = ...,
    min_correlation: float = ...,
    max_opening_m: float = ...,
    opening_margin_m: float = ...,
    finger_length_m: float = ...,
    finger_width_m: float = ...,
    finger_thickness_m: float = ...,
    finger_spread_m: float = ...,
    palm_radius_m: float = ...,
    tip_beyond_m: float = ...,
    table_clearance_m: float = ...,
    retreat_m: float = ...,
) -> Detection:
    """
    The whole method: from a stereo pair to ranked grasp configurations.

    left, right: uint8 images of the same size, RGB (H, W, 3) or grey (H, W), rectified first if camera.raw says how.
    model: one, or several with familiarity that vote on each object, as in choose_model.
    mask: uint8 or bool (H, W) instance ids of the left rectified view, used instead of the segmentation.
    cues: 'disparity', 'plane' or 'colour'; each adds to the one before (Fig. 2).
    fixation_px, roi_px, table, gravity: where to look, and what is known of the rig, as in segment_objects.
    max_grasps: of each object. threads: the result is the same for any number.
    approach_threshold: φ of Eq. 3, share of the minor semi-axis in the image.
    min_probability: of both views together; what is less likely is no grasp.
    min_familiarity: what an object is less familiar than, 0 to 1, is unfamiliar and has no grasps; 0 refuses none.
    None: 0.03 if several models vote, 0 for one.
    Finding nothing is an answer. Raises InvalidInput for unusable images, calibration or options.
    """

def draw_detection(
    detection: Detection,
    *,
    max_grasps: int = ...,
    contour: bool = ...,
    probabilities: bool = ...,
    pose: bool = ...,
    min_width_px: int = ...,
    max_opening_m: float = ...,
    opening_margin_m: float = ...,
    finger_length_m: float = ...,
    finger_width_m: float = ...,
    finger_thickness_m: float = ...,
    finger_spread_m: float = ...,
    palm_radius_m: float = ...,
    tip_beyond_m: float = ...,
    table_clearance_m: float = ...,
    retreat_m: float = ...,
) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Overlay of the left view: segments, contour, probabilities, hands in perspective: uint8 RGB (H, W, 3).

    max_grasps: drawn for each object; a hand for the first, axes for the others (x closing red, y green, z approach
    blue, grey where infeasible). min_width_px: smaller images are enlarged.
    """

def draw_segmentation(
    left: numpy.typing.NDArray[numpy.uint8],
    right: numpy.typing.NDArray[numpy.uint8],
    camera: StereoCamera,
    *,
    panel_px: int = ...,
    cues: str = ...,
    max_objects: int = ...,
    min_height_m: float = ...,
    max_height_m: float = ...,
    min_extent_m: float = ...,
    max_extent_m: float = ...,
    min_reliable_share: float = ...,
    cell_m: float = ...,
    fixation_px: tuple[float, float] | None = ...,
    roi_px: tuple[int, int, int, int] | None = ...,
    table: TablePlane | tuple[float, float, float, float] | None = ...,
    gravity: tuple[float, float, float] | None = ...,
    max_disparity_px: int = ...,
    half_resolution: bool = ...,
    block_px: int = ...,
    uniqueness_percent: float = ...,
    speckle_px: int = ...,
    left_right_px: float = ...,
    texture_sigmas: float = ...,
) -> numpy.typing.NDArray[numpy.uint8]:
    """
    A picture that explains how a scene is segmented (Fig. 2): uint8 RGB.

    Eight panels, the longer side of each panel_px: the hypotheses of the level cues, the disparity, a grid on the table
    plane, the heights above it, the three cue levels side by side, and the objects in numbers. The arguments and
    options are those of segment_objects. Raises InvalidInput for unusable images or options.
    """

def evaluate_model(model: GraspModel, views: collections.abc.Sequence[LabelledView]) -> list[ClassEvaluation]:
    """
    Evaluate with the true masks: one row for each class and, if there is more than one, a last row 'all'.
    """

def expected_calibration_error(
    probabilities: numpy.typing.NDArray[numpy.float64],
    labels: numpy.typing.NDArray[numpy.integer],
    bins: int | None = ...,
) -> float:
    """
    Expected calibration error over equal-width bins of the probability.
    """

def explain_grasp(
    detection: Detection,
    model: GraspModel,
    *,
    object_id: int | None = ...,
    rank: int = ...,
    max_images: int = ...,
) -> GraspExplanation:
    """
    Why there is a grasp: what its patch in the left view rests on.

    model: the one that the detection was made with. object_id: DetectedObject.id; by default the first object. rank:
    of its grasps, from 1. max_images: nearest training images of each label.
    Each contour sample is left out exactly, from the windows that hold it and from the histograms of all others; only
    the mean pairwise distance stays. Each bin is put to its training mean; one by one, so the effects do not add up to f.
    Raises InvalidInput if there is no such grasp, or the model is another.
    """

def find_grasp_points(
    patches: PatchDescriptors,
    probabilities: numpy.typing.NDArray[numpy.float64],
    *,
    max_points: int = ...,
    neighbour_ratio: float = ...,
) -> list[GraspPoint]:
    """
    Patches that are local maxima of the response and whose neighbours carry values close to theirs (III-D, IV).

    probabilities: float64 (M,) of the patches. The highest first. neighbour_ratio: mean of the neighbours, as a
    share of the centre's value.
    """

def foveal_view(
    image: numpy.typing.NDArray[numpy.uint8],
    mask: numpy.typing.NDArray[numpy.uint8] | numpy.typing.NDArray[numpy.bool_],
    *,
    object_px: int = ...,
    margin_px: int = ...,
    refine_mask: bool = ...,
) -> FovealView:
    """
    The foveal view of the object that the mask marks (METHOD 2).

    image: uint8, RGB (H, W, 3) or grey (H, W). mask: uint8 or bool (H, W), > 0 = object.
    object_px: longer side of the object in the view. Raises InvalidInput for an empty mask or another size.
    """

def image_names(views: collections.abc.Sequence[LabelledView]) -> dict[int, str]:
    """
    The name of each group's image, for train_model(image_names=...): LabelledView.image_name, or 'image N' with the group's number where that is empty or may not stand in a model's file.
    """

def load_dataset(
    path: os.PathLike | str | bytes,
    *,
    classes: collections.abc.Sequence[str] = ...,
    views: str = ...,
    format: str = ...,
    object_labels: collections.abc.Sequence[str] = ...,
    grasp_labels: collections.abc.Sequence[str] = ...,
    images: collections.abc.Sequence[str] = ...,
) -> list[LabelledView]:
    """
    The labelled views of a data set (docs/dataset-format.md). classes: only these; empty for all. views: 'left' or 'both'. format: 'graspctx', 'saxena', 'labelme' or 'coco'. object_labels, grasp_labels: what labelme and COCO call them. images: only these, by LabelledView.image_name; empty for all. Raises InvalidInput naming the file.
    """

def load_model(name_or_path: os.PathLike | str | bytes) -> GraspModel:
    """
    Load a shipped model by its name ('mug', 'pencil', …), or a .safetensors file. A file is data: loading executes nothing. Raises InvalidInput naming the file and what is wrong with it.
    """

def patch_descriptors(
    contour: Contour,
    image_size: tuple[int, int],
    *,
    angular_bins: int = ...,
    radial_bins: int = ...,
    inner_radius: float = ...,
    outer_radius: float = ...,
    relative_to_gradient: bool = ...,
    outline_px: int = ...,
    patch_px: int = ...,
    windows_patches: tuple[int, int, int] = ...,
) -> PatchDescriptors:
    """
    One descriptor for each 10×10 patch that holds contour samples (III-B).

    The shape contexts of all samples in a window, summed, at three scales centred at the patch, each L1-normalised
    and square-rooted, concatenated: 120 numbers by default. image_size: (width, height) of the view; the grid
    starts at its (0, 0). Raises InvalidInput for points outside, or an option out of range.
    """

def read_image(path: os.PathLike | str | bytes) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Read a PNG or JPEG file: uint8 RGB (H, W, 3), or (H, W) if the file is grey. Raises InvalidInput naming the file if it is missing, damaged or too large.
    """

def rectify(
    left: numpy.typing.NDArray[numpy.uint8], right: numpy.typing.NDArray[numpy.uint8], camera: StereoCamera
) -> tuple[numpy.typing.NDArray[numpy.uint8], numpy.typing.NDArray[numpy.uint8]]:
    """
    Check a pair of images against the camera, and rectify it if camera.raw says how (METHOD 1).

    Images are uint8, RGB (H, W, 3) or grey (H, W). Raises InvalidInput if sizes differ from each other or from the calibration's.
    """

def robust_descriptor() -> dict:
    """
    The options of describe_view that models are trained with by default.

    The defaults of describe_view are the descriptor of the paper. Robust is what a mask refined by colour and a second
    count of the outline make of it: 240 numbers a patch (docs/recipe.md). Use: describe_view(view, **robust_descriptor()).
    """

def roc_area(
    scores: numpy.typing.NDArray[numpy.float64], labels: numpy.typing.NDArray[numpy.integer]
) -> float:
    """
    Area under the ROC curve, ties as one half; NaN if one class is missing. scores: float64 (M,), labels: integers (M,), 0 or 1.
    """

def sample_contour(
    image: numpy.typing.NDArray[numpy.uint8],
    mask: numpy.typing.NDArray[numpy.uint8] | numpy.typing.NDArray[numpy.bool_] | None = ...,
    *,
    canny_low: float = ...,
    canny_high: float = ...,
    samples: int = ...,
    mask_margin_px: int = ...,
) -> Contour:
    """
    Canny on the unmasked image, the edges inside the mask, sampled evenly along the edges (III-B, Fig. 3).

    image: uint8, RGB (H, W, 3) or grey (H, W). mask: uint8 or bool (H, W), > 0 = object; None for the whole image.
    samples: 0 for every contour pixel. Raises InvalidInput if the sizes differ or an option is out of range.
    """

def segment_objects(
    left: numpy.typing.NDArray[numpy.uint8],
    right: numpy.typing.NDArray[numpy.uint8],
    camera: StereoCamera,
    *,
    cues: str = ...,
    max_objects: int = ...,
    min_height_m: float = ...,
    max_height_m: float = ...,
    min_extent_m: float = ...,
    max_extent_m: float = ...,
    min_reliable_share: float = ...,
    cell_m: float = ...,
    fixation_px: tuple[float, float] | None = ...,
    roi_px: tuple[int, int, int, int] | None = ...,
    table: TablePlane | tuple[float, float, float, float] | None = ...,
    gravity: tuple[float, float, float] | None = ...,
    max_disparity_px: int = ...,
    half_resolution: bool = ...,
    block_px: int = ...,
    uniqueness_percent: float = ...,
    speckle_px: int = ...,
    left_right_px: float = ...,
    texture_sigmas: float = ...,
) -> numpy.typing.NDArray[numpy.uint8]:
    """
    Find the objects of a scene without knowing what they are: (H, W) uint8 instance ids, 0 = background (III-A).

    left, right: uint8 images, RGB (H, W, 3) or grey (H, W), rectified first if camera.raw says how.
    cues: 'disparity', 'plane' or 'colour'; each adds to the one before (Fig. 2).
    fixation_px: (u, v), look only at the object at this pixel of the left view. roi_px: (x, y, width, height), only
    at the object in this box.
    table: the known plane of a fixed rig, a TablePlane or (nx, ny, nz, offset_m) with a unit normal towards the
    camera. gravity: (x, y, z) where things fall, in the camera frame, for cameras that are not upright.
    No object is an answer. Raises InvalidInput for unusable images or options.
    """

def segment_scene(
    left: numpy.typing.NDArray[numpy.uint8],
    right: numpy.typing.NDArray[numpy.uint8],
    camera: StereoCamera,
    *,
    cues: str = ...,
    max_objects: int = ...,
    min_height_m: float = ...,
    max_height_m: float = ...,
    min_extent_m: float = ...,
    max_extent_m: float = ...,
    min_reliable_share: float = ...,
    cell_m: float = ...,
    fixation_px: tuple[float, float] | None = ...,
    roi_px: tuple[int, int, int, int] | None = ...,
    table: TablePlane | tuple[float, float, float, float] | None = ...,
    gravity: tuple[float, float, float] | None = ...,
    max_disparity_px: int = ...,
    half_resolution: bool = ...,
    block_px: int = ...,
    uniqueness_percent: float = ...,
    speckle_px: int = ...,
    left_right_px: float = ...,
    texture_sigmas: float = ...,
) -> Segmentation:
    """
    As segment_objects, with the table plane, the heights above it, each object's hypothesis and warnings.
    """

def shape_contexts(
    points: numpy.typing.NDArray[numpy.float32],
    *,
    gradients: numpy.typing.NDArray[numpy.float32] | None = ...,
    border_distances: numpy.typing.NDArray[numpy.float32] | None = ...,
    angular_bins: int = ...,
    radial_bins: int = ...,
    inner_radius: float = ...,
    outer_radius: float = ...,
    relative_to_gradient: bool = ...,
    outline_px: int = ...,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Log-polar histograms of the vectors from each point to all the others (III-B; Belongie et al. 2002).

    points: float32 (N, 2) px. Returns float32 counts (N, angular_bins · radial_bins), angle-major
    (angle * radial_bins + radius); angle bin 0 starts at +u and turns towards +v. Radii are in units of the mean
    pairwise distance; nearer than inner_radius falls into the first ring, farther than outer_radius into none.
    gradients: float32 (N,) rad, needed for relative_to_gradient only. border_distances: float32 (N,) px, needed for
    outline_px only: points at most that far inside the mask are its outline, and (N, 2 · angular_bins · radial_bins)
    counts come back, of the vectors to all points, then of those to points of the outline.
    """

def shipped_models() -> list[str]:
    """
    Names of the shipped models.
    """

def train_model(
    features: numpy.typing.NDArray[numpy.float32],
    labels: numpy.typing.NDArray[numpy.integer],
    groups: numpy.typing.NDArray[numpy.integer],
    *,
    name: str = ...,
    classes: collections.abc.Sequence[str] = ...,
    provenance: collections.abc.Mapping[str, str] = ...,
    descriptor: dict[str, typing.Any] = ...,
    image_names: collections.abc.Mapping[int, str] = ...,
    views: numpy.typing.NDArray[numpy.integer] | None = ...,
    base: GraspModel | None = ...,
    progress: collections.abc.Callable[[float, str], None] | None = ...,
    svm_c: collections.abc.Sequence[float] = ...,
    gamma_times_dimension: collections.abc.Sequence[float] = ...,
    folds: int = ...,
    max_positives_per_group: int = ...,
    max_negatives_per_group: int = ...,
    max_rows: int = ...,
    max_search_rows: int = ...,
    seed: int = ...,
) -> GraspModel:
    """
    Train a model (III-C): C and γ by cross-validation grouped by image, the sigmoid on held-out images.

    features: float32 (M, D). labels: integers (M,), 0 or 1. groups: integers (M,), the image of each row.
    name, classes, provenance: stored with the model. descriptor: the options of describe_view that the features
    were made with, where they differ from the defaults.
    image_names: of the groups; with them the model keeps its training_images, which explain_grasp names.
    views: integers (M,), the view of each row, as in TrainingSet.views: the model learns what objects are familiar
    from them, GraspModel.familiarity. None: it does not.
    base: a model to start from, for few images: its support vectors are trained on together with the rows, which
    must be of its descriptor, and never held out; C and γ are its own unless given, more rows of an image count.
    progress: called with the share done and what is being done; what it raises ends the training.
    gamma_times_dimension: γ = value / D. The search is over all pairs of it and svm_c.
    Raises InvalidInput for sizes that differ, other labels, a single class, fewer groups than folds, or features
    that are not finite.
    """

def wilson_interval(
    successes: typing.SupportsInt | typing.SupportsIndex, trials: typing.SupportsInt | typing.SupportsIndex
) -> tuple[float, float]:
    """
    95 % interval (low, high) of a share.
    """

def write_image(path: str | os.PathLike[str], image: numpy.typing.NDArray[numpy.uint8]) -> None:
    """
    Write an RGB (H, W, 3) or grey (H, W) uint8 image as PNG or JPEG, all or nothing.
    """

__version__: str
