"""Search for the parameters of a filter with the smallest error over recordings.

>>> import ahrs_rs as ar
>>> recordings = [ar.simulate.demo(duration=20.0, seed=seed) for seed in range(4)]
>>> tuned = ar.tuning.grid(ar.Madgwick, {"beta": (0.01, 1.0)}, recordings, test=0.5)
>>> f = tuned.make(rate=100.0)

`grid` tries every combination, `evolve` is a genetic search (differential evolution, by scipy) for more than two or
three parameters. Both feed `ahrs_rs.sweep`, which computes the parameter sets side by side in vector registers.
"""

from ahrs_rs.tuning._evaluate import TuningInterrupted
from ahrs_rs.tuning._result import Scores, Tuned
from ahrs_rs.tuning._search import evolve, grid
from ahrs_rs.tuning._space import Axis, space

__all__ = ["Axis", "Scores", "Tuned", "TuningInterrupted", "evolve", "grid", "space"]
