"""docs/firmware.md from what `make firmware` has measured."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

DOCUMENT = Path(__file__).resolve().parents[1] / "docs" / "firmware.md"

HEAD = """# Firmware

Made by `make firmware` with {rust}, {arm-none-eabi-gcc} and {qemu-system-arm}.

Every streaming filter, in f32 and with its defaults, on an emulated Cortex-M4F (mps2-an386, {target}),
one image each. It replays {updates[1]:,} samples of a recording that is computed on the way, from whole numbers and the
core's own functions (firmware/src/recording.rs): a sensor that turns and shakes, steps of 8 to 11 ms and gaps of 2 s,
rests, missing rows, a disturbed field, a magnetometer that has a quarter of the rate for an eighth of the time. Each
row goes through calibration and low-pass filters (firmware/src/pipeline.rs) to the filter, as in an application. The
host runs the same source.
"""

COST = """
## What a filter costs

- *instructions* that one update executes, with the callees, counted by a plugin of the emulator; two runs give the
  same. These are instructions, not cycles: a division counts as one, memory is as fast as can be. A square root is the
  function of the crate `libm`.
- *flash*: text and data of a whole application that reads sensors, updates by 9D data and writes the attitude
  (firmware/src/bin/bare.rs), start-up included; without a filter it has {bare} bytes. The C example
  (crates/capi/examples/replay.c), with all that the interface does for a filter, and printing:
  {c}.
- *stack* below the caller's frame, painted before and searched after every update; *state*: the estimator's size.
  Flash, stack and state are in bytes.

Calibration of three sensors and low-pass filters (second order) of two take {prepare} instructions on average and
{prepare_max} at most before each update.
"""

HASHES = """
## The same bits as on the host

FNV-1a (64 bits) over every quaternion, bias and status after {updates[0]:,} updates, which are replayed at each
commit, and after {updates[1]:,}: the target gives what the host gives. No compiler changes them. An image with all
filters for a Cortex-M0 ({soft_target}, no floating-point unit) gives the host's bits, too, over {soft_updates} samples;
the C example gives Rust's, on the host and on the target.
"""

RATIOS = """
## Beside the papers

Their times and our instructions, each relative to the last of its paper. Hardware, implementations and units differ, so
that only the order of magnitude can be compared.

- Cirillo et al. 2014, Table 3: STM32F303 (Cortex-M4F), 9D, matrices by CMSIS: EKF 2.7 ms, Madgwick 0.15 ms, Mahony
  0.11 ms.
- Parikh et al. 2021, Table II: ESP32, 6D: Kalman 51 µs, Madgwick 17 µs, Mahony 14 µs, complementary 10 µs.
- Çoçoli & Badia 2023, Table II: Arduino Nano (8 bits), 6D: matrix 2477.4 µs, Kalman 1375.9 µs, Madgwick 1416.8 µs,
  Mahony 950.5 µs.
"""

#: Paper and mode, and its algorithms with their times in µs.
PAPERS = (
    ("Cirillo 2014", "9D", (("EKF", 2700.0), ("Madgwick", 150.0), ("Mahony", 110.0))),
    ("Parikh 2021", "6D", (("LinearKalman", 51.0), ("Madgwick", 17.0), ("Mahony", 14.0), ("Complementary", 10.0))),
    (
        "Çoçoli 2023",
        "6D",
        (("Trigonometric", 2477.4), ("LinearKalman", 1375.9), ("Madgwick", 1416.8), ("Mahony", 950.5)),
    ),
)


#: Columns that hold words.
TEXT = ("filter", "paper", "data")


def table(head: list[str], rows: list[list[str]]) -> str:
    lines = [
        "| " + " | ".join(head) + " |",
        "| " + " | ".join(["---" if name in TEXT else "---:" for name in head]) + " |",
    ]
    return "\n" + "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def cost_rows(filters: dict[str, Any]) -> list[list[str]]:
    rows = []
    for name, result in filters.items():
        counts = [f"{value:.0f}" for mode in ("9D", "6D") for value in (result[mode]["mean"], result[mode]["max"])]
        stack = max(result[mode]["stack"] for mode in ("9D", "6D"))
        rows.append([name, *counts, str(result["flash"]), str(stack), str(result["9D"]["state"])])
    return rows


def ratio_rows(filters: dict[str, Any]) -> list[list[str]]:
    rows = []
    for paper, mode, times in PAPERS:
        present = [(name, time, filters[name][mode]["mean"]) for name, time in times if name in filters]
        _, time_of_last, count_of_last = present[-1]
        for name, time, count in present:
            rows.append([paper, name, mode, f"{time / time_of_last:.2f}", f"{count / count_of_last:.2f}"])
    return rows


def document(results: dict[str, Any]) -> str:
    """The whole text."""
    filters, soft = results["filters"], results["soft"]
    prepare = next(iter(filters.values()))["9D"]["prepare"]
    c = results["c"]
    some = ", ".join(f"{name} {c[name]}" for name in ("Mahony", "Madgwick", "EKF", "VQF") if name in c)
    text = HEAD.format(**results["versions"], updates=results["updates"], target="thumbv7em-none-eabihf")
    text += COST.format(bare=results["bare"], c=some, prepare=f"{prepare[0]:.0f}", prepare_max=prepare[1])
    text += table(["filter", "9D mean", "9D max", "6D mean", "6D max", "flash", "stack", "state"], cost_rows(filters))
    updates = results["updates"]
    text += HASHES.format(soft_target="thumbv6m-none-eabi", soft_updates=f"{soft['updates']:,}", updates=updates)
    head = [f"{mode}, {count:,}" for mode in ("9D", "6D") for count in updates]
    hashes = {
        name: [f"`{each}`" for mode in ("9D", "6D") for each in filters[name][mode]["hashes"]] for name in filters
    }
    text += table(["filter", *head], [[name, *row] for name, row in hashes.items()])
    text += RATIOS
    text += table(["paper", "filter", "data", "time there", "instructions here"], ratio_rows(filters))
    return text


def comparable(kept: str, now: str) -> tuple[list[str], list[str]]:
    """What of two documents a short replay can tell: the hashes, and the sizes where the compilers are the same."""

    def made_with(text: str) -> str:
        return text.partition("Made by")[2].partition("\n\n")[0]

    def hashes(text: str) -> list[str]:
        return text.partition("## The same bits")[2].partition("## Beside")[0].splitlines()

    def sizes(text: str) -> list[str]:
        """Of a filter its flash and state, of an application without one and of the C example the flash."""
        costs = text.partition("## What a filter costs")[2].partition("## The same bits")[0]
        rows = [line.split("|")[1:-1] for line in costs.splitlines() if line.startswith("| ")]
        return ["|".join([row[0], row[5], row[7]]) for row in rows] + re.findall(r"it has \d+ bytes|\w+ \d{4,}", costs)

    if made_with(kept) != made_with(now):
        print("firmware: docs/firmware.md was made with other compilers: only the hashes are compared")
        return hashes(kept), hashes(now)
    return sizes(kept) + hashes(kept), sizes(now) + hashes(now)
