"""Sensors by name, with the numbers of their data sheets.

Where a data sheet gives a limit (bias, scale, misalignment), it is taken for three standard deviations. Data sheets of
this class state no bias instability; 10 °/h and 40 µg are typical of published Allan deviations.
"""

from __future__ import annotations

import math

from ahrs_rs._constants import GRAVITY
from ahrs_rs.simulate._magnetic import DEGREE
from ahrs_rs.simulate._sensor import Clock, Sensor, Temperature, Triad

#: m/s²
MILLI_G = 1e-3 * GRAVITY
#: Bias instability of consumer sensors, rad/s and m/s².
GYR_INSTABILITY = 10.0 * DEGREE / 3600.0
ACC_INSTABILITY = 0.04 * MILLI_G

#: Density of white noise of one step of the ADXL345 rms at 100 Hz, m/s²/√Hz.
ADXL345_STEP = 3.9 * MILLI_G / math.sqrt(50.0)

#: Exact in everything.
IDEAL = Sensor()

#: InvenSense MPU-9250 (PS-MPU-9250A-01 rev. 1.1, tables 1, 2, 3) at ±2000 °/s and ±16 g: 0.01 °/s/√Hz, 300 µg/√Hz,
#: bias up to 5 °/s and 60 mg (80 mg on z), scale 3 %, cross-axis 2 %, 30 °/s over 125 °C, 1.5 mg/°C. Its magnetometer:
#: AK8963, 100 Hz, 0.15 µT a step, ±4800 µT; noise as of ST's LIS2MDL, 3 mG rms; hard iron of a small board, 20 µT.
MPU9250 = Sensor(
    gyr=Triad(
        density=0.01 * DEGREE,
        bias_deviation=5.0 / 3.0 * DEGREE,
        instability=GYR_INSTABILITY,
        scale_deviation=0.01,
        misalignment_deviation=0.02 / 3.0,
        bias_slope=0.24 * DEGREE / 3.0,
        range=2000.0 * DEGREE,
        resolution=2000.0 * DEGREE / 32768.0,
    ),
    acc=Triad(
        density=0.3 * MILLI_G,
        bias_deviation=(20.0 * MILLI_G, 20.0 * MILLI_G, 80.0 / 3.0 * MILLI_G),
        instability=ACC_INSTABILITY,
        scale_deviation=0.01,
        misalignment_deviation=0.02 / 3.0,
        bias_slope=0.5 * MILLI_G,
        range=16.0 * GRAVITY,
        resolution=16.0 * GRAVITY / 32768.0,
    ),
    mag=Triad(
        noise=0.3,
        bias_deviation=20.0,
        scale_deviation=0.05,
        misalignment_deviation=0.02,
        range=4800.0,
        resolution=0.15,
        rate=100.0,
    ),
)

#: InvenSense MPU-6050 (PS-MPU-6000A-00 rev. 3.4, tables 6.1 and 6.2), as Parikh et al. (±500 °/s, ±8 g) and Çoçoli &
#: Badia used it: 0.005 °/s/√Hz, 400 µg/√Hz, bias up to 20 °/s and 50 mg (80 mg on z), scale 3 %, cross-axis 2 %. No
#: magnetometer.
MPU6050 = Sensor(
    gyr=Triad(
        density=0.005 * DEGREE,
        bias_deviation=20.0 / 3.0 * DEGREE,
        instability=GYR_INSTABILITY,
        scale_deviation=0.01,
        misalignment_deviation=0.02 / 3.0,
        range=500.0 * DEGREE,
        resolution=500.0 * DEGREE / 32768.0,
    ),
    acc=Triad(
        density=0.4 * MILLI_G,
        bias_deviation=(50.0 / 3.0 * MILLI_G, 50.0 / 3.0 * MILLI_G, 80.0 / 3.0 * MILLI_G),
        instability=ACC_INSTABILITY,
        scale_deviation=0.01,
        misalignment_deviation=0.02 / 3.0,
        range=8.0 * GRAVITY,
        resolution=8.0 * GRAVITY / 32768.0,
    ),
    mag=None,
)

#: The STM32F3Discovery of Cirillo et al. (ST L3GD20 and LSM303DLHC at ±2000 °/s, ±2 g, ±1.3 gauss; magnetometer at 220
#: Hz). Noise: the variances of their matrix V, measured at 500 Hz, times g² and (50 µT)², whatever the rate is; they
#: are in keeping with the data sheets' 0.03 °/s/√Hz and 220 µg/√Hz. Steps: 70 m°/s, 1 mg, 1/1100 gauss. Accelerometer
#: and magnetometer scatter in norm by 5.2 % and 17.9 % before calibration: a bias of 9 and 31 % in a random direction.
#: Of the gyroscope's bias nothing is said; 0.1 °/s is what subtracting a mean at rest leaves.
STM32F3DISCOVERY = Sensor(
    gyr=Triad(
        noise=(math.sqrt(2.9e-5), math.sqrt(2.3e-5), math.sqrt(3.2e-5)),
        bias_deviation=0.1 * DEGREE,
        instability=GYR_INSTABILITY,
        range=2000.0 * DEGREE,
        resolution=0.07 * DEGREE,
    ),
    acc=Triad(
        noise=(math.sqrt(3.1e-5) * GRAVITY, math.sqrt(4.5e-5) * GRAVITY, math.sqrt(5.5e-5) * GRAVITY),
        bias_deviation=0.052 * GRAVITY,
        instability=ACC_INSTABILITY,
        range=2.0 * GRAVITY,
        resolution=MILLI_G,
    ),
    mag=Triad(
        noise=(math.sqrt(2.0e-3) * 50.0, math.sqrt(2.1e-3) * 50.0, math.sqrt(2.0e-3) * 50.0),
        bias_deviation=0.179 * 50.0,
        range=130.0,
        resolution=100.0 / 1100.0,
        rate=220.0,
    ),
)

#: SparkFun 6DOF Digital of Hyyti & Visala: Analog Devices ADXL345 (3.9 mg a step; 0.75, 0.75 and 1.1 steps rms at 100
#: Hz) and InvenSense ITG-3200 (0.03 °/s/√Hz, 14.375 steps a °/s, ±2000 °/s). Gain and bias as functions of temperature:
#: their eqs 16-17 with Table 4, whose model is linear in the temperature in °C; the gyroscope's biases there are in
#: °/s.
SPARKFUN_6DOF = Sensor(
    gyr=Triad(
        density=0.03 * DEGREE,
        instability=GYR_INSTABILITY,
        matrix=((0.99130982, 0.0, 0.0), (0.0, 1.03580126, 0.0), (0.0, 0.0, 1.08040715)),
        gain_slope=(0.00027886, -0.00122424, -0.00246201),
        bias=(0.24566657 * DEGREE, 0.19236960 * DEGREE, -0.21682853 * DEGREE),
        bias_slope=(-0.01188330 * DEGREE, -0.00845710 * DEGREE, 0.00542382 * DEGREE),
        reference_temperature=0.0,
        range=2000.0 * DEGREE,
        resolution=DEGREE / 14.375,
    ),
    acc=Triad(
        density=(0.75 * ADXL345_STEP, 0.75 * ADXL345_STEP, 1.1 * ADXL345_STEP),
        instability=ACC_INSTABILITY,
        matrix=((1.06731340, 0.0, 0.0), (0.0, 1.03869310, 0.0), (0.0, 0.0, 0.98073082)),
        gain_slope=(-0.00049316, 0.00040477, 0.00102091),
        bias=(0.99740194, 0.05868846, 0.48880423),
        bias_slope=(-0.01551443, -0.00457992, -0.01929765),
        reference_temperature=0.0,
        range=16.0 * GRAVITY,
        resolution=3.9 * MILLI_G,
    ),
    mag=None,
    temperature=Temperature(start=25.0, end=25.0, resolution=1.0 / 280.0),
)

#: MicroStrain Inertia-Link of Hyyti & Visala (±300 °/s, ±5 g, 16 bits). The paper gives no noise, but says that it is
#: less noisy than the SparkFun: half of that is taken, and for biases the 0.2 °/s and 5 mg of its maker's stability.
INERTIA_LINK = Sensor(
    gyr=Triad(
        density=0.015 * DEGREE,
        bias_deviation=0.2 * DEGREE,
        instability=GYR_INSTABILITY,
        range=300.0 * DEGREE,
        resolution=300.0 * DEGREE / 32768.0,
    ),
    acc=Triad(
        density=0.5 * 0.75 * ADXL345_STEP,
        bias_deviation=5.0 * MILLI_G,
        instability=ACC_INSTABILITY,
        range=5.0 * GRAVITY,
        resolution=5.0 * GRAVITY / 32768.0,
    ),
    mag=None,
)

#: Everything at once, to try what a filter stands: jitter, lost rows, missing rows, a late and slow magnetometer,
#: warming up.
ROUGH = Sensor(
    gyr=Triad(
        density=0.03 * DEGREE,
        bias_deviation=1.0 * DEGREE,
        instability=3.0 * GYR_INSTABILITY,
        random_walk=1e-5,
        scale_deviation=0.01,
        misalignment_deviation=0.01,
        bias_slope=0.02 * DEGREE,
        gain_slope=1e-4,
        range=1000.0 * DEGREE,
        resolution=1000.0 * DEGREE / 32768.0,
        dropout=0.002,
        dropout_length=2.0,
    ),
    acc=Triad(
        density=0.5 * MILLI_G,
        bias_deviation=20.0 * MILLI_G,
        instability=ACC_INSTABILITY,
        random_walk=1e-5,
        scale_deviation=0.01,
        misalignment_deviation=0.01,
        bias_slope=0.5 * MILLI_G,
        gain_slope=1e-4,
        range=8.0 * GRAVITY,
        resolution=8.0 * GRAVITY / 32768.0,
        dropout=0.01,
        dropout_length=3.0,
    ),
    mag=Triad(
        noise=0.5,
        bias_deviation=5.0,
        instability=0.1,
        random_walk=0.01,
        scale_deviation=0.03,
        misalignment_deviation=0.02,
        range=1000.0,
        resolution=0.15,
        rate=50.0,
        dropout=0.05,
        dropout_length=5.0,
    ),
    g_sensitivity=0.02 * DEGREE / GRAVITY,
    mag_delay=0.01,
    temperature=Temperature(start=20.0, end=40.0, time_constant=600.0, noise=0.05, resolution=0.01),
    clock=Clock(jitter=0.05, lost=0.002, lost_length=3.0),
)

#: Name -> sensor, for the command line and `scenario`.
SENSORS: dict[str, Sensor] = {
    "ideal": IDEAL,
    "mpu9250": MPU9250,
    "mpu6050": MPU6050,
    "stm32f3discovery": STM32F3DISCOVERY,
    "sparkfun6dof": SPARKFUN_6DOF,
    "inertialink": INERTIA_LINK,
    "rough": ROUGH,
}
