"""Texts of others (names of files, labels) on terminals, in figures and in files."""

from __future__ import annotations


def printable(text: object) -> str:
    """The text in one line that every terminal and file takes: what is no printable character as its escape sequence.

    Names of files may hold anything: line ends, sequences that move a terminal's cursor, bytes that are no UTF-8.
    """
    return "".join(
        letter if letter.isprintable() else letter.encode("unicode_escape").decode("ascii") for letter in str(text)
    )


def in_figure(text: object) -> str:
    """The text for matplotlib, to which a dollar sign is the beginning of a formula."""
    return printable(text).replace("$", r"\$")
