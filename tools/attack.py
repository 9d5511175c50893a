"""What ends a process or wears it out: `make attack`, kept as docs/attacks.md.

    python tools/attack.py kills      # kill -9 at random moments of every command that writes
    python tools/attack.py signals    # Ctrl-C and SIGTERM likewise, and how soon the command ends
    python tools/attack.py memory     # calls of every public function, and what memory they leave

Each writes its own part of the document; `--moments` and `--calls` make it shorter, for a look. Any fault is an exit
status of 1.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import attack_commands
import attack_memory
import numpy as np

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "attacks.md"

HEAD = """# Attacks

Made by `make attack`. A command is ended at random moments of its run, or a function is called until a leak would show.
"""

PARTS = ("kills", "signals", "memory")

#: A command has to have ended so soon after a signal, s.
SOON = 0.5
#: These take long and write once at their end.
LONG = ("tune", "papers")
#: One of so many moments falls into the last fifth of the run, where files are written.
LATE = 2


def moments(seconds: float, count: int, seed: int) -> np.ndarray:
    """Random moments of a run, every second one near its end."""
    rng = np.random.default_rng(seed)
    found = rng.uniform(0.0, 1.02 * seconds, count)
    found[::LATE] = rng.uniform(0.8 * seconds, 1.05 * seconds, len(found[::LATE]))
    return found


def run_until(process: subprocess.Popen[bytes], moment: float) -> bool:
    """Whether the process still runs at the moment."""
    try:
        process.wait(moment)
    except subprocess.TimeoutExpired:
        return True
    return False


def kills(folder: Path, count: int) -> tuple[list[str], int]:
    """kill -9: files are old or new, and results that are gone on to are those of an undisturbed run."""
    attack_commands.recordings(folder / "data", 3.0)
    lines = [
        "## kill -9",
        "",
        "Files that were there are as before, or whole and new. `tune` is started again with its checkpoint, and its",
        "result is that of an undisturbed run, byte for byte. Left over: hidden files of the writing that was cut off.",
        "",
        "| command | time of a run [s] | kills | before | new | neither | left over | resumed: equal |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    faults = 0
    for command in attack_commands.commands(folder / "data"):
        own = attack_commands.fresh(folder / "own")
        seconds, new = command.run(own)
        number = max(count // 10, 1) if command.name in LONG else count
        killed = old = wrong = left = equal = resumed = 0
        for moment in moments(seconds, number, 1):
            command.prepare(own)
            with command.start(own) as process:
                if run_until(process, float(moment)):
                    process.kill()
                    killed += 1
            bad = command.wrong(own, new)
            wrong += bool(bad)
            old += all((own / name).read_bytes() == command.before.get(name, attack_commands.OLD) for name in new)
            left += len(list(own.rglob(".*.part*")))
            if command.journal is not None:
                resumed += 1
                command.run(own)
                equal += all((own / name).read_bytes() == new[name] for name in new)
                (own / command.journal).unlink()
        faults += wrong + resumed - equal
        again = f"{equal} of {resumed}" if resumed else "–"
        new_ones = number - old - wrong
        lines.append(f"| {command.name} | {seconds:.1f} | {killed} | {old} | {new_ones} | {wrong} | {left} | {again} |")
        print(lines[-1], flush=True)
    return lines, faults


def signals(folder: Path, count: int) -> tuple[list[str], int]:
    """Ctrl-C and SIGTERM: an end soon, with one line, files old or new, nothing left over."""
    attack_commands.recordings(folder / "data", 30.0)
    lines = [
        "## Ctrl-C and SIGTERM",
        "",
        f"Half of the moments each, over recordings of half an hour. A command has to end within {SOON} s, with exit",
        "status 130 or 143, one line on standard error, and files as before or whole and new. A signal that comes",
        "while Python still imports (start-up) ends it by itself.",
        "",
        "| command | time of a run [s] | signals | in start-up | median [ms] | largest [ms] | too late | faults |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    faults = 0
    for command in attack_commands.commands(folder / "data"):
        own = attack_commands.fresh(folder / "own")
        seconds, new = command.run(own)
        ends, early, wrong = [], 0, []
        for index, moment in enumerate(moments(seconds, count, 2)):
            command.prepare(own)
            if command.journal is not None:
                (own / command.journal).unlink(missing_ok=True)
            number = signal.SIGINT if index % 2 else signal.SIGTERM
            with command.start(own) as process:
                if not run_until(process, float(moment)):
                    continue
                begin = time.monotonic()
                process.send_signal(number)
                _, told = process.communicate()
                ends.append(time.monotonic() - begin)
            status = process.returncode
            bad = command.wrong(own, new)
            left = [path.name for path in own.rglob(".*.part*")]
            by_python = status == -number
            early += by_python
            quiet = by_python or (status == 0 and not told) or (status == 128 + number and told.count(b"\n") == 1)
            if bad or left or not quiet:
                wrong.append(f"at {moment:.3f} s: {bad} {left} status {status} {told.decode()[-300:]!r}")
        late = sum(end > SOON for end in ends)
        faults += late + len(wrong)
        milliseconds = 1e3 * np.array(ends or [np.nan])
        lines.append(
            f"| {command.name} | {seconds:.1f} | {len(ends)} | {early} | {np.median(milliseconds):.0f} | "
            f"{milliseconds.max():.0f} | {late} | {len(wrong)} |"
        )
        print(lines[-1], *wrong[:5], sep="\n", flush=True)
    return lines, faults


def write(part: str, lines: list[str]) -> None:
    """Replace one part of the document."""
    text = DOCUMENT.read_text(encoding="utf-8") if DOCUMENT.exists() else HEAD
    begin, end = (f"<!-- {part}{slash} -->" for slash in ("", " end"))
    block = "\n".join([begin, "", *lines, "", end])
    before, found, rest = text.partition(begin)
    text = before + block + rest.partition(end)[2] if found else f"{text.rstrip()}\n\n{block}\n"
    DOCUMENT.write_text(text, encoding="utf-8")


def main() -> int:
    """Runs the parts that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], help="default: all")
    parser.add_argument(
        "--moments", type=int, default=200, help="of each command (tune and papers: a tenth of the kills)"
    )
    parser.add_argument("--calls", type=float, default=1.0, help="part of the calls of `memory`")
    parser.add_argument("--no-document", action="store_true", help="do not write docs/attacks.md")
    args = parser.parse_args()
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        for part in args.parts or PARTS:
            if part == "memory":
                lines, found = attack_memory.memory(args.calls)
            else:
                lines, found = (kills if part == "kills" else signals)(Path(folder), args.moments)
            faults += found
            if not args.no_document:
                write(part, lines)
    print(f"{faults} faults")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
