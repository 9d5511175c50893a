"""The words by which programs call quantities and times."""

from __future__ import annotations


def _phrases(text: str) -> tuple[tuple[str, ...], ...]:
    """Phrases separated by |, each as its words."""
    return tuple(tuple(phrase.split()) for phrase in text.split("|"))


#: Quantity -> the phrases that stand for it. Longer ones go first where several are in a name.
PHRASES: dict[str, tuple[tuple[str, ...], ...]] = {
    quantity: _phrases(text)
    for quantity, text in {
        "gyr": """
            gyr | gyro | gyros | gyroscope | gyrometer | angular velocity | angular rate | angular speed |
            angvel | ang vel | rotation rate | rot rate | rate of turn | turn rate | rotationrate |
            angularvelocity | angular vel | omega | imugyro | gyroscopes | body rate | gyro rate | rotation | rate
        """,
        "acc": """
            acc | accel | acce | accelerometer | acceleration | specific force | specificforce | accelerometers
            | accelerations | total acceleration | acceleration including gravity | acceleration with gravity |
            accelerometer acceleration | alpha | g force | gforce
        """,
        "linear_acceleration": """
            linear acceleration | linear accel | linear acc | lin acc | linacc | linacce | lin accel | user acceleration
            | user acc | user accel | linearacceleration | linear accelerometer | acceleration without gravity |
            free acceleration | free acc | lia | world linear acceleration | dynamic acceleration
        """,
        "gravity": """
            gravity | grav | gravity vector | grv
        """,
        "mag": """
            mag | magn | magnet | magneto | magnetometer | magnetic field | magnetic | magfield | mag field |
            magneticfield | compass | magnetometers
        """,
        "quat": """
            q | quat | quaternion | orientation | ori | rotation vector | attitude quaternion | quaternions |
            orientation quaternion | rotation quat | orientation quat
        """,
        "pressure": """
            pressure | baro pressure | barometer | press | barometric pressure | air pressure
        """,
        "temperature": """
            temp | temperature | imu temp | degc | deg c | sensor temp | imu degc | imu temperature | gyro temp
            | acc temp
        """,
        "heading": """
            heading | compass heading | magnetic heading
        """,
        "mask": """
            mask | movement | moving
        """,
    }.items()
}

#: Names of a time, without what stands before them and without a unit.
TIMES = frozenset(
    _phrases(
        """
        t | time | times | timestamp | timestamps | time stamp | time stamps | elapsed | elapsed time | time
        elapsed | sample time | stamp | datetime | date time | ts | sample timestamp | sensor timestamp |
        unix time | unix timestamp | epoch | epoch time | unixtime | utc | utc time | time utc | system time
        | sys time | device time | local time | seconds elapsed | elapsed seconds | sec | secs | seconds |
        ms | us | ns | msec | usec | nsec | millis | micros | nanos | milliseconds | microseconds |
        nanoseconds | millisecond | timeus | timems | time boot | boot time | imu time | host time | gps
        time | ros time | timestamp unix | unix | rtc time | rtctime | rtcdate | rtc date | date | tick |
        ticks | clock | recording time | package time | packet time | chip time | chiptime | header stamp |
        logging time | loggingtime | timestamp sensor | sampletimefine | sample time fine | timestamp device
        | time since reboot | motion timestamp since reboot | timestamp since reboot | accelerometer
        timestamp since reboot | gyro timestamp since reboot | record time | log time | time of day |
        timeofday | message time | publish time | server time | time of validity | tow | gps tow | time of week | gps
        time of week | gps timeof week | itow | time itow | gpsitow | elapsedtime | runtime | run time | uptime | up
        time | sampletime | timestamp ms | timestamp us | timestamp ns | since start | time since start | recording
        timestamp | receive time | received | received time | reception time | arrival time | relative time | time
        relative | time delta | abs time
        """
    )
)
