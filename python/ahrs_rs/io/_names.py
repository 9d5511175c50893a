"""What the name of a column tells: quantity, axis, unit, and of which sensor.

A name is split into words: at signs, at capital letters, and where a sensor's name meets an axis (GyrX, xacc). The
words for a quantity are looked for; what stands before them is the owner (left_foot_gyro_x), what stands between or
behind is the axis, the unit (acc_x_g, gyro_rad[0]), or a kind (raw, filtered, wide range). Units in brackets go before.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

from ahrs_rs.io._units import SIZELESS, UNITS, is_unit, plain, unit_key, written
from ahrs_rs.io._vocabulary import PHRASES, TIMES

#: Quantity -> labels of its axes, "" for a quantity of one column.
AXES: dict[str, tuple[str, ...]] = {
    "t": ("",),
    "gyr": tuple("xyz"),
    "acc": tuple("xyz"),
    "mag": tuple("xyz"),
    "ref": tuple("wxyz"),
    "device_quat": tuple("wxyz"),
    "mask": ("",),
    "temperature": ("",),
    "linear_acceleration": tuple("xyz"),
    "gravity": tuple("xyz"),
    "pressure": ("",),
    "heading": ("",),
}

#: Phrase -> its quantity.
_PHRASE_WORDS = {phrase: quantity for quantity, phrases in PHRASES.items() for phrase in phrases}
_LONGEST = max(map(len, _PHRASE_WORDS))

#: Quantity -> words that are its own, and so no owner.
_OWN_WORDS = {quantity: frozenset(sum(phrases, ())) for quantity, phrases in PHRASES.items()}

#: Single letters with an axis (gx, a_y): only where nothing else stands before them but a device's name.
_LETTERS = {
    "g": "gyr",
    "w": "gyr",
    "a": "acc",
    "f": "acc",
    "m": "mag",
    "h": "mag",
    "b": "mag",
    "ac": "acc",
    "gy": "gyr",
    "q": "quat",
}
#: Names that only whole programs use.
_EXACT = {
    "gfx": ("acc", 0, "g"),
    "gfy": ("acc", 1, "g"),
    "gfz": ("acc", 2, "g"),
    "g_fx": ("acc", 0, "g"),
    "g_fy": ("acc", 1, "g"),
    "g_fz": ("acc", 2, "g"),
    "as_x": ("gyr", 0, ""),  # angular speed, of WitMotion
    "as_y": ("gyr", 1, ""),
    "as_z": ("gyr", 2, ""),
    "roll_rate": ("gyr", 0, ""),
    "pitch_rate": ("gyr", 1, ""),
    "yaw_rate": ("gyr", 2, ""),
}

#: What a column of a sensor may be that is no reading of it.
_NO_READING = frozenset(
    [
        "covariance",
        "cov",
        "bias",
        "offset",
        "scale",
        "gain",
        "std",
        "stddev",
        "sigma",
        "var",
        "variance",
        "noise",
        "error",
        "err",
        "relative",
        "clipping",
        "clip",
        "count",
        "counter",
        "integral",
        "id",
        "status",
        "calibration",
        "cal_count",
        "accuracy",
        "acc_accuracy",
        "valid",
        "flag",
        "timestamp_relative",
        "range",
        "delta",
        "dt",
        "health",
        "quality",
        "uncertainty",
        "magnitude",
        "norm",
        "rms",
        "mean",
        "min",
        "max",
        "length",
        "saturated",
        "saturation",
        "rate_hz",
        "freq",
        "frequency",
        "samples",
        "sn",
        "serial",
        "type",
        "name",
        "mode",
        "angle",
        "ref_x",
        "setpoint",
        "sp",
        "target",
        "cmd",
        "command",
        "correction",
        "drift",
        "residual",
        "diff",
        "tilt",
        "increment",
        "dq",
        "dv",
    ]
)
#: Kinds of a reading that is not as the sensor gave it; the higher the number, the later it is taken.
_KINDS = {
    "raw": 2,
    "uncal": 2,
    "uncalibrated": 2,
    "unbiased": 0,
    "filtered": 1,
    "filt": 1,
    "lpf": 1,
    "smooth": 1,
    "lp": 1,
    "hp": 2,
}
#: Words for what was done to a reading: they name no sensor.
PROCESSED = frozenset(_KINDS) | frozenset(
    [
        "cal",
        "calibrated",
        "calib",
        "corrected",
        "comp",
        "compensated",
        "fused",
        "est",
        "estimated",
        "wr",
        "ln",
        "data",
        "value",
        "val",
        "body",
        "world",
        "earth",
    ]
)
_TRUTH = frozenset(
    [
        "ref",
        "reference",
        "truth",
        "true",
        "gt",
        "groundtruth",
        "opt",
        "optical",
        "vicon",
        "mocap",
        "optitrack",
        "qualisys",
    ]
)
_DEVICE = re.compile(
    r"(?:imu|sensor|marg|mpu|lsm|icm|bno|bmi|ahrs|ins|data|field|msg|raw|calibrated|cal|s|i|body|b)\d*"
)

_BRACKETS = re.compile(
    r"(?P<name>[^()\[\]{}]*(?:\[\d\])?[^()\[\]{}]*)[(\[{](?P<unit>[^()\[\]{}]*(?:\([^()]*\)[^()\[\]{}]*)?)[)\]}]\s*"
)
_WORD = re.compile(r"[a-z]+|\d+")
_GLUED = re.compile(
    r"(?P<before>[xyz])?(?P<name>gyroscope|gyros|gyro|gyr|accelerometer|acceleration|accel|acce|acc|magnetometer|magneto|magn|mag|"
    r"omega|quat|temp|rotationrate|baro)(?P<behind>[wxyz])?"
)
#: The kind of a truth that is not called a quaternion (ref_w): it may be a position too.
BARE = "bare"
#: A cell that is longer is no name of a column.
_LONGEST_NAME = 200


@dataclass(frozen=True, slots=True)
class Column:
    """One column that was understood."""

    index: int
    header: str
    quantity: str
    axis: int
    unit: str
    """As written; "" if none."""
    owner: str = ""
    """What stands before the quantity and is no device in general: a place on the body, a number."""
    kind: tuple[str, ...] = ()
    """Words that tell one reading of a sensor from another one of it."""
    truth: bool = False
    bracketed: bool = False
    """Whether the unit stands in brackets, and so is one even if it is unknown."""

    @property
    def known(self) -> bool:
        """Whether the unit is known, or none is stated."""
        return not self.unit or is_unit(self.quantity, self.unit)

    @property
    def group(self) -> tuple[str, str, tuple[str, ...], bool]:
        """What the axes of one reading have in common."""
        return self.quantity, self.owner, self.kind, self.truth

    @property
    def lateness(self) -> int:
        """The higher, the later it is taken: filtered and raw readings come after others."""
        return max((_KINDS.get(word, 0) for word in self.kind), default=0)


def parse(index: int, header: str, *, hint: str = "") -> Column | None:
    """What the column is, or None for a name that tells nothing.

    Parameters
    ----------
    index, header : of the column.
    hint : the quantity of columns that are named by their axes alone, as the file's name tells; "" where it does not.
    """
    found = _parsed(header, hint)
    if found is None:
        return None
    quantity, axis, unit, owner, kind, truth, bracketed = found
    unit = unit if bracketed or unit_key(unit) in {*SIZELESS, ""} else written(quantity, unit)
    return Column(index, header, quantity, axis, unit, owner, kind, truth, bracketed)


def looks_like_sensor(header: str) -> bool:
    """Whether a name that was not taken speaks of a sensor or an orientation."""
    words = set(split(header)[0])
    known = {
        "gyr",
        "gyro",
        "gyroscope",
        "acc",
        "accel",
        "accelerometer",
        "acceleration",
        "mag",
        "magnetometer",
        "magnetic",
    }
    if words & _NO_READING:
        return False
    return bool(
        words & (known | {"quat", "quaternion", "angular", "omega", "roll", "pitch", "yaw", "orientation", "rotation"})
    )


@lru_cache(maxsize=4096)
def split(header: str) -> tuple[tuple[str, ...], str, bool]:
    """The words of a name in lower case, its unit ("" if none), and whether the unit stands in brackets."""
    text = plain(header.strip().strip("\"'"))[:_LONGEST_NAME]
    brackets = _BRACKETS.fullmatch(text)
    unit = ""
    if brackets is not None and not brackets["unit"].strip().isdigit():
        text, unit = brackets["name"], brackets["unit"].strip()
    text = re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", text)
    text = re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1_\2", text).lower()
    words: list[str] = []
    for word in _WORD.findall(text):
        glued = _GLUED.fullmatch(word)
        if glued is None:
            words.append(word)
        else:
            words += [glued["name"], *filter(None, [glued["before"] or glued["behind"]])]
    return tuple(words), unit, bool(brackets and unit)


Parsed = tuple[str, int, str, str, tuple[str, ...], bool, bool]


@lru_cache(maxsize=4096)
def _parsed(header: str, hint: str) -> Parsed | None:
    words, unit, bracketed = split(header)
    if not words or len(words) > 16:
        return None
    if unit and re.fullmatch(r"[xyzw]", unit.strip().lower()):  # gyro (x)
        words, unit, bracketed = (*words, unit.strip().lower()), "", False
    return (
        _clock(words, unit, bracketed)
        or _exact(words, unit, bracketed)
        or _phrased(words, unit, bracketed)
        or _lettered(words, unit, bracketed)
        or _bare(words, unit, bracketed, hint)
    )


def _clock(words: tuple[str, ...], unit: str, bracketed: bool) -> Parsed | None:
    """A time: one of its names, with a unit before or behind, or a device's name before."""
    for cut in range(min(3, len(words))):
        if cut and not _DEVICE.fullmatch(words[0]):
            break
        rest, own = _without_unit("t", words[cut:], unit)
        single = len(rest) == 1 and len(rest[0]) > 1 and is_unit("t", rest[0])  # nsecs
        if rest in TIMES or single or (not rest and own):
            if rest == ("t",) and unit and not is_unit("t", unit) and is_unit("temperature", unit):
                return "temperature", 0, unit, "", (), False, bracketed
            if not own:  # a name like "millis" or "seconds_elapsed" says the unit of the time
                own = next((word for word in rest if is_unit("t", word)), "")
            return "t", 0, own, "", tuple(word for word in rest if word != own), False, bracketed
    if "timestamp" in words and not _NO_READING & set(words):  # gyro_timestamp, timestamp_unix_cal
        rest, own = _without_unit("t", words, unit)
        return "t", 0, own, "", rest, False, bracketed
    return None


def _without_unit(quantity: str, words: tuple[str, ...], unit: str) -> tuple[tuple[str, ...], str]:
    """The words without those of a unit at their end, and the unit; one in brackets goes before."""
    if unit:
        return words, unit
    for length in (4, 3, 2, 1):
        if len(words) > length and is_unit(quantity, "".join(words[-length:])):
            return words[:-length], "_".join(words[-length:])
    return words, ""


def _exact(words: tuple[str, ...], unit: str, bracketed: bool) -> Parsed | None:
    known = _EXACT.get("_".join(words))
    if known is None:
        return None
    quantity, axis, own = known
    return quantity, axis, unit or own, "", (), False, bracketed


def _phrased(words: tuple[str, ...], unit: str, bracketed: bool) -> Parsed | None:
    """A phrase for a quantity, with owner, axis, unit and kind about it."""
    for length in range(min(_LONGEST, len(words)), 0, -1):
        for start in range(len(words) - length + 1):
            quantity = _PHRASE_WORDS.get(words[start : start + length])
            if quantity is None or (words[start] == "q" and start and not _is_owner(words[:start])):
                continue
            stated = unit or ("degC" if "".join(words[start : start + length]).endswith("degc") else "")
            made = _around(quantity, words[:start], words[start + length :], stated, bracketed)
            if made is not None:
                return made
    return None


def _is_owner(words: tuple[str, ...]) -> bool:
    return all(word in _TRUTH or _DEVICE.fullmatch(word) for word in words)


def _around(
    quantity: str, before: tuple[str, ...], behind: tuple[str, ...], unit: str, bracketed: bool
) -> Parsed | None:
    truth = bool(_TRUTH & set(before)) or before[-2:] == ("ground", "truth")
    if quantity == "quat":
        quantity = "ref" if truth else "device_quat"
    labels = AXES[quantity]
    axis, rest, leading = 0, behind, before
    if len(labels) > 1:
        where = _axis_of(quantity, behind)
        if where is None and before and before[-1] in labels and len(before[-1]) == 1:
            where, leading = (before[-1], -1), before[:-1]  # x_gyro
        if where is None:
            return None
        label, position = where
        axis = _number(quantity, label)
        if position >= 0:
            unit_before, unit_behind = behind[:position], behind[position + 1 :]
            rest, own = _without_unit_or_all(quantity, unit_behind, unit)
            if not own:
                unit_before, own = _without_unit_or_all(quantity, unit_before, unit)
            rest, unit = (*unit_before, *rest), own
        else:
            rest, unit = _without_unit_or_all(quantity, behind, unit)
    else:
        rest, unit = _without_unit_or_all(quantity, behind, unit)
        if rest or any(word in AXES["acc"] for word in before):
            return None  # temp_room, pressure_altitude, moving_average: something else
    words = (*leading, *rest)
    if len(labels) > 1 and {"temp", "temperature"} & set(words):
        return None  # xRateTemp: of the gyroscope, but not its reading
    if _NO_READING & set(words) and not (unit and set(words) & {"cal"}):
        return None
    names = _OWN_WORDS.get(quantity, frozenset())
    owner = tuple(word for word in leading if not (_DEVICE.fullmatch(word) or word in _TRUTH | names or word in _KINDS))
    numbers = [
        word for word in leading if _DEVICE.fullmatch(word) and word[-1].isdigit() and word not in ("s", "i", "b")
    ]
    number = [word for word in rest if word.isdigit()]
    kind = tuple(word for word in (*leading, *rest) if word in _KINDS or (word in rest and not word.isdigit()))
    named = "_".join((*numbers, *owner, *number))
    return quantity, axis, unit, named, kind, truth, bracketed


def _axis_of(quantity: str, words: tuple[str, ...]) -> tuple[str, int] | None:
    """The word that is an axis, and where it stands: the last letter, or else the last number."""
    labels = AXES[quantity]
    for position in range(len(words) - 1, -1, -1):
        if words[position] in labels:
            return words[position], position
    for position in range(len(words) - 1, -1, -1):
        if words[position] in ("real", "scalar") and len(labels) == 4:
            return "w", position
    for position in range(len(words) - 1, -1, -1):
        word = words[position]
        if word.isdigit() and len(word) == 1 and int(word) < len(labels) and position == len(words) - 1:
            return word, position
    if len(words) >= 2 and words[0].isdigit() and len(words[0]) == 1 and int(words[0]) < len(labels):
        return words[0], 0
    return None


def _number(quantity: str, label: str) -> int:
    return int(label) if label.isdigit() else AXES[quantity].index(label)


def _without_unit_or_all(quantity: str, words: tuple[str, ...], unit: str) -> tuple[tuple[str, ...], str]:
    """As `_without_unit`, where the unit may be all of the words."""
    if unit or not words:
        return words, unit
    if is_unit(quantity, "".join(words)) and "".join(words) != "raw":
        return (), "_".join(words)
    rest, own = _without_unit(quantity, words, "")
    return (words, "") if own in _KINDS else (rest, own)


def _lettered(words: tuple[str, ...], unit: str, bracketed: bool) -> Parsed | None:
    """gx, a_y, wz: a letter with its axis, after nothing or a device's name."""
    for start in range(min(3, len(words))):
        if start and not all(_DEVICE.fullmatch(word) or word in _TRUTH for word in words[:start]):
            return None
        rest = words[start:]
        whole = len(rest[0]) > 1 and not (rest[0] in ("ac", "gy") and rest[1:2] in (("x",), ("y",), ("z",)))
        joined, behind = (rest[0], rest[1:]) if whole else ("".join(rest[:2]), rest[2:])
        match = re.fullmatch(r"(ac|gy|[gwafmhbq])([wxyz0-3])", joined)
        if match is None and bracketed and len(rest) > 2 and rest[0] in _LETTERS and rest[-1] in AXES["acc"]:
            quantity = _LETTERS[rest[0]]  # w_RS_S_x [rad s^-1]: the frames stand between, the unit settles it
            if is_unit(quantity, unit):
                return quantity, AXES[quantity].index(rest[-1]), unit, "", rest[1:-1], False, bracketed
        if match is None:
            continue
        quantity = _LETTERS[match[1]]
        return _around(quantity, words[:start], (match[2], *behind), unit, bracketed)
    return None


def _bare(words: tuple[str, ...], unit: str, bracketed: bool, hint: str) -> Parsed | None:
    """An axis alone: the truth where that is said, or what its unit or the file's name says."""
    if len(words) == 2 and words[0] in _TRUTH and words[1] in AXES["ref"]:
        return "ref", AXES["ref"].index(words[1]), unit, "", (BARE,), True, bracketed
    rest = tuple(word for word in words if word not in ("axis", "value", "axes"))
    if len(rest) != 1 or rest[0] not in ("x", "y", "z", "w"):
        return None
    quantity = hint or _OF_UNIT.get(unit_key(unit), "")
    if not quantity or rest[0] not in AXES[quantity]:
        return None
    return quantity, AXES[quantity].index(rest[0]), unit, "", (), False, bracketed


def _units_of_one_quantity() -> dict[str, str]:
    """Unit -> the only sensor that has it; g is an acceleration, though a gauss is written so too."""
    found: dict[str, str] = {}
    for quantity in ("mag", "acc", "gyr"):
        for unit in UNITS[quantity]:
            others = [other for other in ("gyr", "acc", "mag") if other != quantity and unit in UNITS[other]]
            if not others:
                found[unit] = quantity
    return {**found, "g": "acc", "mg": "acc"}


_OF_UNIT = _units_of_one_quantity()


def quantity_of_name(stem: str) -> str:
    """The quantity of which a file's name speaks, "" where of none or of several."""
    words = split(stem)[0]
    found = set()
    for length in range(_LONGEST, 0, -1):
        for start in range(len(words) - length + 1):
            quantity = _PHRASE_WORDS.get(words[start : start + length])
            if quantity in ("gyr", "acc", "mag", "linear_acceleration", "gravity", "quat") and len(words[start]) > 2:
                found.add("device_quat" if quantity == "quat" else quantity)
        if found:
            break
    return found.pop() if len(found) == 1 else ""
