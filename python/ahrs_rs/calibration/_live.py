"""A magnetometer that is calibrated while it is turned: which directions it has seen, and the fit so far."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ahrs_rs import _arrays
from ahrs_rs._typing import FloatArray
from ahrs_rs._validate import positive
from ahrs_rs.calibration import _directions, _linear, _sphere_fit
from ahrs_rs.calibration._common import count_of, readings
from ahrs_rs.calibration._directions import BANDS, SECTORS
from ahrs_rs.calibration._ellipsoid import PARAMETERS, magnetometer
from ahrs_rs.calibration._fit_result import EllipsoidFit

__all__ = ["LiveMagnetometer"]

#: The centre is estimated from so many readings at most, evenly taken.
LOOKED_AT = 500
#: What a cell of the map shows: no reading, one, and so many.
EMPTY, SEEN, WELL, NOW = ".", "o", "#", "@"
ENOUGH = 3


class LiveMagnetometer:
    """Readings of a magnetometer as they come, with the directions that they have covered.

    Parameters
    ----------
    parameters : int, optional
        Of the fit at the end: 9, 6, 4 or 3, as of `magnetometer`.
    norm : float, optional
        Of the local field, µT; None with three parameters.

    Raises
    ------
    ValueError
        Another number of parameters, or a norm that is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> live = ar.calibration.LiveMagnetometer()
    >>> x = np.random.default_rng(0).standard_normal((500, 3))
    >>> live.add(48.0 * x / np.linalg.norm(x, axis=1, keepdims=True) + [12.0, -3.0, 5.0])
    >>> live.coverage > 0.95, len(live)
    (True, 500)
    >>> live.fit().calibration.offset.round(6)
    array([12., -3.,  5.])
    """

    def __init__(self, *, parameters: int = 9, norm: float | None = None) -> None:
        self.parameters = count_of(parameters, PARAMETERS)
        self.norm = None if norm is None else positive("norm", norm)
        if self.parameters == 3 and norm is not None:
            raise ValueError(
                f"norm: expected None with parameters=3, as a circle in a plane has no scale, got {norm!r}"
            )
        self._rows = np.empty((256, 3))
        self._count = 0

    def __len__(self) -> int:
        """The number of readings that are there."""
        return self._count

    def add(self, mag: ArrayLike) -> None:
        """Take readings; rows with NaN are left out.

        Parameters
        ----------
        mag : array_like
            (3,) or (n, 3) µT.
        """
        array, valid = readings("mag", np.atleast_2d(np.asarray(_arrays.vectors("mag", mag))))
        rows = array[valid]
        while self._count + len(rows) > len(self._rows):
            self._rows = np.concatenate((self._rows, np.empty_like(self._rows)))
        self._rows[self._count : self._count + len(rows)] = rows
        self._count += len(rows)

    @property
    def readings(self) -> FloatArray:
        """(n, 3) all readings so far."""
        return self._rows[: self._count]

    @property
    def centre(self) -> FloatArray:
        """(3,) the centre of the sphere of the readings so far, or the middle of their extent."""
        rows = self.readings
        if not len(rows):
            return np.zeros(3)
        some = np.ascontiguousarray(rows[:: max(len(rows) // LOOKED_AT, 1)].T)
        try:
            return _sphere_fit.fit(some).centre
        except (_linear.NoEllipsoidError, np.linalg.LinAlgError):
            middle: FloatArray = 0.5 * (rows.min(axis=0) + rows.max(axis=0))
            return middle

    @property
    def coverage(self) -> float:
        """Share of 72 cells of equal area of the sphere that the readings have seen."""
        return float(np.count_nonzero(self._cells())) / (BANDS * SECTORS)

    def map(self) -> str:
        """The sphere as text: a row a band from +z to −z, a column a sector about z, from −x over −y, +x, +y.

        Returns
        -------
        str
            ``.`` is a cell without a reading, ``o`` one with some, ``#`` one with enough, ``@`` that
            of the last reading.
        """
        counts = self._cells()
        marks = np.where(counts == 0, EMPTY, np.where(counts < ENOUGH, SEEN, WELL))
        if self._count:
            marks[_directions.cells((self.readings[-1:] - self.centre).T)[0]] = NOW
        grid = marks.reshape(BANDS, SECTORS)[::-1]
        sides = {0: "+z ", BANDS - 1: "-z "}
        return "\n".join(sides.get(k, "   ") + " ".join(row) for k, row in enumerate(grid))

    def fit(self) -> EllipsoidFit:
        """The calibration by all readings so far, as `magnetometer` gives it.

        Returns
        -------
        EllipsoidFit
            The calibration, and how good it is.

        Raises
        ------
        CalibrationError
            The readings do not determine the parameters; the message says what to record.
        """
        return magnetometer(self.readings, parameters=self.parameters, norm=self.norm)

    def _cells(self) -> FloatArray:
        """(72,) how many readings each cell has."""
        y = (self.readings - self.centre).T
        there = (y != 0).any(axis=0)
        found: FloatArray = np.bincount(_directions.cells(y[:, there]), minlength=BANDS * SECTORS).astype(np.float64)
        return found
