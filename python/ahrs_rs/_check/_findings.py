"""What a check says: findings, and the changes that put right what is sure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ahrs_rs._recording import Recording

#: In the order of their weight.
SEVERITIES = ("ok", "note", "warning", "error")


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """One thing that is put right."""

    code: str
    text: str
    """What is done, in a line, for ``meta["fixed"]``."""
    apply: Callable[[Recording], Recording]


@dataclass(frozen=True, slots=True, eq=False)
class Finding:
    """One thing that `ahrs_rs.check` found out about a recording.

    Findings are made by `check`; what they hold is for reading, and for programs by `code`.

    Parameters
    ----------
    code : str
        Subject and kind, as "gyr.bias": stable names, for programs.
    severity : str
        "ok", "note", "warning" or "error": a filter runs well; is told something; is less accurate; goes wrong.
    message : str
        What was found, in a sentence. "cannot tell" where the data cannot.
    value : float, optional
        The number that it rests on.
    unit : str, optional
        Of the number.
    confidence : float, optional
        How sure it is, 0 to 1.
    meaning : str, optional
        What it means for a filter.
    remedy : str, optional
        What to do.
    evidence : mapping, optional
        Further numbers.
    change : Change, optional
        What `Report.fixed` does about it, by itself where it is grave; None where nothing is sure.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> finding = ar.check(ar.simulate.demo(duration=60.0))["time.rate"]
    >>> finding.severity, finding.value, finding.unit
    ('ok', 100.0, 'Hz')
    """

    code: str
    severity: str
    message: str
    value: float | None = None
    unit: str = ""
    confidence: float = 1.0
    meaning: str = ""
    remedy: str = ""
    evidence: Mapping[str, Any] = field(default_factory=dict)
    change: Change | None = field(default=None, repr=False)

    @property
    def subject(self) -> str:
        """What it is about: "time", "gyr", "acc", "mag", "axes", "ref"."""
        return self.code.partition(".")[0]

    def to_dict(self) -> dict[str, Any]:
        """All of it as JSON has it; numbers that JSON lacks are None.

        Returns
        -------
        dict
            Its fields by name, and whether `Report.fixed` can do something about it ("fixable").
        """
        return {
            "code": self.code,
            "severity": self.severity,
            "message": self.message,
            "value": _plain(self.value),
            "unit": self.unit,
            "confidence": round(float(self.confidence), 4),
            "meaning": self.meaning,
            "remedy": self.remedy,
            "evidence": _plain(dict(self.evidence)),
            "fixable": self.change is not None,
        }


def confidence(score: float) -> float:
    """How sure a standard score is: that of half of it, because windows are not independent of each other."""
    return 0.5 * math.erfc(-0.5 * score / math.sqrt(2.0))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else str(value)
