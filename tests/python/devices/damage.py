"""Damage to valid files: cut, bits and bytes changed, parts lost, doubled, set to zero, numbers made huge."""

from __future__ import annotations

import random
import shutil
from pathlib import Path

#: Numbers that readers take for lengths and counts.
HUGE = (b"\xff\xff\xff\x7f", b"\x7f\xff\xff\xff", b"\xff\xff\xff\xff", b"\x00\x00\x00\x80", b"\x00" * 8, b"99999999")


def damaged(content: bytes, seed: int) -> tuple[bytes, str]:
    """The content with one kind of damage, and what was done. The same for the same seed."""
    dice = random.Random(seed)
    held = bytearray(content)
    kind = dice.choice(
        ("cut", "cut", "bytes", "bytes", "bytes", "head", "zero", "lost", "doubled", "added", "huge", "bit")
    )
    at = dice.randrange(len(held))
    length = dice.choice((1, 2, 4, 16, 64, 512))
    if kind == "cut":
        held = held[:at]
    elif kind == "bytes":
        for _ in range(dice.choice((1, 1, 2, 8, 32))):
            held[dice.randrange(len(held))] = dice.randrange(256)
    elif kind == "head":
        for _ in range(dice.choice((1, 3))):
            held[dice.randrange(min(len(held), 1024))] = dice.choice((0, 1, 0x7F, 0x80, 0xFF))
    elif kind == "zero":
        held[at : at + length] = bytes(len(held[at : at + length]))
    elif kind == "lost":
        del held[at : at + length]
    elif kind == "doubled":
        held[at:at] = held[at : at + length]
    elif kind == "added":
        held[at:at] = bytes(dice.randrange(256) for _ in range(length))
    elif kind == "huge":
        huge = dice.choice(HUGE)
        held[at : at + len(huge)] = huge
    else:
        held[at] ^= 1 << dice.randrange(8)
    return bytes(held), f"{kind} at {at}"


def damaged_copy(sample: Path, folder: Path, seed: int) -> tuple[Path, str]:
    """A copy of a file or folder in which one file is damaged, and what was done."""
    copy = folder / sample.name
    if copy.is_dir():
        shutil.rmtree(copy)
    if sample.is_dir():
        shutil.copytree(sample, copy)
        files = sorted(path for path in copy.rglob("*") if path.is_file())
        file = random.Random(seed + 1_000_000).choice(files)
        content, what = damaged(file.read_bytes(), seed)
        file.write_bytes(content)
        return copy, f"{file.relative_to(copy)}: {what}"
    content, what = damaged(sample.read_bytes(), seed)
    copy.write_bytes(content)
    return copy, what
