"""What a scorer of patches reaches on labelled views: precision, ROC area, the best patch, and chance."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from report import Estimate, share

LARGE_LABEL_SHARE = 0.02  # of the object
BORDER_SHARE = 0.5  # of a patch
_RESAMPLES = 1000


@dataclass(frozen=True)
class ScoredView:
    """The patches of one view of one object, and what a classifier makes of them.

    Attributes:
        scores: (M,) the higher, the sooner a grasping point; none of an object that was not found.
        labels: (M,) 1 if the patch overlaps the labelled region.
        label_share: (M,) of the patch's pixels.
        visible_label_share: labelled pixels over the object's, by its true mask.
        has_label: a patch of the true mask is labelled. Views without count for precision, not for top-1.
    """

    scores: np.ndarray
    labels: np.ndarray
    label_share: np.ndarray
    visible_label_share: float
    has_label: bool

    @property
    def hit(self) -> bool:
        """The best patch is labelled."""
        return len(self.scores) > 0 and bool(self.labels[np.argmax(self.scores)])

    @property
    def chance(self) -> float:
        """Share of the patches that are labelled: how often one drawn at random is."""
        return float(np.mean(self.labels)) if len(self.labels) else 0.0

    def without_border(self) -> ScoredView:
        """The view without the patches that are labelled by less than half."""
        inner = (self.labels == 0) | (self.label_share >= BORDER_SHARE)
        return ScoredView(
            self.scores[inner],
            self.labels[inner],
            self.label_share[inner],
            self.visible_label_share,
            self.has_label,
        )


class Ranking:
    """The patches of many views from the highest score down, to be counted with a weight for each view."""

    def __init__(self, views: Sequence[ScoredView]) -> None:
        scores = np.concatenate([view.scores for view in views])
        labels = np.concatenate([view.labels for view in views]).astype(float)
        order = np.argsort(-scores, kind="stable")
        scores, self._labels = scores[order], labels[order]
        self._view = np.repeat(np.arange(len(views)), [len(view.scores) for view in views])[order]
        self._last_of_tie = np.append(np.flatnonzero(np.diff(scores)), len(scores) - 1)

    def _counts(self, weights):
        """Weighted positives and negatives down to the end of each tie, (T,) each."""
        weights = weights[self._view]
        positives = np.cumsum(weights * self._labels)[self._last_of_tie]
        return positives, np.cumsum(weights)[self._last_of_tie] - positives

    def average_precision(self, weights: np.ndarray) -> float:
        """Area under the precision-recall curve by steps, as gc.average_precision; NaN without positives.

        Args:
            weights: (V,) how often each view is counted.
        """
        positives, negatives = self._counts(weights)
        steps = np.diff(positives, prepend=0)
        taken = np.maximum(positives + negatives, 1e-12)
        return float((steps * positives / taken).sum() / positives[-1]) if positives[-1] > 0 else np.nan

    def roc_area(self, weights: np.ndarray) -> float:
        """Area under the ROC curve, ties as one half, as gc.roc_area; NaN if one class is missing."""
        positives, negatives = self._counts(weights)
        above = positives - np.diff(positives, prepend=0) / 2
        pairs = positives[-1] * negatives[-1]
        return float((np.diff(negatives, prepend=0) * above).sum() / pairs) if pairs > 0 else np.nan

    def prior(self, weights: np.ndarray) -> float:
        """Share of the patches that are labelled: the average precision of a scorer that knows nothing."""
        positives, negatives = self._counts(weights)
        return float(positives[-1] / (positives[-1] + negatives[-1]))


def resampled(count: int, statistic: Callable[[np.ndarray], float]) -> Estimate:
    """A statistic of `count` views, and its interval over 1000 seeded resamples of whole views.

    Args:
        statistic: of weights, (count,), that say how often each view is counted.
    """
    rng = np.random.default_rng(0)
    drawn = [
        statistic(np.bincount(rng.integers(0, count, count), minlength=count).astype(float))
        for _ in range(_RESAMPLES)
    ]
    low, high = np.nanpercentile(drawn, [2.5, 97.5])
    return Estimate(float(statistic(np.ones(count))), float(low), float(high), count)


def over_views(views: Sequence[ScoredView], statistic: Callable[[Ranking, np.ndarray], float]) -> Estimate:
    """A statistic of all patches of all views, with its interval.

    Args:
        statistic: Ranking.average_precision, Ranking.roc_area or Ranking.prior.
    """
    return resampled(len(views), functools.partial(statistic, Ranking(views)))


def estimates(views: Sequence[ScoredView]) -> dict[str, Estimate]:
    """All figures of one scorer on one class, by measure; those that nothing can be said of are left out."""
    views = list(views)
    found = {}
    scored = [view for view in views if len(view.scores)]
    if any(view.labels.any() for view in scored):
        inner = [view.without_border() for view in scored]
        found["ap"] = over_views(scored, Ranking.average_precision)
        if any(view.labels.any() for view in inner):
            found["ap_border_ignored"] = over_views(inner, Ranking.average_precision)
            found["prior_border_ignored"] = over_views(inner, Ranking.prior)
        if not all(view.labels.all() for view in scored):
            found["auc"] = over_views(scored, Ranking.roc_area)
        found["prior"] = over_views(scored, Ranking.prior)
    labelled = [view for view in views if view.has_label]
    large = [view for view in labelled if view.visible_label_share > LARGE_LABEL_SHARE]
    for measure, chosen in (("top1", labelled), ("top1_large_label", large)):
        if chosen:
            found[measure] = share(sum(view.hit for view in chosen), len(chosen))
    for measure, chosen in (("chance", labelled), ("chance_large_label", large)):
        if chosen:
            found[measure] = Estimate(float(np.mean([v.chance for v in chosen])), None, None, len(chosen))
    return found
