"""A network with one hidden layer that classifies feature vectors."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import log_softmax

HIDDEN, DECAY, ITERATIONS = 48, 1e-2, 300
"""Neurons of the hidden layer, weight of the squared weights, and steps of the optimiser. With a
decay of 1e-3 unseen objects of the recorded data were up to 10 % worse."""
CLIP = 5.0
"""Maximum feature, in standard deviations of the training set."""


def train_network(
    values: NDArray[np.float64],
    labels: NDArray[np.int64],
    seed: int,
    *,
    classes: int,
    decay: float = DECAY,
    iterations: int = ITERATIONS,
) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Train on M feature vectors, and return the function from features to class scores.

    Parameters
    ----------
    values
        (M, K). They are brought to mean 0 and standard deviation 1, and limited.
    labels
        (M,), 0..classes - 1.
    seed
        Seed of the first weights.
    classes
        Number of classes.
    decay, iterations
        Weight of the squared weights, and steps of the optimiser.
    """
    rng = np.random.default_rng(seed)
    centre, spread = values.mean(axis=0), values.std(axis=0) + 1e-9
    known = np.clip((values - centre) / spread, -CLIP, CLIP)
    inputs = values.shape[1]
    start = np.concatenate(
        [
            rng.normal(0, inputs**-0.5, inputs * HIDDEN),
            np.zeros(HIDDEN),
            rng.normal(0, HIDDEN**-0.5, HIDDEN * classes),
            np.zeros(classes),
        ]
    )
    found = minimize(
        network_loss,
        start,
        args=(known, labels, decay),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": iterations},
    )
    first, bias, second, shift = _layers(found.x, inputs)

    def scores(given: NDArray[np.float64]) -> NDArray[np.float64]:
        scaled = np.clip((given - centre) / spread, -CLIP, CLIP)
        return np.tanh(scaled @ first + bias) @ second + shift

    return scores


def network_loss(
    weights: NDArray[np.float64],
    values: NDArray[np.float64],
    labels: NDArray[np.int64],
    decay: float = DECAY,
) -> tuple[float, NDArray[np.float64]]:
    """Return the cross-entropy with weight decay, and its gradient."""
    first, bias, second, shift = _layers(weights, values.shape[1])
    hidden = np.tanh(values @ first + bias)
    logs = log_softmax(hidden @ second + shift, axis=1)
    rows = np.arange(len(labels))
    loss = -float(logs[rows, labels].mean())
    loss += 0.5 * decay * float((first**2).sum() + (second**2).sum())
    wrong = np.exp(logs)
    wrong[rows, labels] -= 1.0
    wrong /= len(labels)
    back = (wrong @ second.T) * (1.0 - hidden**2)
    parts = (
        values.T @ back + decay * first,
        back.sum(axis=0),
        hidden.T @ wrong + decay * second,
        wrong.sum(axis=0),
    )
    return loss, np.concatenate([part.ravel() for part in parts])


def _layers(weights: NDArray[np.float64], inputs: int) -> tuple[NDArray[np.float64], ...]:
    """Split the weights (K H + H + H C + C,) into two layers and their biases."""
    classes = (len(weights) - inputs * HIDDEN - HIDDEN) // (HIDDEN + 1)
    ends = np.cumsum([inputs * HIDDEN, HIDDEN, HIDDEN * classes])
    first, bias, second, shift = np.split(weights, ends)
    return first.reshape(inputs, HIDDEN), bias, second.reshape(HIDDEN, classes), shift
