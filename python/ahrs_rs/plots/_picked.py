"""One recording of an estimate that may have several."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

if TYPE_CHECKING:
    from ahrs_rs._estimate import Estimate


def picked(estimate: Estimate, recording: int | None) -> Any:
    """A function that gives an array of one recording: called with the array and how many axes it has then."""
    several = estimate.quat.ndim == 3
    count = len(estimate.quat) if several else 1
    if recording is None and several:
        raise ValueError(f"recording: expected which of the {count} recordings is to be drawn, got None")
    if recording is not None and not 0 <= recording < count:
        raise ValueError(f"recording: expected a number from 0 to {count - 1}, got {recording}")

    def pick(array: NDArray[Any], axes: int) -> NDArray[Any]:
        return array[recording] if several and array.shape[:1] == (count,) and array.ndim > axes else array

    return pick
