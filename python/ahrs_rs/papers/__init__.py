"""The five papers whose filters this package has, each as an experiment: ``ahrs-rs papers``.

Every study runs on a simulation of its paper's protocol (the authors' recordings are not to be had) and on real
recordings with optical truth, with the paper's parameters and metrics, and tells which of its conclusions hold.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence

from ahrs_rs._recording import Recording
from ahrs_rs.papers._report import require_plotly, write_report
from ahrs_rs.papers._study import Claim, Plot, Study, Table, Verdict
from ahrs_rs.papers._text import claims, plain

__all__ = [
    "STUDIES",
    "Claim",
    "Plot",
    "Study",
    "Table",
    "Verdict",
    "claims",
    "plain",
    "require_plotly",
    "study",
    "write_report",
]

#: The studies in the order of their years.
STUDIES = ("cirillo2014", "hyyti2015", "ludwig2018", "parikh2021", "cocoli2023")


def study(name: str, recordings: Sequence[Recording] = (), seed: int = 0) -> Study:
    """One paper reproduced.

    Parameters
    ----------
    name : str
        Of `STUDIES`.
    recordings : sequence of Recording, optional
        Real ones with truth, on which the paper's conclusions are tried a second time.
    seed : int, optional
        Of the simulated sensor's errors.

    Returns
    -------
    Study
        Tables, claims and plots.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> ar.papers.study("cirillo2014").name  # doctest: +SKIP
    """
    if name not in STUDIES:
        raise ValueError(f"name: expected one of {', '.join(STUDIES)}, got {name!r}")
    module = importlib.import_module(f"ahrs_rs.papers._{name}")
    result: Study = module.study(list(recordings), seed)
    return result
