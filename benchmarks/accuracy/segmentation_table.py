"""The rows of the segmentation benchmark as Markdown tables, and which goals they reach."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import no_objects
import report
from segmentation_axes import AXES, MAIN_AXES

GOALS = {
    **{("recall", axis): (">=", 0.95) for axis in AXES[:-1]},
    **{("iou_median", axis): (">=", 0.90) for axis in AXES[:-1]},
    **{("false_per_scene", axis): ("<=", 0.05) for axis in AXES[:-1]},
    ("recall", "low"): (">=", 0.92),
    ("iou_median", "low"): (">=", 0.80),
    ("holes_filled", "all"): ("<=", 0.20),
    ("plane_angle_p90_deg", "textured"): ("<=", 0.3),
    ("plane_height_p90_mm", "textured"): ("<=", 1.0),
    ("plane_angle_p90_deg", "faint"): ("<=", 1.0),
    ("plane_height_p90_mm", "faint"): ("<=", 4.0),
}
"""What the best level is to reach. It is to say no in every case of saying_no, and recall and IoU are to rise
with the cues on every axis."""
LEAST_TO_JUDGE = 20
"""Objects that an axis needs for its rise to be judged."""


def print_tables(rows: list[dict], cues: tuple[str, ...]) -> None:
    """Print the rows as Markdown tables: the last level of cues whole, then what each level adds."""
    by_key = {(row["measure"], row.get("cues"), row.get("axis"), row.get("stage")): row for row in rows}
    axes = list(dict.fromkeys(row["axis"] for row in rows if row["measure"] == "recall"))
    best = cues[-1]

    def cell(measure, axis, digits=2, level=best, stage=None):
        return report.figure(by_key.get((measure, level, axis, stage)), digits)

    def count(axis):
        return by_key.get(("recall", best, axis, None), {}).get("n", 0)

    main = [axis for axis in axes if axis in MAIN_AXES]
    if main:
        print(f"\nAt the level `{best}`:\n")
        names = ["axis", "objects", "recall", "median IoU", "false a scene", "on nothing"]
        names += ["holes filled", "plane angle p90, °", "plane height p90, mm", "plane found"]
        measures = [
            ("recall", 2),
            ("iou_median", 2),
            ("false_per_scene", 2),
            ("false_on_nothing_per_scene", 2),
        ]
        measures += [("holes_filled", 2), ("plane_angle_p90_deg", 2), ("plane_height_p90_mm", 1)]
        measures += [("plane_found", 2)]
        lines = [
            [axis, count(axis), *(cell(measure, axis, digits) for measure, digits in measures)]
            for axis in main
        ]
        print(report.table(names, lines))

        print("\nDepth over the found objects, and time:\n")
        names = ["axis", "depth error median, mm", "p90, mm", "depth known", "stereo, ms", "segmentation, ms"]
        lines = [
            [
                axis,
                cell("depth_error_median_mm", axis),
                cell("depth_error_p90_mm", axis, 1),
                cell("depth_known", axis),
                cell("time_ms", axis, 0, stage="stereo"),
                cell("time_ms", axis, 0, stage="segmentation"),
            ]
            for axis in main
        ]
        print(report.table(names, lines))

    if main and len(cues) > 1:
        print(f"\nEach level, {', '.join(cues)}:\n")
        measures = {"recall": 2, "iou_median": 2, "false_per_scene": 2, "holes_filled": 2}

        def steps(measure, axis, digits):
            found = [by_key.get((measure, level, axis, None)) for level in cues]
            return " → ".join(report.number(row and row["value"], digits) for row in found)

        lines = [
            [axis, *(steps(measure, axis, digits) for measure, digits in measures.items())] for axis in main
        ]
        print(report.table(["axis", "recall", "median IoU", "false a scene", "holes filled"], lines))

    difficulty = [axis for axis in axes if axis not in main]
    if difficulty:
        print(f"\nBy what makes scenes and objects hard, `{best}`:\n")
        lines = [
            [
                axis,
                count(axis),
                *(cell(measure, axis) for measure in ("recall", "iou_median", "false_per_scene")),
            ]
            for axis in difficulty
        ]
        print(report.table(["axis", "objects", "recall", "median IoU", "false a scene"], lines))

    answers = {(row["case"], row["cues"]): row for row in rows if row["measure"] == "saying_no"}
    cases = [case for case in no_objects.CASES if (case, best) in answers]
    if cases:
        print("\nSaying no: share of pairs without an object that are answered with none:\n")
        lines = [
            [case, answers[case, best]["n"], *(report.figure(answers[case, level]) for level in cues)]
            for case in cases
        ]
        print(report.table(["case", "pairs", *cues], lines))

    shares = {row["measure"]: row for row in rows if row["measure"] in ("objects_left_out", "cut_by_border")}
    if shares:
        left_out, cut = (
            f"{round(row['value'] * row['n'])} of {row['n']}"
            for row in (shares["objects_left_out"], shares["cut_by_border"])
        )
        print(f"\nObjects too little of which is seen to count: {left_out}; cut by the border: {cut}.")

    judged, unmet = unmet_goals(rows, cues)
    print(f"\nGoals reached: {judged - len(unmet)} of {judged}.")
    if unmet:
        print("\nNot reached:\n")
        print(report.table(["measure", "cues", "axis or case", "value", "goal"], unmet, left=3))


def unmet_goals(rows: list[dict], cues: tuple[str, ...]) -> tuple[int, list[tuple[str, str, str, str, str]]]:
    """How many goals could be judged, and of those not reached (measure, cues, axis, value, goal)."""
    values = {
        (row["measure"], row.get("cues"), row.get("axis", row.get("case"))): row["value"] for row in rows
    }
    judged, unmet = 0, []

    def judge(reached, *cells):
        nonlocal judged
        judged += 1
        if not reached:
            unmet.append(cells)

    for (measure, axis), (sign, goal) in GOALS.items():
        value = values.get((measure, cues[-1], axis))
        if value is not None:
            reached = value >= goal if sign == ">=" else value <= goal
            judge(reached, measure, cues[-1], axis, f"{value:.3f}", f"{sign} {goal:g}")
    for case in no_objects.CASES:
        value = values.get(("saying_no", cues[-1], case))
        if value is not None:
            judge(value == 1, "saying_no", cues[-1], case, f"{value:.3f}", "1")
    for measure in ("recall", "iou_median"):
        enough = (row for row in rows if row["measure"] == measure and row["n"] >= LEAST_TO_JUDGE)
        for axis in dict.fromkeys(row["axis"] for row in enough):
            steps = [values.get((measure, level, axis)) for level in cues]
            if len(cues) > 1 and None not in steps:
                rises = sorted(steps) == steps and steps[0] < steps[-1]
                said = " -> ".join(f"{step:.2f}" for step in steps)
                judge(rises, measure, " -> ".join(cues), axis, said, "rises")
    return judged, unmet
