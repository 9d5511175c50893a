"""ArduPilot's DataFlash log: self-describing binary messages, by AP_Logger's documentation."""

from __future__ import annotations

import struct
from collections.abc import Iterable

HEAD = b"\xa3\x95"

#: Message -> (type number, format letters, columns), as of ArduPilot 4.x.
MESSAGES = {
    "IMU": (10, "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
    "MAG": (11, "QBhhhhhhhhhBI", "TimeUS,I,MagX,MagY,MagZ,OfsX,OfsY,OfsZ,MOX,MOY,MOZ,Health,S"),
    "ATT": (12, "QccccCCCC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,ErrRP,ErrYaw"),
    "IMU2": (13, "QffffffIIfBBHH", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
    "AHR2": (14, "QccCfLLffff", "TimeUS,Roll,Pitch,Yaw,Alt,Lat,Lng,Q1,Q2,Q3,Q4"),
    "XKQ": (15, "QBffff", "TimeUS,C,Q1,Q2,Q3,Q4"),
}
_CODE = {"B": "B", "b": "b", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d", "Q": "Q", "q": "q"} | {
    "c": "h",
    "C": "H",
    "e": "i",
    "E": "I",
    "L": "i",
    "M": "B",
    "n": "4s",
    "N": "16s",
    "Z": "64s",
}


def _codes(letters: str) -> str:
    return "<" + "".join(_CODE[letter] for letter in letters)


def _fmt(number: int, length: int, name: str, letters: str, columns: str) -> bytes:
    return (
        HEAD
        + bytes([128])
        + struct.pack("<BB4s16s64s", number, length, name.encode(), letters.encode(), columns.encode())
    )


def log(
    rows: Iterable[tuple[str, tuple[float, ...]]], messages: dict[str, tuple[int, str, str]] | None = None
) -> bytes:
    """A log of rows (message, values as stored: centidegrees and the like are integers)."""
    known = MESSAGES | (messages or {})
    rows = list(rows)
    out = [_fmt(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")]
    for name in dict.fromkeys(name for name, _ in rows):
        number, letters, columns = known[name]
        out.append(_fmt(number, 3 + struct.calcsize(_codes(letters)), name, letters, columns))
    for name, values in rows:
        number, letters, _ = known[name]
        out.append(HEAD + bytes([number]) + struct.pack(_codes(letters), *values))
    return b"".join(out)
