"""The report of a check: its findings, as a table, as JSON, as a page; and what to do with the recording."""

from __future__ import annotations

import json
import textwrap
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ahrs_rs import _html
from ahrs_rs._check._findings import SEVERITIES, Finding
from ahrs_rs._recording import Recording

if TYPE_CHECKING:
    from ahrs_rs._check._case import Case
    from ahrs_rs._check._recommend import Recommendation


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """What `ahrs_rs.check` found out about a recording.

    Parameters
    ----------
    recording : Recording
        What was checked.
    findings : tuple of Finding
        The gravest first.
    _case : Case
        What the check has made of the recording.

    Examples
    --------
    >>> import ahrs_rs as ar
    >>> rec = ar.simulate.demo(duration=60.0)
    >>> report = ar.check(rec)
    >>> report.severity in ("ok", "note")
    True
    >>> report["time.rate"].value
    100.0
    """

    recording: Recording = field(repr=False)
    findings: tuple[Finding, ...]
    _case: Case = field(repr=False)

    def __getitem__(self, code: str) -> Finding:
        """The finding of a code; KeyError where there is none."""
        found = self.get(code)
        if found is None:
            raise KeyError(code)
        return found

    def get(self, code: str) -> Finding | None:
        """The finding of a code.

        Parameters
        ----------
        code : str
            As "gyr.bias".

        Returns
        -------
        Finding or None
            None where there is none.
        """
        return next((one for one in self.findings if one.code == code), None)

    def __contains__(self, code: object) -> bool:
        """Whether there is a finding of this code."""
        return any(one.code == code for one in self.findings)

    def of(self, severity: str) -> tuple[Finding, ...]:
        """The findings of a severity.

        Parameters
        ----------
        severity : str
            "ok", "note", "warning" or "error".

        Returns
        -------
        tuple of Finding
            In the order of the report.

        Raises
        ------
        ValueError
            Another severity.
        """
        if severity not in SEVERITIES:
            raise ValueError(f"severity: expected one of {', '.join(SEVERITIES)}, got {severity!r}")
        return tuple(one for one in self.findings if one.severity == severity)

    @property
    def severity(self) -> str:
        """The gravest one of all findings; "ok" where there are none."""
        return max((one.severity for one in self.findings), key=SEVERITIES.index, default="ok")

    def fixed(self, *, notes: bool = False) -> Recording:
        """The recording with what is sure put right; what is not sure is as it was.

        Parameters
        ----------
        notes : bool, optional
            Whether to put right what is sure of the notes too: small biases, delays and hard iron, rows of a slow
            magnetometer that are held. Filters cope with these; calibrated readings suit other uses.

        Returns
        -------
        Recording
            ``meta["fixed"]`` lists the changes, a sentence each. Without changes it is the recording itself.
        """
        changes = [
            one.change
            for one in self.findings
            if one.change is not None and (notes or one.severity in ("warning", "error"))
        ]
        changes.sort(key=lambda one: _order(one.code))
        if not changes:
            return self.recording
        made = self.recording
        for change in changes:
            made = change.apply(made)
        made.meta["fixed"] = [*self.recording.meta.get("fixed", ()), *(one.text for one in changes)]
        return made

    def recommend(self, *, online: bool = False) -> Recommendation:
        """A filter and its parameters for this recording, with the reasons and the accuracy to expect.

        Parameters
        ----------
        online : bool, optional
            Whether it has to run as the readings come; False allows one that takes the whole recording.

        Returns
        -------
        Recommendation
            The filter's name, parameters and keywords, a sentence for each reason, and the error to expect.

        Examples
        --------
        >>> import ahrs_rs as ar
        >>> rec = ar.simulate.demo(duration=60.0)
        >>> advice = ar.check(rec).recommend(online=True)
        >>> advice.name
        'VQF'
        >>> est = advice.make().run(rec)
        """
        from ahrs_rs._check._recommend import recommend

        return recommend(self, online=online)

    def plot(self, *, ax: Any = None) -> NDArray[Any]:
        """Draw the evidence: norms over time, what turns with what, the field about its sphere, the spectrum.

        Parameters
        ----------
        ax : Axes or sequence of Axes, optional
            One for each panel; the field takes one with a 3D projection. By default on a new figure.

        Returns
        -------
        ndarray
            (n,) of axes; none where the recording has nothing to draw.

        Raises
        ------
        ImportError
            Matplotlib is not installed (``pip install ahrs-rs[plot]``).
        """
        from ahrs_rs import plots  # for drawing only
        from ahrs_rs._check._figures import figures

        plots.require_matplotlib()
        found = figures(self)
        return plots.evidence(found, ax=ax) if found else np.empty(0, dtype=object)

    def _repr_html_(self) -> str:
        shown = [one for one in self.findings if one.severity != "ok"]
        right = len(self.findings) - len(shown)
        rows = [(one.severity, one.code, one.message, f"{100.0 * one.confidence:.0f} %") for one in shown]
        note = f"{right} more are ok." if right else ""
        return _html.table(f"Check: {self.severity}", ("severity", "code", "finding", "sure"), rows, note)

    def to_html(self) -> str:
        """A page with the findings and plots of the evidence, all in one text.

        Returns
        -------
        str
            HTML that needs no other file.

        Raises
        ------
        ImportError
            plotly is not installed (``pip install ahrs-rs[papers]``).
        """
        from ahrs_rs._check._page import page

        return page(self)

    def to_dict(self) -> dict[str, Any]:
        """All of it, as JSON has it.

        Returns
        -------
        dict
            Format and version, path, gravest severity, how many findings of each, and the findings.
        """
        counts = {severity: len(self.of(severity)) for severity in SEVERITIES}
        return {
            "format": "ahrs_rs.check",
            "version": 1,
            "path": str(self.recording.meta.get("path", "")),
            "severity": self.severity,
            "counts": counts,
            "findings": [one.to_dict() for one in self.findings],
        }

    def to_json(self) -> str:
        """The same as text.

        Returns
        -------
        str
            JSON.
        """
        return json.dumps(self.to_dict(), ensure_ascii=False, indent=2, allow_nan=False)

    def table(self, *, everything: bool = True, width: int = 110) -> str:
        """The findings for reading: severity, code, sentence, how sure; below, what it means and what to do.

        Parameters
        ----------
        everything : bool, optional
            False leaves out what is ok.
        width : int, optional
            Of a line, in characters.

        Returns
        -------
        str
            Lines of text.
        """
        lines: list[str] = []
        shown = [one for one in self.findings if everything or one.severity != "ok"]
        column = max((len(one.code) for one in shown), default=0)
        for one in shown:
            head = f"{one.severity:<8} {one.code:<{column}}  "
            body = textwrap.wrap(f"{one.message} ({100.0 * one.confidence:.0f} % sure)", max(width - len(head), 30))
            lines.append(head + body[0])
            indent = " " * len(head)
            lines += [indent + line for line in body[1:]]
            if one.severity in ("warning", "error"):
                for label, text in (("means: ", one.meaning), ("do: ", one.remedy)):
                    if text:
                        wrapped = textwrap.wrap(label + text, max(width - len(head), 30), subsequent_indent="  ")
                        lines += [indent + line for line in wrapped]
        return "\n".join(lines) if lines else "nothing to tell"

    def __str__(self) -> str:
        """The table."""
        return self.table()


#: In which order changes are made: times, units, axes, and then what asks for right units and axes.
ORDER = ("time", "gyr.unit", "acc.unit", "mag.unit", "axes", "acc.sign", "mag.sign", "mag.repeated", "mag.delay")


def _order(code: str) -> int:
    for number, start in enumerate(ORDER):
        if code.startswith(start):
            return number
    return len(ORDER)
