"""Headers of the tables of programs that are public, where each was seen, and what stands in each column.

A column is described by its quantity and axes and, after a slash, its unit: "g/dps" are three columns x, y, z of a
gyroscope in deg/s, "azyx/g" three of an accelerometer in g and in that order. The quantities are t (time; "t1970"
counts from 1970), g, a, m, q (w, x, y, z of the device's own orientation), r (of a truth), l (linear acceleration), v
(gravity); "n" counts rows, "0" is a column of zeros, "iso" a date with time, "text" a word. They are the test's own
words: none of them is the reader's.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Style:
    """One style of header.

    Parameters
    ----------
    program, version, source : who writes it, and where that is to be seen.
    header : the lines up to the first row of numbers, with that program's separator.
    columns : what stands in them.
    options : what has to be said to `ahrs_rs.read`, as the header does not tell it.
    error : how the refusal begins, of a table that is refused rightly.
    separator, decimal : of the numbers.
    rate : of the rows, where there is no time.
    name : of the file, where it tells the sensor.
    """

    program: str
    version: str
    source: str
    header: str
    columns: str
    options: dict[str, Any] = field(default_factory=dict)
    error: str = ""
    separator: str = ","
    decimal: str = "."
    name: str = "table.csv"


PACKAGE = "its code, as published on PyPI"
DPS = {"units": {"gyr": "deg/s"}}
DPS_G = {"units": {"gyr": "deg/s", "acc": "g"}}
#: OpenIMU's logger writes "name (unit)" of what a JSON file of the device lists.
OPENIMU = ("openimu", "2.6.1")
OPENIMU_SOURCE = "file_storage.py and aceinna/setting/"

STYLES = [
    Style(
        "bagpy (ROS 1 bag to CSV)",
        "0.5",
        PACKAGE,
        "Time,header.seq,header.stamp.secs,header.stamp.nsecs,header.frame_id,orientation.x,orientation.y,orientation.z,"
        "orientation.w,orientation_covariance_0,angular_velocity.x,angular_velocity.y,angular_velocity.z,"
        "angular_velocity_covariance_0,linear_acceleration.x,linear_acceleration.y,linear_acceleration.z,"
        "linear_acceleration_covariance_0",
        "t1970+0.3 n t/whole t/nanos text qxyzw 0 g 0 a 0",
    ),
    Style(
        "RIDI data set's gen_dataset.py",
        "57e66c53",
        "github.com/higerra/ridi_imu, python/gen_dataset.py",
        "time,gyro_x,gyro_y,gyro_z,acce_x,acce_y,acce_z,linacce_x,linacce_y,linacce_z,grav_x,grav_y,grav_z,magnet_x,"
        "magnet_y,magnet_z,pos_x,pos_y,pos_z,ori_w,ori_x,ori_y,ori_z,rv_w,rv_x,rv_y,rv_z",
        "t1970/ns g a l v m 0 0 0 q q",
        options={"units": {"t": "ns"}},
    ),
    Style(
        "mobile-ar-sensor-logger",
        "66424cb1",
        "github.com/OSUPCVLab/mobile-ar-sensor-logger, IMUManager.java",
        "Timestamp[nanosec], gx[rad/s], gy[rad/s], gz[rad/s], ax[m/s^2], ay[m/s^2], az[m/s^2]",
        "t/ns g a",
    ),
    Style(
        "mobile-ar-sensor-logger, with a magnetometer",
        "66424cb1",
        "github.com/OSUPCVLab/mobile-ar-sensor-logger, IMUManager.java",
        "Timestamp[nanosec], gx[rad/s], gy[rad/s], gz[rad/s], ax[m/s^2], ay[m/s^2], az[m/s^2], mx[uT], my[uT], mz[uT]",
        "t/ns g a m",
    ),
    Style(
        "MotionSense data set",
        "06668d1e",
        "github.com/mmalekzadeh/motion-sense, README",
        ",attitude.roll,attitude.pitch,attitude.yaw,gravity.x,gravity.y,gravity.z,rotationRate.x,rotationRate.y,"
        "rotationRate.z,userAcceleration.x,userAcceleration.y,userAcceleration.z",
        "n 0 0 0 v/g g l/g",
        options={"rate": 100.0, "units": {"linear_acceleration": "g", "gravity": "g"}},
    ),
    Style(
        "PicoQuake",
        "1.0.0",
        "github.com/PLab-SI/PicoQuake at 180b6fb0, docs/acquisition_data.md",
        "# PLab PicoQuake Data\n# Time: 2024-04-21 15:54:46.333682, Device: C6E3 (E66368254F89A225), FW: 1.0.0\n"
        "# Num. samples: 240, Duration: 2.4 s\n"
        "# Config: data_rate = 100.0 Hz, filter = 42 Hz, acc_range = 4 g, gyro_range = 250.0 dps\n"
        "# Integrity: True, Skipped samples: 0\ncount,a_x,a_y,a_z,g_x,g_y,g_z",
        "n a/g g/dps",
        options=DPS_G,
    ),
    Style(
        "SensorLogger (Android, AhmedHamedTN)",
        "6bab4df2",
        "github.com/AhmedHamedTN/SensorLogger, readme.md",
        "#walk\ntime[ms]; x-axis[m/s^2]; y-axis[m/s^2]; z-axis[m/s^2]",
        "t/ms a",
        separator=";",
    ),
    Style(
        "OpenLog Artemis",
        "0b2feb16",
        "github.com/sparkfun/OpenLog_Artemis, SENSOR_UNITS.md",
        "rtcDate,rtcTime,aX,aY,aZ,gX,gY,gZ,mX,mY,mZ,imu_degC,output_Hz",
        "day clock a/mg g/dps m 0 hz",
    ),
    Style(
        "x-BIMU Logger",
        "b2d5ab98",
        "github.com/xioTechnologies/x-BIMU-Logger, CsvFileWriter.cs",
        "time (ms),gyroscope x (0.1 deg/s),gyroscope y (0.1 deg/s),gyroscope z (0.1 deg/s),accelerometer x (mg),"
        "accelerometer y (mg),accelerometer z (mg),magnetometer x (mG),magnetometer y (mG),magnetometer z (mG),"
        "packet counter",
        "t/ms g/tenth_dps a/mg m/mG n",
    ),
    Style(
        "imu-logger",
        "4d2f576d",
        "github.com/jason-w-cramer/imu-logger, imu_logger.py",
        "timestamp,Ax,Ay,Az,Gx,Gy,Gz",
        "iso a/g g/dps",
        options=DPS_G,
    ),
    Style(
        "witmotion-online-converter",
        "bbf8ab04",
        "github.com/auenkind/witmotion-online-converter",
        "l,t,x,y,z",
        "n t a/g",
        options={"columns": {"acc": ["x", "y", "z"], "t": "t"}, "units": {"acc": "g", "t": "s"}},
    ),
    Style(
        "rosbag-resurrector",
        "0.8.7",
        "resurrector, ingest/parser.py, as published on PyPI",
        "timestamp_ns,header.stamp_sec,header.stamp_nsec,header.frame_id,orientation.x,orientation.y,orientation.z,"
        "orientation.w,angular_velocity.x,angular_velocity.y,angular_velocity.z,linear_acceleration.x,"
        "linear_acceleration.y,linear_acceleration.z",
        "t1970+0.3/ns t/whole t/nanos text qxyzw g a",
    ),
    Style(
        "kalibr_bagcreater",
        "",
        "github.com/ethz-asl/kalibr, wiki, Bag format",
        "timestamp,omega_x,omega_y,omega_z,alpha_x,alpha_y,alpha_z",
        "t1970/ns g a",
        options={"units": {"t": "ns"}},
    ),
    Style(
        "Boreas data set, raw IMU (evalio)",
        "0.6.1",
        "evalio, datasets/boreas.py, as published on PyPI",
        "GPSTime,angvel_z,angvel_y,angvel_x,accelz,accely,accelx",
        "t1970 gzyx azyx",
    ),
    Style(
        "mti8-navigation",
        "1.0.0",
        "mti8_navigation, logger/csv_logger.py, as published on PyPI",
        "SystemTime,UTC,Packet,SampleTime,Roll,Pitch,Yaw,Qw,Qx,Qy,Qz,AccX,AccY,AccZ,FreeAccX,FreeAccY,FreeAccZ,"
        "DeltaVX,DeltaVY,DeltaVZ,GyroX,GyroY,GyroZ,DeltaQ0,DeltaQ1,DeltaQ2,DeltaQ3,MagX,MagY,MagZ,Pressure,Temperature",
        "t1970 text n n 0 0 0 q a l 0 0 0 g 0 0 0 0 m 0 0",
        options={"columns": {"t": "SystemTime"}},
    ),
    Style(
        "polar-ble-sdk",
        "1.0.0",
        "polar_ble_sdk, cli.py, as published on PyPI",
        "Timestamp,HeartRate_BPM,HRV_RMSSD_ms,Battery_Percent,ACC_X,ACC_Y,ACC_Z,GYRO_X,GYRO_Y,GYRO_Z,MAG_X,MAG_Y,MAG_Z,"
        "Marker",
        "iso 0 0 0 a/mg g/dps m/mG text",
        options={"units": {"acc": "mg", "gyr": "deg/s", "mag": "mG"}},
    ),
    Style(
        "open-wearables (OpenEarable)",
        "0.2.1",
        "open_wearables, data/constants.py, as published on PyPI",
        "timestamp,acc.x,acc.y,acc.z,gyro.x,gyro.y,gyro.z,mag.x,mag.y,mag.z,barometer.temperature,barometer.pressure,"
        "bone_acc.x,bone_acc.y,bone_acc.z",
        "t a g/dps m 0 0 0 0 0",
        options={**DPS, "sensor": "imu"},
    ),
    Style(
        "nilspodlib",
        "4.1.2",
        "nilspodlib, consts.py, as published on PyPI",
        "n_samples,acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z",
        "n a g/dps",
        options={**DPS, "rate": 100.0},
    ),
    Style(
        "imucal",
        "2.6.0",
        "imucal's README, as published on PyPI",
        "acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z",
        "a g/dps",
        options={**DPS, "rate": 100.0},
    ),
    Style(
        "pyins",
        "1.0.1",
        "pyins, util.py, as published on PyPI as python-ins",
        "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z",
        "t g a",
    ),
    Style(
        "signialib",
        "2.11.0",
        "signialib, consts.py, as published on PyPI",
        "x,y,z,hiGyrX,hiGyrY,hiGyrZ",
        "a g/dps",
        options={"rate": 100.0, "columns": {"acc": ["x", "y", "z"]}, "units": {"gyr": "deg/s"}},
    ),
    Style(
        "imuops",
        "0.4.1",
        "imuops, columns.py, as published on PyPI",
        "t_ms,ax,ay,az,gx,gy,gz,mx,my,mz,temp_c,pressure_pa,activity_label",
        "t/ms a g m 0 0 text",
    ),
    Style(
        "nimutool",
        "0.1.12",
        "nimutool, data/reader.py, as published on PyPI",
        "timestamp;window_us;bgx0;bgy0;bgz0;bax0;bay0;baz0",
        "t1970 n g a",
        options={"columns": {"gyr": ["bgx0", "bgy0", "bgz0"], "acc": ["bax0", "bay0", "baz0"]}},
        separator=";",
    ),
    Style(
        "Muse LSL",
        "2.5.3",
        "muselsl, record.py, as published on PyPI",
        "timestamps,X,Y,Z",
        "t1970 g/dps",
        options={"columns": {"gyr": ["X", "Y", "Z"]}, "units": {"gyr": "deg/s"}},
    ),
    Style(
        "Pupil Labs Neon export",
        "2.1.6",
        "Neon's export format, as pupil-labs-neon-recording reads it",
        "recording id,timestamp [ns],gyro x [deg/s],gyro y [deg/s],gyro z [deg/s],acceleration x [g],"
        "acceleration y [g],acceleration z [g],roll [deg],pitch [deg],yaw [deg],quaternion w,quaternion x,"
        "quaternion y,quaternion z",
        "text t1970/ns g/dps a/g 0 0 0 q",
    ),
    Style(
        "blackbox_decode, orangebox",
        "0.5.0",
        "orangebox, as published on PyPI",
        "loopIteration,time (us),gyroADC[0] (deg/s),gyroADC[1] (deg/s),gyroADC[2] (deg/s),accSmooth[0] (g),"
        "accSmooth[1] (g),accSmooth[2] (g)",
        "n t/us g/dps a/g",
    ),
    Style(
        "gopro-telemetry",
        "1.2.11",
        "its README: CSV by stream, of GPMF",
        '"cts","date","Gyroscope (z) [rad/s]","Gyroscope (x) [rad/s]","Gyroscope (y) [rad/s]"',
        "t/ms iso gzxy",
        options={"columns": {"t": "cts"}, "units": {"t": "ms"}},
    ),
    Style(
        "DJI DatCon",
        "as telemetry-parser 0.3.0 reads it",
        "telemetry-parser, as published on PyPI",
        "Clock:Tick#,Clock:offsetTime,IMU_ATTI(0):accelX,IMU_ATTI(0):accelY,IMU_ATTI(0):accelZ,IMU_ATTI(0):gyroX,"
        "IMU_ATTI(0):gyroY,IMU_ATTI(0):gyroZ",
        "n t a/g g/dps",
        options={"columns": {"t": "Clock:offsetTime"}, "units": {"t": "s", "gyr": "deg/s", "acc": "g"}},
    ),
    Style(
        "ulog2csv, sensor_combined",
        "pyulog 1.3.0",
        "run on a flight log of PX4",
        "timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative,"
        "accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2],accelerometer_integral_dt,"
        "accelerometer_clipping,accel_calibration_count,gyro_calibration_count",
        "t/us g n 0 a n 0 0 0",
    ),
    Style(
        "mavlogdump --format csv, IMU",
        "pymavlink 2.4.50",
        "run on a log of ArduPilot",
        "timestamp,TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz",
        "t1970 t/us 0 g a 0 0 0 0 0 0 0",
    ),
    Style(
        "ArduPilot, messages before instances",
        "pymavlink 2.4.50",
        "its tests/test.BIN as a data frame",
        "mavpackettype,TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz",
        "text t/us g a 0 0 0 0 0 0 0",
    ),
    Style(
        "EuRoC MAV data set",
        "2016",
        "its imu0/data.csv",
        "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],"
        "a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]",
        "t1970/ns g a",
    ),
    Style(
        "Movella DOT app",
        "2021.0",
        "an export of it",
        "sep=,\nDeviceTag:,Sensor\nFirmwareVersion:,2.0.0\nAppVersion:,2021.0\nSyncStatus:,Synced\nOutputRate:,60Hz\n"
        "FilterProfile:,General\nMeasurement Mode:,Custom Mode 5\nStartTime: ,2026-01-01_10:00:00_000 GMT+0\n\n"
        "PacketCounter,SampleTimeFine,Quat_W,Quat_X,Quat_Y,Quat_Z,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z",
        "n t/us q a g/dps",
    ),
    Style(
        "Xsens MT Manager",
        "2022.2.0",
        "an export of it",
        "// General information: \n//  MT Manager version: 2022.2.0 \n// Coordinate system: ENU\n"
        "PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tMag_Y\tMag_Z",
        "n t/ticks a g m/unit",
        separator="\t",
        name="table.txt",
    ),
    Style(
        "ConsensysPRO (Shimmer)",
        "",
        "an export of it",
        '"sep=\\t"\nShimmer_0000_Timestamp_Unix_CAL\tShimmer_0000_Accel_WR_X_CAL\tShimmer_0000_Accel_WR_Y_CAL\t'
        "Shimmer_0000_Accel_WR_Z_CAL\tShimmer_0000_Gyro_X_CAL\tShimmer_0000_Gyro_Y_CAL\tShimmer_0000_Gyro_Z_CAL\n"
        "ms\tm/(s^2)\tm/(s^2)\tm/(s^2)\tdeg/s\tdeg/s\tdeg/s",
        "t1970/ms a g/dps",
        separator="\t",
    ),
    Style(
        "Sensor Logger, Gyroscope.csv",
        "014c8fe1",
        "github.com/tszheichoi/awesome-sensor-logger, README",
        "time,seconds_elapsed,z,y,x",
        "t1970/ns t gzyx",
        name="Gyroscope.csv",
    ),
    Style(
        "Sensor Logger, TotalAcceleration.csv",
        "014c8fe1",
        "github.com/tszheichoi/awesome-sensor-logger, README",
        "time,seconds_elapsed,y,z,x",
        "t1970/ns t ayzx",
        name="TotalAcceleration.csv",
    ),
    Style(
        "phyphox, decimal comma",
        "",
        "an export of it",
        '"Time (s)";"Gyroscope x (rad/s)";"Gyroscope y (rad/s)";"Gyroscope z (rad/s)"',
        "t g",
        separator=";",
        decimal=",",
    ),
    Style(
        "phyphox, acceleration with gravity",
        "",
        "an export of it",
        '"Time (s)","Acceleration x (m/s^2)","Acceleration y (m/s^2)","Acceleration z (m/s^2)",'
        '"Absolute acceleration (m/s^2)"',
        "t a 0",
    ),
    Style(
        "x-IMU3",
        "1.9.1",
        "ximu3's converter",
        "Timestamp (us),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),"
        "Accelerometer Y (g),Accelerometer Z (g)",
        "t/us g/dps a/g",
    ),
    Style(
        "Fusion's example",
        "",
        "github.com/xioTechnologies/Fusion, sensor_data.csv",
        "Time (s),Gyroscope X (deg/s),Gyroscope Y (deg/s),Gyroscope Z (deg/s),Accelerometer X (g),Accelerometer Y (g),"
        "Accelerometer Z (g),Magnetometer X (uT),Magnetometer Y (uT),Magnetometer Z (uT)",
        "t g/dps a/g m",
    ),
    Style(
        "RepoIMU data set",
        "2016",
        "its TStick files, with a name for each column",
        "Time;Orientation W;Orientation X;Orientation Y;Orientation Z;Accel X;Accel Y;Accel Z;Gyro X;Gyro Y;Gyro Z;"
        "Magnetometer X;Magnetometer Y;Magnetometer Z",
        "t r a g m",
        options={"columns": {"ref": ["Orientation W", "Orientation X", "Orientation Y", "Orientation Z"]}},
        separator=";",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}INS2000, packet s1",
        "GPS_Week,GPS_TimeOfWeek (ms),x_accel (m/s^2),y_accel (m/s^2),z_accel (m/s^2),x_gyro (deg/s),y_gyro (deg/s),"
        "z_gyro (deg/s)",
        "0 t/ms a g/dps",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}INS401, packet s1",
        "GPS_Week,GPS_TimeofWeek (sec),x_accel (m/s^2),y_accel (m/s^2),z_accel (m/s^2),x_rate (deg/s),y_rate (deg/s),"
        "z_rate (deg/s)",
        "0 t a g/dps",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}OpenIMU300RI, Compass, packet s1",
        "timeCntr (msec),time (s),xAccel (m/s^2),yAccel (m/s^2),zAccel (m/s^2),xRate (deg/s),yRate (deg/s),"
        "zRate (deg/s),xMag (Gauss),yMag (Gauss),zMag (Gauss),temp (degC)",
        "t/ms t a g/dps m/gauss 0",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}OpenIMU300RI, IMU, packet z1",
        "time (usec),xAccel (m/s^2),yAccel (m/s^2),zAccel (m/s^2),xRate (deg/s),yRate (deg/s),zRate (deg/s),"
        "xMag (Gauss),yMag (Gauss),zMag (Gauss)",
        "t/us a g/dps m/gauss",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}OpenIMU300RI, INS, packet e2",
        "timeCntr (msec),time (s),roll (deg),pitch (deg),heading (deg),xAccel (g),yAccel (g),zAccel (g),"
        "xAccelBias (m/s^2),yAccelBias (m/s^2),zAccelBias (m/s^2),xRate (deg/s),yRate (deg/s),zRate (deg/s),"
        "xRateBias (deg/s),yRateBias (deg/s),zRateBias (deg/s),velNorth (m/s),velEast (m/s),velDown (m/s),xMag (Gauss),"
        "yMag (Gauss),zMag (Gauss),lat (deg),lon (deg),alt (m),opMode (unitless),linAccSw (unitless),turnSw (unitless)",
        "t/ms t 0 0 0 a/g 0 0 0 g/dps 0 0 0 0 0 0 m/gauss 0 0 0 0 0 0",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}OpenIMU300RI, VG_AHRS, packet a2: one axis of the rate in another unit",
        "timeITOW (msec),time (s),roll (deg),pitch (deg),heading (deg),xRate (rad/s),yRate (deg/s),zRate (deg/s),"
        "xAccel (m/s^2),yAccel (m/s^2),zAccel (m/s^2)",
        "t/ms t 0 0 0 g/dps a",
        error="gyr: expected one unit for all axes",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}OpenRTK330L, packet e1",
        "timeCntr (msec),time (s),roll (rad),pitch (rad),heading (rad),xAccel (g),yAccel (g),zAccel (g),xRate (deg/s),"
        "yRate (deg/s),zRate (deg/s),xRateBias (deg/s),yRateBias (deg/s),zRateBias (deg/s),xMag (G),yMag (G),zMag (G),"
        "opMode (unitless),linAccSw (unitless),turnSw (unitless)",
        "t/ms t 0 0 0 a/g g/dps 0 0 0 m/gauss 0 0 0",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}OpenRTK330L, log-parser, packet s1",
        "GPS_Week,GPS_TimeOfWeek (s),x_accel (m/s^2),y_accel (m/s^2),z_accel (m/s^2),x_gyro (deg/s),y_gyro (deg/s),"
        "z_gyro (deg/s)",
        "0 t a g/dps",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}dmu, packet A1",
        "rollAngle (deg),pitchAngle (deg),yawAngleMag (deg),xRateCorrected (deg/s),yRateCorrected (deg/s),"
        "zRateCorrected (deg/s),xAccel (m/s^2),yAccel (m/s^2),zAccel (m/s^2),xMag (Gauss),yMag (Gauss),zMag (Gauss),"
        "xRateTemp (deg),timeITOW (ms),BITstatus",
        "0 0 0 g/dps a m/gauss 0 t/ms 0",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}dmu, packet S0",
        "xAccel (m/s^2),yAccel (m/s^2),zAccel (m/s^2),xRate (deg/s),yRate (deg/s),zRate (deg/s),xMag (Gauss),"
        "yMag (Gauss),zMag (Gauss),xRateTemp (deg),yRateTemp (deg),zRateTemp (deg),boardTemp (deg),GPSITOW (msec),"
        "BITstatus",
        "a g/dps m/gauss 0 0 0 0 t/ms 0",
    ),
    Style(
        "AirbrakesV2 (MicroStrain 3DM-CX5)",
        "98c446c2",
        "github.com/NCSU-High-Powered-Rocketry-Club/AirbrakesV2, tests/imu_data",
        "state,extension,timestamp,invalid_fields,scaledAccelX,scaledAccelY,scaledAccelZ,scaledGyroX,scaledGyroY,"
        "scaledGyroZ,deltaVelX,deltaVelY,deltaVelZ,deltaThetaX,deltaThetaY,deltaThetaZ,estOrientQuaternionW,"
        "estOrientQuaternionX,estOrientQuaternionY,estOrientQuaternionZ,estLinearAccelX,estLinearAccelY,estLinearAccelZ",
        "text 0 t1970/ns text a/g g 0 0 0 0 0 0 q l",
        options={"units": {"t": "ns", "acc": "g"}},
    ),
    Style(
        "raspi-python, LIS3DH",
        "b3fde511",
        "github.com/HSSBoston/raspi-python, accel-read-file.py",
        "utime (s),X (G),Y (G),Z (G)",
        "t1970 a/g",
        options={"columns": {"t": "utime (s)", "acc": ["X (G)", "Y (G)", "Z (G)"]}},
    ),
    Style(
        "navigation, arduino.py",
        "237a74f8",
        "github.com/NorNikita/navigation, arduino.py",
        "Packet number,a_x,a_y,a_z,w_x,w_y,w_z",
        "n a g",
        options={"rate": 100.0},
    ),
    Style(
        "MPU6050_KalmanFilter",
        "dffb2b68",
        "github.com/ispaik06/MPU6050_KalmanFilter, MPU6050_rawData.ino",
        "CLEARDATA\nAcX,AcY,AcZ,GyX,GyY,GyZ",
        "a g",
        options={"rate": 100.0},
    ),
    Style(
        "macimu",
        "0.2.0",
        "macimu, __init__.py, as published on PyPI: a row for each sample of either sensor",
        "t,sensor,x,y,z",
        "t text a/g",
        options={"columns": {"acc": ["x", "y", "z"]}, "units": {"acc": "g"}},
    ),
    Style(
        "MAVLink SCALED_IMU, mavlogdump of a telemetry log",
        "pymavlink 2.4.50",
        "the common message set",
        "timestamp,mavpackettype,time_boot_ms,xacc,yacc,zacc,xgyro,ygyro,zgyro,xmag,ymag,zmag,temperature",
        "t1970 text t/ms a/mg g/mrad m/mG 0",
    ),
    Style(
        "MAVLink HIGHRES_IMU, mavlogdump of a telemetry log",
        "pymavlink 2.4.50",
        "the common message set",
        "timestamp,mavpackettype,time_usec,xacc,yacc,zacc,xgyro,ygyro,zgyro,xmag,ymag,zmag,abs_pressure,diff_pressure,"
        "pressure_alt,temperature,fields_updated,id",
        "t1970 text t/us a g m/gauss 0 0 0 0 0 0",
    ),
    Style(
        "rostopic echo -p, sensor_msgs/Imu",
        "ROS Noetic",
        "wiki.ros.org/rostopic",
        "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.orientation.x,field.orientation.y,"
        "field.orientation.z,field.orientation.w,field.orientation_covariance0,field.angular_velocity.x,"
        "field.angular_velocity.y,field.angular_velocity.z,field.angular_velocity_covariance0,"
        "field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z,"
        "field.linear_acceleration_covariance0",
        "t1970+0.3/ns n t1970/ns text qxyzw 0 g 0 a 0",
    ),
    Style(
        "gyroflow gcsv",
        "1.3",
        "docs.gyroflow.xyz, .gcsv gyro log format",
        "GYROFLOW IMU LOG\nversion,1.3\nid,logger\norientation,XYZ\ntscale,0.001\n"
        "gscale,0.01745329251994\nascale,0.001\nt,gx,gy,gz,ax,ay,az",
        "t/ms g/dps a/mg",
        name="table.gcsv",
    ),
    Style(
        "imu-python",
        "0.1.2",
        "imu_python, definitions.py, as published on PyPI",
        "timestamp (sec),accel_x (m/s^2),accel_y (m/s^2),accel_z (m/s^2),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),"
        "mag_x (normalized),mag_y (normalized),mag_z (normalized),pose_w,pose_x,pose_y,pose_z",
        "t1970 a g m/unit q",
    ),
    Style(
        "cwa-reader-rs, write_cwa_csv",
        "0.5.0",
        "run on a file of an AX6",
        "time,acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z",
        "t1970 a/g g/dps",
        options=DPS_G,
    ),
    Style(
        "Faros",
        "as jointly 0.2.0 reads it",
        "jointly's README, as published on PyPI",
        "timestamp,Accelerometer_X,Accelerometer_Y,Accelerometer_Z",
        "iso a/mg",
        options={"units": {"acc": "mg"}},
    ),
    Style(
        "Everion",
        "as jointly 0.2.0 reads it",
        "jointly's README, as published on PyPI",
        "timestamp,accx_data,accy_data,accz_data",
        "iso a/g",
        options={"units": {"acc": "g"}},
    ),
    Style(
        "AEGIS data set, gyroscopes.csv",
        "as telemachus 0.9.0 reads it",
        "telemachus, adapters/aegis.py",
        "trip_id,timestamp,x_value,y_value,z_value",
        "0 iso g/dps",
        options={"columns": {"gyr": ["x_value", "y_value", "z_value"]}, "units": {"gyr": "deg/s"}},
        name="gyroscopes.csv",
    ),
    Style(
        "PVS data set",
        "as telemachus 0.9.0 reads it",
        "telemachus, adapters/pvs.py",
        "timestamp,acc_x_dashboard,acc_y_dashboard,acc_z_dashboard,acc_x_above_suspension,acc_y_above_suspension,"
        "acc_z_above_suspension,gyro_x_dashboard,gyro_y_dashboard,gyro_z_dashboard,gyro_x_above_suspension,"
        "gyro_y_above_suspension,gyro_z_above_suspension,mag_x_dashboard,mag_y_dashboard,mag_z_dashboard,"
        "mag_x_above_suspension,mag_y_above_suspension,mag_z_above_suspension,temp_dashboard,timestamp_gps,latitude",
        "t1970 a 0 0 0 g/dps 0 0 0 m 0 0 0 0 0 0",
        options={"sensor": "dashboard", "units": {"gyr": "deg/s"}},
    ),
    Style(
        "telemachus",
        "0.9.0",
        "telemachus, core/schemas.py, as published on PyPI",
        "ts,lat,lon,speed_mps,ax_mps2,ay_mps2,az_mps2,gx_rad_s,gy_rad_s,gz_rad_s,mx_uT,my_uT,mz_uT",
        "iso 0 0 0 a g m",
    ),
    Style(
        "ulog2csv, sensor_gyro",
        "pyulog 1.3.0",
        "PX4's message definition SensorGyro",
        "timestamp,timestamp_sample,device_id,x,y,z,temperature,error_count,clip_counter[0],clip_counter[1],"
        "clip_counter[2],samples",
        "t/us t/us n g 0 0 0 0 0 0",
        options={"columns": {"t": "timestamp_sample", "gyr": ["x", "y", "z"]}, "units": {"t": "us"}},
        name="log_sensor_gyro_0.csv",
    ),
    Style(
        "bagpy, sensor_msgs/MagneticField",
        "0.5",
        PACKAGE,
        "Time,header.seq,header.stamp.secs,header.stamp.nsecs,header.frame_id,magnetic_field.x,magnetic_field.y,"
        "magnetic_field.z",
        "t1970+0.3 n t/whole t/nanos text m/tesla",
        options={"units": {"mag": "T"}},
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}OpenIMU300RI, VG_AHRS, packet a1",
        "timeITOW (msec),time (s),roll (deg),pitch (deg),xRate (deg/s),yRate (deg/s),zRate (deg/s),xAccel (m/s^2),"
        "yAccel (m/s^2),zAccel (m/s^2),opMode (unitless),linAccSw (unitless),turnSw (unitless)",
        "t/ms t 0 0 g/dps a 0 0 0",
    ),
    Style(
        *OPENIMU,
        f"{OPENIMU_SOURCE}dmu, packet S1: no time",
        "xAccel (m/s^2),yAccel (m/s^2),zAccel (m/s^2),xRate (deg/s),yRate (deg/s),zRate (deg/s),xRateTemp (deg),"
        "yRateTemp (deg),zRateTemp (deg),boardTemp (deg),counter (packets),BITstatus",
        "a g/dps 0 0 0 0 n 0",
        options={"rate": 100.0},
    ),
]
