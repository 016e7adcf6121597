"""Classifiers of patches, for any descriptor: what answers with P(g = 1 | D) and travels between processes.

`train_rbf` is the training of graspctx, `train_logistic` is scikit-learn's on the same rows. Both standardise
each dimension, and choose by the average precision on images that were held out.
"""

from __future__ import annotations

from dataclasses import dataclass

import graspctx as gc
import numpy as np

FOLDS = 5
LOGISTIC_C = (1e-3, 1e-2, 1e-1)
_SEARCH_ROWS = 4000  # of whole images, for the choice of C
_BLOCK_ROWS = 4096


@dataclass(frozen=True)
class Rbf:
    """A GraspModel's numbers, for features of another width than a shape context's.

    Attributes:
        mean, scale: (D,) of the standardisation.
        support_vectors: (S, D) standardised.
        coefficients: (S,).
        gamma, rho, sigmoid_a, sigmoid_b: as in GraspModel.
    """

    mean: np.ndarray
    scale: np.ndarray
    support_vectors: np.ndarray
    coefficients: np.ndarray
    gamma: float
    rho: float
    sigmoid_a: float
    sigmoid_b: float

    @classmethod
    def of(cls, model: gc.GraspModel) -> Rbf:
        """The numbers of a model."""
        return cls(*(getattr(model, name) for name in cls.__dataclass_fields__))

    def predict_probability(self, features: np.ndarray) -> np.ndarray:
        """P(g = 1 | D) of each row: (M, D) features give (M,) float64."""
        vectors = self.support_vectors.astype(np.float64)
        values = [np.zeros(0)]
        for first in range(0, len(features), _BLOCK_ROWS):
            rows = (features[first : first + _BLOCK_ROWS].astype(np.float64) - self.mean) / self.scale
            squares = (rows**2).sum(1)[:, None] + (vectors**2).sum(1) - 2 * rows @ vectors.T
            values.append(np.exp(-self.gamma * np.maximum(squares, 0)) @ self.coefficients - self.rho)
        return _logistic(-self.sigmoid_a * np.concatenate(values) - self.sigmoid_b)


@dataclass(frozen=True)
class Logistic:
    """Logistic regression on standardised features.

    Attributes:
        mean, scale: (D,) of the standardisation.
        weights, bias: (D,) and a number.
    """

    mean: np.ndarray
    scale: np.ndarray
    weights: np.ndarray
    bias: float

    def predict_probability(self, features: np.ndarray) -> np.ndarray:
        """P(g = 1 | D) of each row: (M, D) features give (M,) float64."""
        return _logistic((features - self.mean) / self.scale @ self.weights + self.bias)


def _logistic(values):
    return np.exp(-np.logaddexp(0, -values))


def train_rbf(
    features: np.ndarray, labels: np.ndarray, groups: np.ndarray, descriptor: dict | None = None
) -> gc.GraspModel:
    """An SVM with an RBF kernel and Platt's sigmoid, as graspctx trains its own models.

    Args:
        features: (R, D) float32.
        labels, groups: (R,) 0 or 1, and the image of each row.
        descriptor: options of describe_view, where they differ from the defaults.
    """
    return gc.train_model(features, labels, groups, folds=FOLDS, descriptor=descriptor or {})


def train_logistic(features: np.ndarray, labels: np.ndarray, groups: np.ndarray) -> Logistic:
    """Logistic regression on all rows, its C from LOGISTIC_C. Arguments as for train_rbf."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):  # several threads wait for each other longer than they compute
        return _train_logistic(features, labels, groups)


def _train_logistic(features, labels, groups):
    searched = _whole_groups(groups, _SEARCH_ROWS)
    held_out = {}
    for c in LOGISTIC_C:
        scores, truth = _hold_out(features[searched], labels[searched], groups[searched], c)
        held_out[c] = gc.average_precision(scores, truth)
    return _fit(features, labels, max(held_out, key=held_out.get))


def _fit(features, labels, c):
    from sklearn.linear_model import LogisticRegression

    mean, scale = features.mean(0, dtype=np.float64), features.std(0, dtype=np.float64)
    scale[scale == 0] = 1
    model = LogisticRegression(C=c, max_iter=150, tol=1e-3)
    model.fit(((features - mean) / scale).astype(np.float32), labels)
    return Logistic(mean, scale, model.coef_[0].astype(np.float64), float(model.intercept_[0]))


def _hold_out(features, labels, groups, c):
    from sklearn.model_selection import GroupKFold

    scores, truth = [], []
    for train, test in GroupKFold(FOLDS).split(features, labels, groups):
        if 0 < labels[train].sum() < len(train):
            scores.append(_fit(features[train], labels[train], c).predict_probability(features[test]))
            truth.append(labels[test])
    return np.concatenate(scores), np.concatenate(truth)


def _whole_groups(groups, limit):
    """Rows of as many whole groups, in a seeded order, as have no more than `limit` rows: (R,) bool."""
    names, sizes = np.unique(groups, return_counts=True)
    order = np.random.default_rng(0).permutation(len(names))
    fitting = np.cumsum(sizes[order]) <= limit
    fitting[: min(FOLDS, len(order))] = True
    return np.isin(groups, names[order[fitting]])
