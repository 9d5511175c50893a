"""``ahrs-rs simulate``: a recording of a scenario, with its truth, into a file."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from ahrs_rs._printable import printable
from ahrs_rs.cli import _common
from ahrs_rs.cli._common import CliError, Commands
from ahrs_rs.simulate import SCENARIOS, SENSORS, Scenario

#: An hour at 1 kHz has 3.6 million; far more do not fit into memory.
MOST_SAMPLES = 50_000_000

EPILOG = """\
The file has the sensor's readings (gyr, acc, mag), the true orientation (ref, sensor to east-north-up), and in its
meta all parameters and what was drawn. Parameters are in rad, m, s, µT; "45deg" is 0.785.

  ahrs-rs simulate --list
  ahrs-rs simulate --scenario robot_arm --set speed=45deg --set gripper=20 -o arm.npz
  ahrs-rs simulate --scenario walking --sensor rough --rate 200 --seed 3 -o walk.npz
"""


def add_parser(commands: Commands) -> None:
    """The parser of this command."""
    parser = commands.add_parser(
        "simulate",
        help="simulate a recording with known orientation",
        description="Simulate a sensor that moves as a scenario says, and write its recording with the truth.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(function=simulate)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--scenario", metavar="NAME", help=f"one of {', '.join(SCENARIOS)}")
    what.add_argument("--list", action="store_true", help="tell about all scenarios and sensors, and end")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="where to write it (.npz)")
    parser.add_argument("--rate", type=_common.positive, metavar="HZ", help="sampling rate (default: the scenario's)")
    parser.add_argument("--duration", type=_common.positive, metavar="S", help="length (default: the scenario's)")
    parser.add_argument("--seed", type=int, default=0, help="of all that is random (default: %(default)s)")
    parser.add_argument(
        "--sensor",
        choices=list(SENSORS),
        metavar="NAME",
        help="%(choices)s (default: the scenario's)",
    )
    parser.add_argument(
        "--remaining",
        type=_common.finite,
        metavar="PART",
        help="part of the errors that a calibration takes away which is still there, 0 to 1 (default: the scenario's)",
    )
    parser.add_argument(
        "--gyr-bias",
        type=number,
        default=0.0,
        metavar="RAD/S",
        help="a constant bias that is added to all axes of the gyroscope (default: 0)",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a parameter of the scenario; may be repeated",
    )


def simulate(args: argparse.Namespace) -> int:
    """The command."""
    if args.list:
        print(listing())
        return 0
    if args.output is None:
        raise CliError("-o: expected a file to write to")
    if args.output.suffix.lower() != ".npz":
        raise CliError(f"-o: expected a name that ends in .npz, got {args.output.name!r}")
    _common.check_output(args.output, "-o")
    scenario = SCENARIOS.get(args.scenario)
    if scenario is None:
        raise CliError(f"--scenario: unknown {args.scenario!r}; there are {', '.join(SCENARIOS)}")
    options: dict[str, Any] = {
        name: getattr(args, name) for name in ("rate", "duration", "seed", "sensor", "remaining", "gyr_bias")
    }
    setup = scenario.setup(**options, **_params(scenario, _common.assignments(args.set)))
    if setup.count > MOST_SAMPLES:
        raise CliError(f"--duration: {setup.duration:g} s at {setup.rate:g} Hz are over {MOST_SAMPLES:,} samples")
    recording = setup.record(args.seed)
    recording.save(args.output)
    names = " ".join(name for name in ("gyr", "acc", "mag", "ref") if getattr(recording, name) is not None)
    length = f"{len(recording)} samples in {recording.duration:.6g} s at {recording.rate:.6g} Hz"
    print(f"wrote {printable(args.output)}: {length}")
    print(f"      {names}, seed {args.seed}")
    return 0


def listing() -> str:
    """All scenarios with their parameters, and the names of the sensors."""
    lines = []
    for name, scenario in SCENARIOS.items():
        lines.append(f"{name} ({scenario.rate:g} Hz, {scenario.sensor})")
        lines += [f"    {line}".rstrip() for line in scenario.doc.splitlines()]
        defaults = " ".join(f"{key}={_common.shown(value)}" for key, value in scenario.params.items())
        lines += [f"    Parameters: {defaults or 'none'}", ""]
    return "\n".join((*lines, f"sensors: {', '.join(SENSORS)}"))


def number(text: str) -> float:
    """A finite number, for argparse; an angle may be in degrees, like 45deg."""
    return math.radians(_common.finite(text[:-3])) if text.endswith("deg") else _common.finite(text)


def _params(scenario: Scenario, texts: dict[str, str]) -> dict[str, Any]:
    defaults = scenario.params
    params: dict[str, Any] = {}
    for name, text in texts.items():
        if name not in defaults:
            raise _common.unknown_parameter(f"{scenario.name} has", name, defaults)
        if isinstance(defaults[name], str):
            params[name] = text
            continue
        try:
            params[name] = number(text)
        except argparse.ArgumentTypeError:
            raise CliError(f"{scenario.name}.{name}: expected a number, got {text!r}") from None
    return params
