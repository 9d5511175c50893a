"""The scenarios. Each is one function; lengths are in m, angles in rad, times in s, fields in µT.

What a paper does not tell (angles, distances, pauses) is chosen here so that what it does tell (speeds, rates,
durations, numbers of samples) comes out, and the docstring says what is whose.
"""

from __future__ import annotations

import math

import numpy as np

from ahrs_rs._typing import FloatArray
from ahrs_rs.simulate._demo import hand_held, resting
from ahrs_rs.simulate._functions import Modulo, Piecewise, Polynomial, Sum, Waves, bumps, constant, moves, spline
from ahrs_rs.simulate._magnetic import DEGREE, Dipole, Disturbance, IronFloor, Switched
from ahrs_rs.simulate._motion import (
    Compound,
    EulerMotion,
    Motion,
    PacedMotion,
    SplineMotion,
    ThrustMotion,
    from_euler,
    still,
)
from ahrs_rs.simulate._noise import Part, stream
from ahrs_rs.simulate._record import check_positive
from ahrs_rs.simulate._scenarios import Plan, registered
from ahrs_rs.simulate._sensor import Temperature

AXES = np.eye(3)


@registered(rate=100.0, sensor="mpu9250", remaining=0.05)
def demo(seed: int, duration: float | None) -> Plan:
    """A hand-held sensor that turns and moves in all directions and rests a fifth of the time.

    The motion of `simulate.demo`.
    """
    length = 60.0 if duration is None else duration
    motion_stream = np.random.default_rng(np.random.SeedSequence(seed).spawn(1)[0])
    pace = resting(length)
    return Plan(motion=hand_held(motion_stream, pace), duration=length, scored=((pace.rest, math.inf),))


@registered(rate=100.0, sensor="mpu9250")
def static(seed: int, duration: float | None, *, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Plan:
    """A sensor that lies still, at the given Euler angles.

    With `sensor="mpu6050"`, `rate=160` and `duration=12.5`: the stationary test of Çoçoli & Badia, 2000 samples.
    """
    return Plan(motion=still(roll, pitch, yaw), duration=60.0)


@registered(rate=100.0, sensor="mpu9250", remaining=0.05)
def way_points(
    seed: int, duration: float | None, *, interval: float = 0.5, turn: float = 50.0 * DEGREE, reach: float = 0.3
) -> Plan:
    """A smooth random path: splines through random orientations and places.

    From one way point to the next, `interval` later, it turns by up to `turn` about any axis; the places are within
    `reach` of the origin.
    """
    _positive(interval=interval, turn=turn, reach=reach)
    length = 60.0 if duration is None else duration
    draw = stream(seed, Part.MOTION)
    count = max(2, round(length / interval) + 1)
    axes = draw.standard_normal((count - 1, 3))
    turns = axes / np.linalg.norm(axes, axis=1, keepdims=True) * draw.uniform(0.3, 1.0, (count - 1, 1)) * turn
    places = draw.uniform(-reach, reach, (count, 3))
    motion = SplineMotion.through_turns(turns, interval, spline(places, interval))
    return Plan(motion=motion, duration=length)


@registered(rate=500.0, sensor="stm32f3discovery")
def robot_arm(
    seed: int,
    duration: float | None,
    *,
    speed: float = 18.0 * DEGREE,
    angle: float = 30.0 * DEGREE,
    gripper: float = 0.0,
    lever: float = 0.1,
) -> Plan:
    """Cirillo et al. 2014: a robot turns the sensor about one axis at a time, then about all three together.

    After 6 s of rest, roll, pitch and yaw go to `angle`, to -`angle` and back with the mean speed `speed` (18 °/s: 40 s
    in all; 45 °/s: 22 s, as in their figures), with rests of 1 s; then all together. The sensor stands `lever` above
    the axes. With `gripper` (µT) above zero the gripper is opened and closed every second all the time, and disturbs
    the magnetometer by a field of this size and noise of a third of it. Phases: static, dynamic, roll, pitch, yaw,
    combined.
    """
    _positive(speed=speed, angle=angle)
    _not_negative(gripper=gripper)
    quarter = angle / speed
    steps: list[tuple[float, FloatArray]] = [(6.0, np.zeros(3))]
    phases = {"static": [(0.0, 6.0)], "dynamic": [(6.0, 0.0)]}
    corner = np.array([1.0, 1.0, -1.0])
    now = 6.0
    for name, axis in (("roll", AXES[0]), ("pitch", AXES[1]), ("yaw", AXES[2]), ("combined", corner)):
        turn = angle * axis
        steps += [(quarter, turn), (2.0 * quarter, -turn), (quarter, 0.0 * turn), (1.0, 0.0 * turn)]
        phases[name] = [(now, now + 4.0 * quarter)]
        now += 4.0 * quarter + 1.0
    phases["dynamic"] = [(6.0, now - 1.0)]
    phases["static"].append((now - 1.0, now + 2.0))
    disturbances: tuple[Disturbance, ...] = ()
    if gripper > 0.0:
        size = gripper / math.sqrt(3.0)
        disturbances = (Switched(amplitude=(size, -size, size), period=2.0, rise=0.05, noise=gripper / 3.0),)
    return Plan(
        motion=EulerMotion(moves(np.zeros(3), steps), lever=(0.0, 0.0, lever)),
        duration=now + 2.0,
        disturbances=disturbances,
        phases={name: tuple(pairs) for name, pairs in phases.items()},
    )


@registered(rate=200.0, sensor="mpu6050", remaining=0.02)
def back_and_forth(
    seed: int,
    duration: float | None,
    *,
    bank: float = 0.0,
    acceleration: float = 4.0,
    stroke: float = 0.5,
    strokes: float = 6.0,
) -> Plan:
    """Parikh et al. 2021, cases 1 and 2: the sensor is moved back and forth along each axis of the earth, level or
    banked.

    After 5 s of rest: `strokes` strokes of `stroke` s each along x, y and z, with a largest acceleration of
    `acceleration` m/s². With `bank` (15° in the paper) the sensor rolls to this angle first, does them, comes back,
    then pitches to it and does them again. Distances and times are ours. Phases: static, accelerating.
    """
    _positive(acceleration=acceleration, stroke=stroke, strokes=strokes)
    distance = acceleration * stroke**2 / 7.5  # the rise of the speed is steepest at its middle: 1.875 of the mean
    angle_steps: list[tuple[float, FloatArray]] = [(5.0, np.zeros(3))]
    path_steps: list[tuple[float, FloatArray]] = [(5.0, np.zeros(3))]
    now = 5.0
    busy = []

    def rest(length: float, angles: FloatArray) -> None:
        nonlocal now
        angle_steps.append((length, angles))
        path_steps.append((length, np.zeros(3)))
        now += length

    for attitude in [bank * AXES[0], bank * AXES[1]] if bank else [np.zeros(3)]:
        rest(2.0, attitude)
        rest(1.0, attitude)
        start = now
        for axis in AXES:
            for i in range(2 * math.ceil(0.5 * strokes)):
                path_steps.append((stroke, distance * axis * ((i + 1) % 2)))
            lasting = stroke * 2 * math.ceil(0.5 * strokes)
            angle_steps.append((lasting, attitude))
            now += lasting
            rest(1.0, attitude)
        busy.append((start, now - 1.0))
        rest(2.0, np.zeros(3))
    rest(3.0, np.zeros(3))
    motion = EulerMotion(moves(np.zeros(3), angle_steps), moves(np.zeros(3), path_steps, ramp=0.5))
    return Plan(motion=motion, duration=now, phases={"static": ((0.0, 5.0),), "accelerating": tuple(busy)})


@registered(rate=200.0, sensor="mpu6050", remaining=0.02)
def vibration(
    seed: int,
    duration: float | None,
    *,
    rotor_speed: float = 900.0,
    acc: float = 3.0,
    gyr: float = 15.0 * DEGREE,
    roll: float = 0.0,
    pitch: float = 0.0,
) -> Plan:
    """Parikh et al. 2021, case 3: a steady sensor under heavy vibration of four rotors.

    `rotor_speed` is in rad/s (900: 8600 rpm), `acc` (m/s²) and `gyr` (rad/s) are the root mean squares of the vibration
    on each axis. The numbers are ours: the paper gives none. The vibration is above half the sampling rate and so folds
    down.
    """
    _positive(rotor_speed=rotor_speed)
    _not_negative(acc=acc, gyr=gyr)
    base = still(roll, pitch)
    return Plan(motion=Compound(base, rotors(stream(seed, Part.MOTION), rotor_speed, acc, gyr)), duration=30.0)


@registered(rate=100.0, sensor="mpu9250", remaining=0.05)
def quadrotor(
    seed: int,
    duration: float | None,
    *,
    speed: float = 1.2,
    acc: float = 0.5,
    gyr: float = 4.0 * DEGREE,
    iron: float = 5.0,
) -> Plan:
    """Ludwig & Burnham 2018: a quadrotor flies around a rectangle of 5 × 4 m in a room; 6401 samples at 100 Hz.

    It takes off, flies the sides with the mean speed `speed`, turns by 90° at every corner and lands, so the heading
    passes ±180°. The attitude follows from the acceleration: the thrust is along its z axis. `acc` (m/s²) and `gyr`
    (rad/s) are the root mean squares of the rotors' vibration, `iron` (µT) the disturbance of the field by iron in the
    floor, at the floor. The paper gives the shape, the number of samples and that the field was disturbed; the rest is
    ours. Phases: flight.
    """
    _positive(speed=speed)
    _not_negative(acc=acc, gyr=gyr, iron=iron)
    corners = np.array([[5.0, 0.0], [5.0, 4.0], [0.0, 4.0], [0.0, 0.0]])
    height = 1.5
    path: list[tuple[float, FloatArray]] = [(5.0, np.zeros(3)), (4.0, np.array([0.0, 0.0, height]))]
    turns: list[tuple[float, FloatArray]] = [(9.0, np.zeros(1))]
    place = np.zeros(2)
    for i, corner in enumerate(corners):
        time = float(np.abs(corner - place).sum()) / speed + 3.0
        path += [(1.0, np.append(place, height)), (time, np.append(corner, height)), (2.0, np.append(corner, height))]
        turns += [(1.0 + time, np.array([i * 90.0 * DEGREE])), (2.0, np.array([(i + 1) * 90.0 * DEGREE]))]
        place = corner
    path += [(1.0, np.array([0.0, 0.0, height])), (5.0, np.zeros(3))]
    end = sum(step[0] for step in path)
    flight = ThrustMotion(moves(np.zeros(3), path, ramp=0.5, smoothness=3), moves(np.zeros(1), turns, ramp=0.5))
    return Plan(
        motion=Compound(flight, rotors(stream(seed, Part.MOTION), 500.0, acc, gyr)),
        duration=64.01,
        disturbances=(IronFloor(deviation=iron, seed=seed),) if iron > 0.0 else (),
        phases={"flight": ((5.0, end),)},
    )


@registered(rate=160.0, sensor="mpu6050", remaining=0.05)
def moving_hand(
    seed: int,
    duration: float | None,
    *,
    roll: float = 15.0 * DEGREE,
    pitch: float = -15.0 * DEGREE,
    swing: float = 8.0 * DEGREE,
    acceleration: float = 1.0,
) -> Plan:
    """Çoçoli & Badia 2023, in movement: moved by hand within less than 90°, 2000 samples at 160 Hz.

    The mean `roll` and `pitch` are those of their figures; about them it swings by some `swing`, and it is moved with
    some `acceleration` (m/s²). 160 Hz is one over the sum of their four processing times, 6.2 ms. The field is not
    measured.
    """
    _not_negative(swing=swing, acceleration=acceleration)
    draw = stream(seed, Part.MOTION)
    frequency = 2.0 * math.pi * draw.uniform(0.2, 1.5, (6, 3))
    phase = draw.uniform(0.0, 2.0 * math.pi, (6, 3))
    size = math.sqrt(2.0 / 3.0)
    angles = Waves(np.full((3, 3), swing * size), frequency[:3], phase[:3])
    path = Waves(acceleration * size / frequency[3:] ** 2, frequency[3:], phase[3:])
    return Plan(motion=EulerMotion(Sum((constant([roll, pitch, 0.0]), angles)), path), duration=12.5)


#: Roll, pitch, yaw in degrees and places in m of the rotation test, one a second at full speed; the last is the first.
ROTATION_PATH = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [40.0, 0.0, 30.0, 0.1, 0.0, 0.1],
        [40.0, -30.0, 60.0, 0.2, 0.1, 0.1],
        [-20.0, -40.0, 20.0, 0.2, 0.2, 0.0],
        [-60.0, 20.0, -30.0, 0.1, 0.2, -0.1],
        [0.0, 50.0, -70.0, 0.0, 0.1, -0.1],
        [50.0, 30.0, 0.0, -0.1, 0.1, 0.0],
        [20.0, -20.0, 60.0, -0.1, 0.0, 0.1],
        [-30.0, 0.0, 20.0, 0.0, 0.0, 0.1],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ]
)


@registered(rate=150.0, sensor="inertialink", remaining=0.02)
def rotation_test(seed: int, duration: float | None, *, interval: float = 0.8, rest: float = 5.0) -> Plan:
    """Hyyti & Visala 2015, rotation test: a path in 6D driven four times, each time at half the speed of the time
    before.

    The path goes through ten poses, one every `interval` s at full speed, with rests of `rest` s between the runs. The
    path is ours; four runs, halved speeds and 150 Hz are theirs. For the bias test give `gyr_bias`. Phases: static,
    run_1 to run_4.
    """
    _positive(interval=interval, rest=rest)
    count = len(ROTATION_PATH) - 1
    path = SplineMotion.through(
        from_euler(ROTATION_PATH[:, :3] * DEGREE), interval, spline(ROTATION_PATH[:, 3:], interval)
    )
    length = count * interval
    steps: list[tuple[float, FloatArray]] = [(rest, np.zeros(1))]
    phases = {"static": ((0.0, rest),)}
    now = rest
    for run in range(1, 5):
        time = 1.1 * length * 2.0 ** (run - 1)
        end = np.array([run * length])
        steps += [(time, end), (rest, end)]
        phases[f"run_{run}"] = ((now, now + time),)
        now += time + rest
    pace = Modulo(moves(np.zeros(1), steps, ramp=0.05), length)
    return Plan(motion=PacedMotion(path, pace), duration=now, phases=phases)


@registered(rate=150.0, sensor="inertialink", remaining=0.02)
def acceleration_test(
    seed: int,
    duration: float | None,
    *,
    speed: float = 1.0,
    distance: float = 0.4,
    wobble: float = 0.2 * DEGREE,
) -> Plan:
    """Hyyti & Visala 2015, acceleration test: back and forth along x, y and z, each four times, at halved speeds.

    The largest `speed` (m/s) and the `distance` are ours, the order is theirs. `wobble` is the amplitude of what little
    it rotates. For the bias test give `gyr_bias`. Phases: static, x, y, z.
    """
    _positive(speed=speed, distance=distance)
    steps: list[tuple[float, FloatArray]] = [(5.0, np.zeros(3))]
    phases = {"static": ((0.0, 5.0),)}
    now = 5.0
    for name, axis in zip("xyz", AXES, strict=True):
        start = now
        for run in range(4):
            time = 2.0 * distance / speed * 2.0**run
            steps += [(time, distance * axis), (time, np.zeros(3)), (0.5, np.zeros(3))]
            now += 2.0 * time + 0.5
        phases[name] = ((start, now),)
        steps.append((2.0, np.zeros(3)))
        now += 2.0
    draw = stream(seed, Part.MOTION)
    frequency = 2.0 * math.pi * draw.uniform(0.05, 0.5, (3, 3))
    angles = Waves(np.full((3, 3), wobble / 3.0), frequency, draw.uniform(0.0, 2.0 * math.pi, (3, 3)))
    return Plan(motion=EulerMotion(angles, moves(np.zeros(3), steps, ramp=0.5)), duration=now, phases=phases)


@registered(rate=50.0, sensor="sparkfun6dof")
def warm_up(
    seed: int, duration: float | None, *, start: float = 15.0, end: float = 35.0, time_constant: float = 600.0
) -> Plan:
    """Hyyti & Visala 2015, section 4.4: a cooled sensor lies still for 40 minutes and warms up from `start` to `end`
    °C.

    The `time_constant` (s) is ours.
    """
    temperature = Temperature(start=start, end=end, time_constant=time_constant, noise=0.02, resolution=1.0 / 280.0)
    return Plan(motion=still(), duration=2400.0, temperature=temperature)


@registered(rate=100.0, sensor="mpu9250", remaining=0.05)
def walking(
    seed: int,
    duration: float | None,
    *,
    place: str = "pelvis",
    speed: float = 1.4,
    cadence: float = 1.8,
    heel: float = 8.0,
    radius: float = 4.0,
    iron: float = 0.0,
    floor: float = 0.0,
) -> Plan:
    """A person walks: a periodic gait, the sensor on the pelvis or on a foot (`place`).

    On the pelvis: around a circle of `radius`, with the vertical bounce twice a stride, sway and turns once, and a heel
    strike with a peak of `heel` m/s² at every step. On the foot: straight on, at rest in every stance. `speed` is in
    m/s, `cadence` in steps/s. `iron` (A·m²) is the moment of a magnet on the floor that the way passes, `floor` (µT)
    the field of iron in the floor. Amplitudes are typical of healthy adults. Phases: static (the first 4 s), walking.
    """
    _positive(speed=speed, cadence=cadence, radius=radius)
    _not_negative(heel=heel, iron=iron, floor=floor)
    if place not in ("pelvis", "foot"):
        raise ValueError(f"place: expected 'pelvis' or 'foot', got {place!r}")
    length = 60.0 if duration is None else duration
    rest = min(4.0, 0.2 * length)
    stride = 2.0 / cadence
    walk = max(1.0, math.floor((length - 1.25 * rest) / stride - 0.5)) * stride
    ramp = min(0.5, stride / walk)
    gait = _pelvis(speed, stride, heel, radius) if place == "pelvis" else _foot(speed, stride, heel)
    pace = moves([0.0], [(rest, [0.0]), (walk / (1.0 - ramp), [walk])], ramp=ramp)
    disturbances: list[Disturbance] = []
    if iron > 0.0:
        beside = (radius + 0.5, 0.0, -0.9) if place == "pelvis" else (10.0, 0.5, 0.0)
        disturbances.append(Dipole(position=beside, moment=(0.0, iron, 0.0)))
    if floor > 0.0:
        disturbances.append(IronFloor(deviation=floor, seed=seed))
    return Plan(
        motion=PacedMotion(gait, pace),
        duration=length,
        disturbances=tuple(disturbances),
        phases={"static": ((0.0, rest),), "walking": ((rest, rest + walk / (1.0 - ramp)),)},
    )


def _pelvis(speed: float, stride: float, heel: float, radius: float) -> Motion:
    """A pelvis at a steady pace around a circle, about 1 m above the floor (z = 0 is its own mean height)."""
    turn, gait = speed / radius, 2.0 * math.pi / stride
    # Amplitude, frequency and phase of sines on x, y, z: circle; sway to the side and surge forward, in axes that turn
    # with the heading (a product of two sines is a sum of two); vertical bounce.
    sway, surge, bounce = 0.02, 0.01, 0.025
    quarter = 0.5 * math.pi
    terms = [
        ((radius, radius, 0.0), turn, (0.0, -quarter, 0.0)),
        ((0.5 * sway, 0.5 * sway, 0.0), gait + turn, (quarter, 0.0, 0.0)),
        ((-0.5 * sway, 0.5 * sway, 0.0), gait - turn, (quarter, 0.0, 0.0)),
        ((0.5 * surge, -0.5 * surge, 0.0), 2.0 * gait + turn, (0.0, quarter, 0.0)),
        ((0.5 * surge, 0.5 * surge, 0.0), 2.0 * gait - turn, (0.0, quarter, 0.0)),
        ((0.0, 0.0, bounce), 2.0 * gait, (0.0, 0.0, 0.3)),
    ]
    path = Waves(
        amplitude=np.array([amplitude for amplitude, _, _ in terms]),
        frequency=np.array([[frequency] * 3 for _, frequency, _ in terms]),
        phase=np.array([phase for _, _, phase in terms]),
    )
    width = 0.08
    strikes = bumps(0.1 * stride, width, 0.5 * stride, [0.0, 0.0, heel * width**2 / 32.0])
    angles = Waves(
        amplitude=np.array([[3.0, 0.0, 5.0], [0.5, 2.0, 1.0]]) * DEGREE,
        frequency=np.array([[gait] * 3, [2.0 * gait] * 3]),
        phase=np.array([[0.0, 0.0, 1.0], [0.5, 0.2, 0.0]]),
    )
    heading = Polynomial(np.array([[0.0, 5.0 * DEGREE, 0.0], [0.0, 0.0, turn]]))
    return EulerMotion(Sum((heading, angles)), Sum((path, strikes)))


def _foot(speed: float, stride: float, heel: float) -> Motion:
    """A foot that walks along x: flat on the floor for half of the stride, lifted at the heel, swung, set down."""
    forward = np.array([speed * stride, 0.0, 0.0])
    path = moves(
        np.zeros(3),
        [(0.55 * stride, np.zeros(3)), (0.4 * stride, forward), (0.05 * stride, forward)],
        ramp=0.5,
        periodic=True,
    )
    lift = bumps(0.5 * stride, 0.45 * stride, stride, [0.0, 0.0, 0.12])
    width = 0.05
    strike = bumps(0.0, width, stride, [0.0, 0.0, heel * width**2 / 32.0])
    pitch = [(0.45, 0.0), (0.15, 50.0), (0.25, -20.0), (0.15, 0.0)]
    angles: Piecewise = moves(
        np.zeros(3),
        [(part * stride, np.array([0.0, angle * DEGREE, 0.0])) for part, angle in pitch],
        ramp=0.5,
        periodic=True,
    )
    return EulerMotion(angles, Sum((path, lift, strike)))


def rotors(draw: np.random.Generator, speed: float, acc: float, gyr: float) -> EulerMotion:
    """The vibration of four rotors that turn at about `speed` (rad/s): their first three harmonics.

    Parameters
    ----------
    draw : numpy.random.Generator
        Of the phases.
    speed : float
        Rad/s of the rotors.
    acc, gyr : float
        Root mean squares on each axis, m/s² and rad/s.

    Returns
    -------
    EulerMotion
        To be added by `Compound`.

    Examples
    --------
    >>> import numpy as np
    >>> import ahrs_rs as ar
    >>> ar.simulate.rotors(np.random.default_rng(0), 500.0, 1.0, 0.1).position(np.zeros(2)).shape
    (2, 3)
    """
    harmonics = np.tile([1.0, 2.0, 3.0], 4)[:, None]
    each = np.repeat(speed * (1.0 + draw.uniform(-0.03, 0.03, 4)), 3)[:, None]
    frequency = np.broadcast_to(harmonics * each, (12, 3))
    strength = 1.0 / harmonics * np.ones(3)
    strength = strength * math.sqrt(2.0) / np.linalg.norm(strength, axis=0)
    phase = draw.uniform(0.0, 2.0 * math.pi, (2, 12, 3))
    angles = Waves(gyr * strength / frequency, frequency, phase[0])
    return EulerMotion(angles, Waves(acc * strength / frequency**2, frequency, phase[1]))


def _positive(**params: float) -> None:
    for name, value in params.items():
        check_positive(name, value)


def _not_negative(**params: float) -> None:
    for name, value in params.items():
        if not value >= 0.0:
            raise ValueError(f"{name}: expected a number that is not negative, got {value}")
