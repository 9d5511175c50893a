"""`SelfCalSmoother` as one least-squares problem for each pass: all measurements of a recording at once.

The error of the states at the ends of all blocks is linear in what is unknown: the error at the start, and what enters
in each block. Both in units of their standard deviations are a vector u with the covariance 1 before anything is
measured. So states without noise need nothing of their own: they have no entry of u, and no covariance is inverted.
Measurements in units of their deviations are y = A u + noise, and

    u = (1 + Aᵀ A)⁻¹ Aᵀ y with the covariance (1 + Aᵀ A)⁻¹.

No filter, no recursion backward. What goes forward is only the variance of the inclination, by which the magnetometer's
rows are given more noise (see `Problem.field`).
"""

import math
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_solve, solve_triangular

from .base import Told
from .driver import (
    ACC_MISSING,
    GAP,
    GYR_HELD,
    MAG_MISSING,
    NOT_ALIGNED,
    REPEATED,
    Driver,
    OracleResult,
    Settings,
    rows,
    time_steps,
)
from .gyro_integration import gyro_step
from .kalman import MAG_REJECTED, REST, Array, reported, rotation, saturated, triple
from .selfcal import SelfCalKF
from .selfcal_model import (
    ACC_BIAS,
    BIAS,
    DELAY,
    DISTURBANCE,
    GRAVITY,
    HORIZONTAL,
    IRON,
    LONGEST_FIELD,
    LONGEST_FORCE,
    MATRIX,
    VELOCITY,
    Block,
    N,
    Parameters,
    Slip,
    block_ends,
    corrected,
    detected,
    find_clipped,
)
from .so3 import Quat, Vec3, conjugate, exp_half, multiply, normal, normalize, rotation_vector

#: How often the trajectory is smoothed, at least and at most, and the correction (rad) that is small enough to end.
PASSES, MOST_PASSES, CONVERGED = 2, 8, 0.01
#: How often the variance of an angle of the inclination is noise of the field.
INCLINATION_NOISE = 4.0
#: How far (rad/s) a rate may be beyond the gyroscope's range.
BEYOND_RANGE = 3.0
#: The states of whose covariance something is reported at every block: attitude and gyroscope's bias.
ASKED = 6


@dataclass
class SmootherParameters(Parameters):
    """Those of the smoother, where they differ from the filter's."""

    rate_noise: float = 1.4e-3
    bias_noise: float = 2e-4
    velocity: float = 0.6
    velocity_noise: float = 0.03
    mag_noise: float = 0.035
    mag_tail: float = 2.5
    disturbance_time: float = 12.0
    hard_iron_noise: float = 0.0
    rest_noise: float = 2e-3
    initial_velocity: float = 3.0
    initial_gravity: float = 0.015
    initial_hard_iron: float = 0.0
    initial_field: float = 0.1
    initial_delay: float = 0.01


class Causal(SelfCalKF):
    """The filter, and the rates that it was given: where rows are missing, the held ones; and what was lost.

    Losses that the data do not tell of are no matter of this oracle: it fails where the watch starts the filter anew.
    """

    def __init__(self, **params: float) -> None:
        super().__init__(**params)
        self.rates: list[Array] = []
        #: The variance (rad²) of the rotation that was lost in each step.
        self.lost: list[float] = []
        #: The gyroscope's bias after each step.
        self.biases: list[Array] = []
        #: The samples before whose step the attitude was found again.
        self.found: list[int] = []
        self._losing, self._realigned = 0.0, False

    def lose_rotation(self, variance: float) -> None:
        """What is unknown after the attitude was found again is no loss."""
        self._losing = self._losing if self._realigned else variance
        super().lose_rotation(variance)

    def realign(self, q: Quat) -> None:
        """The attitude was found again before the step that comes."""
        self._realigned = True
        self.found.append(len(self.rates))
        super().realign(q)

    def reopen(self, bias: Vec3) -> None:
        """No case of this oracle loses the attitude without having been told."""
        raise AssertionError("the watch has started the filter anew")

    def step(self, gyr: Vec3, acc: Vec3 | None, mag: Vec3 | None, dt: float, told: Told) -> None:
        """One sample."""
        self.rates.append(np.array(gyr))
        self.lost.append(self._losing)
        self._losing, self._realigned = 0.0, False
        super().step(gyr, acc, mag, dt, told)
        self.biases.append(self.x[BIAS:MATRIX].copy())


@dataclass
class Node:
    """The estimate at the end of a block: attitude, and the other states (zeros in the attitude's place)."""

    q: Quat
    x: Array


@dataclass
class Summed:
    """A block about a trajectory: its sums, the attitude to which its rates lead, and how its field counts."""

    block: Block
    q: Quat
    interval: float
    lost: Array
    weight: float = 1.0


@dataclass
class Samples:
    """A recording: rates (rad/s), specific forces, fields in norms of the median one, steps (s), ends of the blocks.

    `lost_variance` is that of the rotation (rad²) that was lost in each step.
    """

    rates: list[Array]
    lost_variance: list[float]
    acc: list[Array | None]
    mag: list[Array | None]
    dt: list[float]
    rest: list[bool]
    clipped: Array
    ends: list[int]

    def blocks(self, nodes: list[Node]) -> list[Summed]:
        """The sums about a trajectory."""
        slip, since, interval, start = Slip(), 0.0, 0.0, 0
        found = []
        for node, end in zip(nodes, self.ends, strict=False):
            block, q = Block(), node.q
            for i in range(start, end):
                dt, (rate, turning) = self.dt[i], corrected(self.rates[i], node.x)
                q = gyro_step(q, triple(turning), dt, "exponential")
                r, turning = rotation(q), saturated(turning, 1e4)
                block.turns(r, self.rates[i], rate, turning, dt, lost=self.lost_variance[i] > 0.0)
                block.slip += slip.step(turning, dt)
                since = min(since + dt, LONGEST_FORCE)
                if (force := self.acc[i]) is not None:
                    block.pushes(r, force, node.x, since)
                    since = 0.0
                block.rest += dt if self.rest[i] else 0.0
                if (field := self.mag[i]) is not None:
                    block.points(r, field, turning, node.x)
            interval = min(interval + block.time, LONGEST_FIELD)
            found.append(Summed(block, q, interval, self.lost(block, slice(start, end))))
            interval = 0.0 if block.fields else interval
            start = end
        return found

    def lost(self, block: Block, part: slice) -> Array:
        """The covariance of the turn that no gyroscope shows, clipped or lost; such a block shows no matrix either."""
        times = np.array(self.dt[part]) @ self.clipped[part]
        variance = sum(self.lost_variance[part])
        if not times.any() and variance == 0.0:
            return np.zeros((3, 3))
        block.matrix = np.zeros((3, 9))
        factor: Array = block.turn * (BEYOND_RANGE * times / block.time)
        return factor @ factor.T + variance * np.eye(3)

    def attitudes(self, nodes: list[Node]) -> tuple[list[Quat], list[Array]]:
        """Of all samples: the rates from a node on, what is left at the next spread evenly; and their turning rates."""
        quats, turnings, start = [], [], 0
        for node, following, end in zip(nodes, nodes[1:], self.ends, strict=False):
            part, q, time = [], node.q, 0.0
            for i in range(start, end):
                _, turning = corrected(self.rates[i], node.x)
                q = gyro_step(q, triple(turning), self.dt[i], "exponential")
                time += self.dt[i]
                part.append((q, time))
                turnings.append(saturated(turning, 1e4))
            left = np.array(rotation_vector(multiply(following.q, conjugate(q))))
            quats += [multiply(exp_half(triple(left * 0.5 * (t / time if time else 0.0))), one) for one, t in part]
            start = end
        return quats, turnings


class Problem:
    """All blocks about a trajectory, linear in u."""

    def __init__(self, k: Parameters, blocks: list[Summed], nodes: list[Node], prior: Array) -> None:
        self.k, self.blocks, self.nodes = k, blocks, nodes
        sigma = np.sqrt(k.initial_variances())
        #: The error at the end of the last block is mean + spread u.
        self.mean = prior - nodes[0].x  # of the attitude nothing is known beyond the trajectory itself
        self.spread = np.diag(sigma)
        #: What is known by the measurements so far; of it only the variance of the inclination is used.
        self.p = np.diag(sigma**2)
        self.rows: list[Array] = []
        self.y: list[float] = []
        self.means, self.spreads = [self.mean], [self.spread]
        for index, summed in enumerate(blocks):
            self.go_on(index, summed)
        width = self.spread.shape[1]
        a = np.array([np.pad(row, (0, width - len(row))) for row in self.rows])
        self.factor = np.linalg.cholesky(np.eye(width) + a.T @ a)
        self.u = cho_solve((self.factor, True), a.T @ np.array(self.y))

    def go_on(self, index: int, summed: Summed) -> None:
        """Over a block, and its measurements."""
        k, block, node, following = self.k, summed.block, self.nodes[index], self.nodes[index + 1]
        kept = math.exp(-block.time / k.disturbance_time)
        f = block.transition(node.x)
        f[DISTURBANCE:HORIZONTAL, DISTURBANCE:HORIZONTAL] *= kept
        noise = np.diag(block.noise(k, kept))
        noise[:3, :3] += summed.lost
        self.mean = f @ self.mean
        enters = np.flatnonzero(np.diag(noise))
        entering = np.zeros((N, len(enters)))
        entering[enters] = np.linalg.cholesky(noise[np.ix_(enters, enters)])
        self.spread = np.hstack((f @ self.spread, entering))
        self.p = f @ self.p @ f.T + noise

        x, unit = block.predicted(node.x, kept), np.eye(N)
        rests = block.time < 1.001 * block.rest
        for i in range(VELOCITY, ACC_BIAS):
            self.take(unit[i], -x[i], k.velocity_variance(rests, block.time))
        if rests:
            for i in range(3):
                self.take(unit[BIAS + i], block.gyr[i] / block.time - x[BIAS + i], k.rest_noise**2 / block.time)
        if block.fields and summed.weight > 1e-4:
            variance = k.field_variance(block, summed.interval, summed.weight)
            for h, z in zip(*block.field_rows(x), strict=True):
                self.field(h, z, variance)

        # From now on the error of the next node's states.
        turn = rotation_vector(multiply(summed.q, conjugate(following.q)))
        self.mean = self.mean + np.concatenate((turn, (x - following.x)[3:]))
        self.means.append(self.mean)
        self.spreads.append(self.spread)

    def field(self, h: Array, z: float, variance: float) -> None:
        """The field is not to move the inclination: what that does to it is noise."""
        tilt = (self.p[0, 0] + self.p[1, 1]) / 2
        variance += INCLINATION_NOISE * tilt * float(h[:2] @ h[:2])
        self.take(np.concatenate(([0.0, 0.0], h[2:])), z, variance)

    def take(self, h: Array, z: float, variance: float) -> None:
        """A measurement z = h x + noise."""
        sigma = math.sqrt(variance)
        self.rows.append(h @ self.spread / sigma)
        self.y.append((z - float(h @ self.mean)) / sigma)
        ph = self.p @ h
        self.p = self.p - np.outer(ph, ph) / (h @ ph + variance)

    def smoothed(self) -> list[Node]:
        """The trajectory with its errors taken out."""
        nodes = []
        for node, mean, spread in zip(self.nodes, self.means, self.spreads, strict=True):
            error = mean + spread @ self.u[: spread.shape[1]]
            turned = normalize(multiply(exp_half(triple(error[:3] / 2)), node.q))
            nodes.append(Node(turned, node.x + np.concatenate((np.zeros(3), error[3:]))))
        return nodes

    def covariances(self) -> list[Array]:
        """Of the states at the end of each block, `ASKED` of them."""
        asked = [np.pad(spread[:ASKED].T, ((0, len(self.u) - spread.shape[1]), (0, 0))) for spread in self.spreads[1:]]
        half = solve_triangular(self.factor, np.hstack(asked), lower=True)
        return [part.T @ part for part in np.split(half, len(asked), axis=1)]

    def covariance(self, node: int) -> Array:
        """Of all states at the end of a block, or with 0 at the start."""
        spread = self.spreads[node]
        half = solve_triangular(self.factor, np.eye(len(self.u), spread.shape[1]) @ spread.T, lower=True)
        covariance: Array = half.T @ half
        return covariance


class SelfCalSmoother:
    """The smoother in east-north-up; a recording has an accelerometer."""

    def __init__(self, **params: float) -> None:
        self.k = SmootherParameters(**params)
        self.passes = 0
        #: That of the last pass, and the unit of its fields in that of the magnetometer.
        self.problem: Problem | None = None
        self.norm = 1.0

    def run(
        self,
        gyr: ArrayLike,
        acc: ArrayLike,
        mag: ArrayLike | None,
        *,
        t: ArrayLike | None = None,
        rate: float | None = None,
        gyr_hold: str = "zero-order",
    ) -> OracleResult:
        """All outputs of a recording; rows of NaN are missing."""
        k, count = self.k, len(np.asarray(gyr))
        usable = [
            [np.array(v) if v is not None and normal(v) else None for v in rows(*named, count)]
            for named in (("acc", acc), ("mag", mag))
        ]
        norm = median([float(np.linalg.norm(v)) for v in usable[1] if v is not None])
        fields = [None if v is None else v / norm for v in usable[1]]
        dt = time_steps(count, t, rate, False, False)

        causal = Causal(**{**asdict(k), "latency": 0.0})
        driver = Driver(causal, None, Settings(gyr_hold=gyr_hold))
        none = (math.nan, math.nan, math.nan)
        quats, missing = [], []
        for omega, force, field, step in zip(rows("gyr", gyr, count), usable[0], fields, dt, strict=True):
            seen = None if mag is None else none if field is None else triple(field)
            q, flags = driver.feed(omega, none if force is None else triple(force), seen, step)
            quats.append(q)
            missing.append(flags & (ACC_MISSING | MAG_MISSING | GYR_HELD | GAP | REPEATED))
        for index in causal.found:
            # The attitude that was found, turned back by the gyroscope to the end of the loss.
            q, bias_then = quats[index], causal.biases[index]
            while causal.lost[index] == 0.0 and index > 0:
                q = gyro_step(q, triple(causal.rates[index] - bias_then), -dt[index], "exponential")
                index -= 1
                quats[index] = q
        known = causal.x.copy()
        known[VELOCITY:ACC_BIAS] = known[DISTURBANCE:HORIZONTAL] = 0.0
        known[IRON:DISTURBANCE] = causal.outputs()["hard_iron"]

        rates, bias = causal.rates, known[BIAS:MATRIX]
        forward = detected(rates, usable[0], dt, bias, k)
        backward = detected(rates[::-1], usable[0][::-1], [0.0, *dt[:0:-1]], bias, k)
        rest = [a or b for a, b in zip(forward, backward[::-1], strict=True)]
        clipped = find_clipped(np.array(rates), k)
        samples = Samples(rates, causal.lost, usable[0], fields, dt, rest, clipped, block_ends(dt))
        nodes = [Node(q, known) for q in [quats[0], *(quats[end - 1] for end in samples.ends)]]
        blocks = samples.blocks(nodes)
        clean = [summed.block.clean(known) for summed in blocks if summed.block.fields]
        reference = [median([math.hypot(x, y) for x, y, _ in clean]), median([float(z) for _, _, z in clean])]
        known[HORIZONTAL:DELAY] = reference
        prior = np.zeros(N)
        still = [float(np.linalg.norm(v)) for v, rests in zip(usable[0], rest, strict=True) if rests and v is not None]
        length = median(still) if still else k.gravity
        prior[GRAVITY] = k.gravity if abs(length - k.gravity) < 0.1 else length
        prior[HORIZONTAL:DELAY] = reference

        correction, self.passes = math.inf, 0
        while self.passes < PASSES or (self.passes < MOST_PASSES and correction >= CONVERGED):
            if self.passes:
                blocks = samples.blocks(nodes)
            weigh(blocks, nodes, k)
            before = nodes
            problem = self.problem = Problem(k, blocks, before, prior)
            nodes = problem.smoothed()
            turns = [multiply(a.q, conjugate(b.q)) for a, b in zip(nodes, before, strict=True)]
            correction = max(math.hypot(*rotation_vector(turn)) for turn in turns)
            self.passes += 1
        self.norm = norm
        return self.report(samples, nodes, problem, np.array(missing), norm)

    def report(
        self,
        samples: Samples,
        nodes: list[Node],
        problem: Problem,
        missing: Array,
        norm: float,
    ) -> OracleResult:
        """One entry a sample: what is known at the end of its block."""
        blocks, sigma, covariances = problem.blocks, np.sqrt(np.diag(problem.covariance(-1))), problem.covariances()
        quats, turnings = samples.attitudes(nodes)
        headed = any(field is not None for field in samples.mag)
        ahead = [exp_half(triple(turning * (0.5 * self.k.latency))) for turning in turnings]
        quats = [normalize(multiply(q, turn)) for q, turn in zip(quats, ahead, strict=True)]
        of = np.repeat(np.arange(len(blocks)), np.diff([0, *samples.ends]))
        covariance = []
        for q, block in zip(quats, of, strict=True):
            r = rotation(q)
            covariance.append(reported(r.T @ covariances[block][:3, :3] @ r, r[2], headed))
        quat = np.array(quats)
        signs = np.sign(np.cumprod(np.sign([quat[0, 0], *np.sum(quat[1:] * quat[:-1], axis=1)])))
        ends = np.array([node.x for node in nodes[1:]])[of]
        rejected = np.array([bool(summed.block.fields) and summed.weight < 0.25 for summed in blocks])[of]
        rejected &= np.array([field is not None for field in samples.mag])
        status = missing | np.where(samples.rest, REST, 0) | np.where(rejected, MAG_REJECTED, 0)
        if all(force is None for force in samples.acc):
            status = status | NOT_ALIGNED
        extra = {
            "covariance": np.array(covariance),
            "bias_sigma": np.sqrt([np.diag(p)[BIAS:ASKED].max() for p in covariances])[of],
            "gyr_matrix": ends[:, MATRIX:VELOCITY].reshape(-1, 3, 3),
            "gyr_matrix_sigma": np.tile(sigma[MATRIX:VELOCITY].reshape(3, 3), (len(of), 1, 1)),
            "acc_bias": ends[:, ACC_BIAS:GRAVITY],
            "mag_delay": ends[:, DELAY],
            "mag_delay_sigma": np.full(len(of), sigma[DELAY]),
            "hard_iron": ends[:, IRON:DISTURBANCE] * norm,
            "disturbance": ends[:, DISTURBANCE:HORIZONTAL] * norm,
            "mag_weight": np.array([summed.weight for summed in blocks])[of],
            "mag_reference": ends[:, HORIZONTAL:DELAY] * norm,
        }
        return OracleResult(quat * signs[:, None], ends[:, BIAS:MATRIX], status.astype(np.uint16), extra)


def weigh(blocks: list[Summed], nodes: list[Node], k: Parameters) -> None:
    """The weight of each field: by its deviation, or the mean of it and the two on either side where that is larger."""
    seen = [
        (summed, summed.block.deviation(node.x))
        for summed, node in zip(blocks, nodes, strict=False)
        if summed.block.fields
    ]
    off = np.array([deviation for _, deviation in seen])
    for i, (summed, deviation) in enumerate(seen):
        summed.weight = k.weight(max(deviation, float(off[max(i - 2, 0) : i + 3].mean())))


def median(values: list[float]) -> float:
    """The upper one of two; one of none."""
    return sorted(values)[len(values) // 2] if values else 1.0
