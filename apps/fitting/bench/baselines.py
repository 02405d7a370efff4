"""Baseline fitters by name, and the protocol of custom ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, cast

from eyehand.errors import InputError

from ...named_import import import_named

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.perception import Superquadric, SuperquadricFit

BASELINES: dict[str, str] = {"ems": "eyehand.apps.fitting.bench.ems:ems_fit"}
"""Name of a baseline → ``module:function``, a `Fitter`."""


class Fitter(Protocol):
    """A function that fits the cloud of one object."""

    def __call__(
        self,
        points: NDArray[np.float64],
        view_origin: NDArray[np.float64] | None,
        support_plane: NDArray[np.float64] | None,
        /,
    ) -> Superquadric | SuperquadricFit | None:
        """Fit a superquadric.

        Parameters
        ----------
        points
            (N, 3), m.
        view_origin
            (3,) camera position, m; None if unknown.
        support_plane
            (4,) unit normal n and offset d of the support plane, ``n·x + d = 0`` with n towards the
            object; None if unknown.

        Returns
        -------
        Superquadric, SuperquadricFit or None
            The solid in the frame of the points; None if no solid was found.
        """
        ...


def find_baseline(name: str) -> Fitter:
    """Import a baseline by its name or as ``module:function``.

    Modules in the current folder are found too.

    Raises
    ------
    InputError
        If the module cannot be imported, or its function does not exist or is not callable.
    """
    where = BASELINES.get(name, name)
    module, colon, function = where.partition(":")
    if not (module and colon and function):
        known = f" or one of {', '.join(BASELINES)}" if BASELINES else ""
        raise InputError(f"a baseline must be module:function{known}, got {name!r}")
    return cast("Fitter", import_named(where, "baseline"))
