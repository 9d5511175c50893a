/* The filters of ahrs_rs in C. Made by `make header` from crates/capi/src and the registry; do not edit.
 *
 *     static AhrsMadgwick ahrs;
 *     const float parameters[] = {0.08f};
 *
 *     ahrs_init(&ahrs, sizeof ahrs, &ahrs_Madgwick, parameters, 1, NULL);
 *     for (;;) {
 *         ... wait for a sample ...
 *         ahrs_update(&ahrs, gyr, acc, mag, dt, quat);
 *     }
 *
 * Link with libahrs_rs_c.a, and let the linker drop what is not used (--gc-sections): only the filters that are named are in
 * the image. Nothing allocates; different memories may be used from different threads. */


#ifndef AHRS_RS_H
#define AHRS_RS_H

#include <stddef.h>
#include <stdint.h>

/**
 * Done.
 */
#define AHRS_OK 0

/**
 * A pointer is NULL that must not be.
 */
#define AHRS_NULL -1

/**
 * The memory is too small, or not aligned to 8 bytes.
 */
#define AHRS_MEMORY -2

/**
 * There is no filter in the memory: ahrs_init has not been called, or has refused.
 */
#define AHRS_NO_FILTER -3

/**
 * A setting is none of its constants, or not finite.
 */
#define AHRS_SETTING -4

/**
 * There are more values than parameters.
 */
#define AHRS_TOO_MANY -5

/**
 * A parameter is out of its range: this less its index, so −1002 for the third.
 */
#define AHRS_PARAMETER -1000

/**
 * x east, y north, z up.
 */
#define AHRS_ENU 0

/**
 * x north, y east, z down.
 */
#define AHRS_NED 1

/**
 * x north, y west, z up.
 */
#define AHRS_NWU 2

/**
 * The angular rate of a sample holds over the whole step that ends with it.
 */
#define AHRS_ZERO_ORDER 0

/**
 * The angular rate over a step is the mean of those at both ends.
 */
#define AHRS_LINEAR 1

/**
 * A repeated row is a measurement as any other.
 */
#define AHRS_NEW 0

/**
 * A repeated row is none, while the gyroscope's differs, for 1 s at most.
 */
#define AHRS_MISSING 1

/**
 * There was no usable accelerometer sample.
 */
#define AHRS_ACC_MISSING 1

/**
 * There was no usable magnetometer sample.
 */
#define AHRS_MAG_MISSING 2

/**
 * There was no usable gyroscope sample: the last angular rate was held.
 */
#define AHRS_GYR_HELD 4

/**
 * The filter did not trust the accelerometer.
 */
#define AHRS_ACC_REJECTED 8

/**
 * The filter did not trust the magnetometer.
 */
#define AHRS_MAG_REJECTED 16

/**
 * The sensor rests.
 */
#define AHRS_REST 32

/**
 * No accelerometer sample has come yet.
 */
#define AHRS_NOT_ALIGNED 64

/**
 * The filter recovers from a long rejection, or from a rotation that was lost.
 */
#define AHRS_RECOVERING 128

/**
 * The step was much longer than usual.
 */
#define AHRS_GAP 256

/**
 * A row repeats its sensor's last one and was taken for missing, as the settings ask.
 */
#define AHRS_REPEATED 512

/**
 * What a filter is: named where one is made, and nowhere else.
 */
typedef struct AhrsFilter AhrsFilter;

/**
 * What is chosen beside a filter's own parameters. All zero is the default.
 */
typedef struct AhrsSettings {
  /**
   * Magnetic declination in rad, positive east.
   */
  float declination;
  /**
   * The earth frame of the quaternions: AHRS_ENU, AHRS_NED or AHRS_NWU.
   */
  uint8_t frame;
  /**
   * How the angular rate runs between samples: AHRS_ZERO_ORDER or AHRS_LINEAR.
   */
  uint8_t gyr_hold;
  /**
   * What a row is that repeats its sensor's last one: AHRS_NEW or AHRS_MISSING.
   */
  uint8_t repeated;
  /**
   * The largest rate in rad/s that an axis of the gyroscope shows: what is beyond it is lost. 0 where it is not known.
   */
  float gyr_range;
} AhrsSettings;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * How many bytes a filter needs on this machine; never more than the header's constant for it. 0 for NULL.
 *
 * `filter` is NULL or one of the filters of the header.
 */
size_t ahrs_size(const struct AhrsFilter *filter);

/**
 * Makes a filter in `memory` of `size` bytes, aligned to 8: an object of the filter's type in the header is just that. It
 * may be called again to start anew.
 *
 * `values` are the first `count` parameters in the header's order, the others have their defaults; NULL with 0 for all of
 * them. `settings` may be NULL for the defaults.
 *
 * Pointers are NULL or valid: `memory` for writing `size` bytes, `values` for reading `count` numbers; `filter` is one of the
 * filters of the header.
 */
int32_t ahrs_init(void *memory,
                  size_t size,
                  const struct AhrsFilter *filter,
                  const float *values,
                  size_t count,
                  const struct AhrsSettings *settings);

/**
 * Sets the attitude one step before the first sample: scalar first, from the sensor's frame to the chosen earth frame.
 * Without it the first samples give the attitude.
 *
 * `memory` was given to `ahrs_init`, or is zero; `quat` has four numbers.
 */
int32_t ahrs_start_from(void *memory,
                        const float *quat);

/**
 * Goes on by `dt` seconds to a new sample and writes the attitude: scalar first, from the sensor's frame to the chosen earth
 * frame.
 *
 * `gyr` in rad/s, `acc` (specific force) in m/s², `mag` in any unit, three numbers each in one right-handed frame. NULL, or
 * a NaN in it, is a sensor that has nothing new: a magnetometer that is slower, a sensor that is not there. `quat` has room
 * for four numbers, or is NULL.
 *
 * `memory` was given to `ahrs_init`, or is zero; the other pointers are NULL or valid for as many numbers as said.
 */
int32_t ahrs_update(void *memory,
                    const float *gyr,
                    const float *acc,
                    const float *mag,
                    float dt,
                    float *quat);

/**
 * Writes the last attitude; before the first sample the given one, or the earth frame's identity.
 *
 * `memory` was given to `ahrs_init`, or is zero; `quat` is NULL or has room for four numbers.
 */
int32_t ahrs_quat(const void *memory, float *quat);

/**
 * Writes the estimated bias of the gyroscope in rad/s; zero for a filter that estimates none.
 *
 * `memory` was given to `ahrs_init`, or is zero; `bias` is NULL or has room for three numbers.
 */
int32_t ahrs_gyr_bias(const void *memory, float *bias);

/**
 * What the last update says beside the attitude: the sum of AHRS_ACC_MISSING and the constants after it, or a negative error.
 * 0 before the first update.
 *
 * `memory` was given to `ahrs_init`, or is zero.
 */
int32_t ahrs_status(const void *memory);

/* The filters, each with the memory for one. */

/**
 * GyroIntegration. The angular rate integrated from the initial alignment; accelerometer and magnetometer are
 * used for that alignment only.
 *
 * Source: q⁺ = q ⊗ exp(½ω dt), the exact solution of q̇ = ½ q ⊗ ω for a rate that is constant over the step.
 *
 * Parameters, in this order:
 * - integration (0 exponential, 1 first-order): Integration of the angular rate over a step: by the
 *   exponential map, exact for a rate that is constant over the step, or by the first-order step of the papers
 *   followed by normalisation.
 */
extern const AhrsFilter ahrs_GyroIntegration;
typedef union AhrsGyroIntegration {
  uint64_t aligned;
  unsigned char bytes[320];
} AhrsGyroIntegration;

/**
 * Tilt. The attitude turned by the shortest way so that the specific force of this sample points up. The
 * gyroscope is used only where the accelerometer has no sample, so the heading is carried along, not measured.
 *
 * Source: the shortest rotation between two directions.
 */
extern const AhrsFilter ahrs_Tilt;
typedef union AhrsTilt {
  uint64_t aligned;
  unsigned char bytes[312];
} AhrsTilt;

/**
 * Ecompass. Inclination from the specific force and heading from the horizontal magnetic field of this sample
 * alone. Without a magnetometer the last heading is kept; the gyroscope is used only where the accelerometer
 * has no sample.
 *
 * Source: the two directions of Wahba's problem solved in turn, the vertical exactly (TRIAD, Black 1964).
 */
extern const AhrsFilter ahrs_Ecompass;
typedef union AhrsEcompass {
  uint64_t aligned;
  unsigned char bytes[312];
} AhrsEcompass;

/**
 * Trigonometric. Roll and pitch without fusion: from the specific force of this sample (the papers' "matrix"
 * method), or from the Euler rates of the gyroscope. The heading of the start is held, or integrated with the
 * rates.
 *
 * Source: Çoçoli & Badia 2023, eqs 3-5, with signs for a specific force of +g at rest.
 *
 * Parameters, in this order:
 * - source (0 acc, 1 gyr): Where roll and pitch come from: the accelerometer (eqs 3-4), or the gyroscope by
 *   Euler rates (eq. 5), which the accelerometer then only starts.
 */
extern const AhrsFilter ahrs_Trigonometric;
typedef union AhrsTrigonometric {
  uint64_t aligned;
  unsigned char bytes[312];
} AhrsTrigonometric;

/**
 * Complementary. Roll and pitch are integrated from the gyroscope and drawn towards those of the specific
 * force with a time constant: high-pass and low-pass of the same corner. The heading is integrated.
 *
 * Source: Parikh et al. 2021, section II.A; their α = 0.997 at 200 Hz is τ = 1.6617 s.
 *
 * Parameters, in this order:
 * - tau (s, 1.6616666666666666 in [1e-9, 1000000.0]): Time constant τ of the correction: the gyroscope's
 *   weight in a step is α = τ/(τ + dt).
 * - acc_threshold (m/s², 0.0 in [0.0, 1000000.0]): Deviation of the specific force's norm from gravity above
 *   which the accelerometer's weight falls, linearly to none at twice as much (Valenti et al. 2015; the
 *   adaptive gain that Parikh et al. 2021 propose); 0: never.
 * - integration (0 exponential, 1 first-order): Integration of the angular rate over a step: by the
 *   exponential map, exact for a rate that is constant over the step, or by the first-order step of the papers
 *   followed by normalisation.
 */
extern const AhrsFilter ahrs_Complementary;
typedef union AhrsComplementary {
  uint64_t aligned;
  unsigned char bytes[328];
} AhrsComplementary;

/**
 * LinearKalman. Roll and pitch, each with the bias of its gyroscope axis, are estimated by a linear Kalman
 * filter of its own from the angles of the specific force. The heading is integrated.
 *
 * Source: Parikh et al. 2021, eqs 1-2; Çoçoli & Badia 2023, Table I.
 *
 * Parameters, in this order:
 * - angle_process (rad²/s, 0.0007195063455362055 in [0.0, 1000000.0]): Process noise of the angle: the first
 *   entry of Q is this times dt. Parikh: 0.01181 deg² in 5 ms.
 * - bias_process (rad²/s³, 2.607525113374225e-7 in [0.0, 1000000.0]): Process noise of the bias: the second
 *   entry of Q is this times dt. Parikh: 4.28e-6 deg² in 5 ms.
 * - angle_variance (rad², 0.8072361624347777 in [1e-12, 1000000.0]): Variance R of the specific force's angle.
 *   Parikh: 2650 deg².
 * - initial_angle (rad, 0.0 in [0.0, 1000.0]): Standard deviation of roll and pitch at the start (0: that of
 *   one measurement).
 * - initial_bias (rad/s, 0.01 in [1e-9, 1000.0]): Standard deviation of the biases at the start.
 * - integration (0 exponential, 1 first-order): Integration of the angular rate over a step: by the
 *   exponential map, exact for a rate that is constant over the step, or by the first-order step of the papers
 *   followed by normalisation.
 */
extern const AhrsFilter ahrs_LinearKalman;
typedef union AhrsLinearKalman {
  uint64_t aligned;
  unsigned char bytes[408];
} AhrsLinearKalman;

/**
 * Mahony. The angular rate is corrected in proportion to the error between measured and predicted directions
 * of gravity and magnetic field, and by its integral, which is the gyroscope's bias. In a gap of more than
 * 1/(2 kp) the feedback counts for that long only: two directions pull with up to 2 kp.
 *
 * Source: Mahony et al., IEEE TAC 53(5), 2008 (explicit complementary filter); Ludwig & Burnham 2018, Alg. 1;
 * Çoçoli & Badia 2023, Alg. 1.
 *
 * Parameters, in this order:
 * - kp (rad/s, 1.0 in [0.0, 1000000.0]): Proportional gain kp of the direction error: the inclination's error
 *   decays at kp.
 * - ki (rad/s², 0.3 in [0.0, 1000000.0]): Integral gain ki of the direction error, which estimates the
 *   gyroscope's bias.
 * - acc_threshold (m/s², 0.0 in [0.0, 1000000.0]): Deviation of the specific force's norm from gravity above
 *   which the accelerometer's share of the error falls, linearly to none at twice as much (Valenti et al.
 *   2015; the adaptive gain that Parikh et al. 2021 propose); 0: never.
 * - integration (0 exponential, 1 first-order): Integration of the angular rate over a step: by the
 *   exponential map, exact for a rate that is constant over the step, or by the first-order step of the papers
 *   followed by normalisation.
 */
extern const AhrsFilter ahrs_Mahony;
typedef union AhrsMahony {
  uint64_t aligned;
  unsigned char bytes[360];
} AhrsMahony;

/**
 * Madgwick. The attitude follows the gyroscope and descends at a constant rate along the gradient of the
 * squared error between measured and predicted directions of gravity and magnetic field. A step that would
 * turn by more than 0.1 rad is a gap in the data, and turns no further than the error.
 *
 * Source: Madgwick et al., ICORR 2011; Ludwig & Burnham 2018, Alg. 2; Çoçoli & Badia 2023, Alg. 2 with (17)
 * divided by the norm of the gradient.
 *
 * Parameters, in this order:
 * - beta (rad/s, 0.041 in [0.0, 1000000.0]): Rate β of the descent: the attitude's correction turns at 2β.
 * - zeta (rad/s², 0.0 in [0.0, 1000000.0]): Gain ζ with which the direction of the descent changes the
 *   estimate of the gyroscope's bias (0: no estimate).
 * - acc_threshold (m/s², 0.0 in [0.0, 1000000.0]): Deviation of the specific force's norm from gravity above
 *   which the accelerometer's part of the gradient falls, linearly to none at twice as much (Valenti et al.
 *   2015; the adaptive gain that Parikh et al. 2021 propose); 0: never.
 * - gradient (0 tangent, 1 paper): The gradient that is normalised: its part along rotations, which does not
 *   depend on the choice of axes, or the published one, computed with north on x, whose part along q does.
 * - integration (0 exponential, 1 first-order): Integration of the angular rate over a step: by the
 *   exponential map, exact for a rate that is constant over the step, or by the first-order step of the papers
 *   followed by normalisation.
 */
extern const AhrsFilter ahrs_Madgwick;
typedef union AhrsMadgwick {
  uint64_t aligned;
  unsigned char bytes[368];
} AhrsMadgwick;

/**
 * EKF. An extended Kalman filter whose state is the quaternion and the angular rate, held by process noise
 * alone; gyroscope, specific force over g and field over its reference's norm are measurements. It estimates
 * no bias. The field's inclination and norm come from the first magnetometer samples.
 *
 * Source: Cirillo et al. 2014, eqs 7-26, in east-north-up, from the library's alignment; with
 * gyroscope="input" the form of Ludwig & Burnham 2018, eqs 17-22.
 *
 * Parameters, in this order:
 * - gyr_variance_x (rad²/s², 2.9e-5 in [1e-12, 1000000.0]): Variance of the gyroscope's x axis (V of the
 *   paper).
 * - gyr_variance_y (rad²/s², 2.3e-5 in [1e-12, 1000000.0]): Variance of the gyroscope's y axis.
 * - gyr_variance_z (rad²/s², 3.2e-5 in [1e-12, 1000000.0]): Variance of the gyroscope's z axis.
 * - acc_variance_x (1, 3.1e-5 in [1e-12, 1000000.0]): Variance of the accelerometer's x axis over g².
 * - acc_variance_y (1, 4.5e-5 in [1e-12, 1000000.0]): Variance of the accelerometer's y axis over g².
 * - acc_variance_z (1, 5.5e-5 in [1e-12, 1000000.0]): Variance of the accelerometer's z axis over g².
 * - mag_variance_x (1, 0.002 in [1e-12, 1000000.0]): Variance of the magnetometer's x axis over the square of
 *   the reference field's norm.
 * - mag_variance_y (1, 0.0021 in [1e-12, 1000000.0]): Variance of the magnetometer's y axis over the square of
 *   the reference field's norm.
 * - mag_variance_z (1, 0.002 in [1e-12, 1000000.0]): Variance of the magnetometer's z axis over the square of
 *   the reference field's norm.
 * - quat_process (1/s, 5e-8 in [0.0, 1000000.0]): Process noise of the quaternion's components: W is this
 *   times dt. Cirillo: 1e-10 in 2 ms.
 * - rate_process (rad²/s³, 0.5 in [0.0, 1000000.0]): Process noise of the angular rate: W is this times dt.
 *   Cirillo: 1e-3 in 2 ms.
 * - reference_time (s, 0.0 in [0.0, 1000000.0]): How long the reference field is averaged over magnetometer
 *   samples (0: the first one).
 * - initial_inclination (rad, 0.0 in [0.0, 1000.0]): Standard deviation of the inclination at the start (0:
 *   that of one accelerometer sample).
 * - initial_heading (rad, 0.0 in [0.0, 1000.0]): Standard deviation of the heading at the start (0: that of
 *   one magnetometer sample at a dip of 60°).
 * - initial_rate (rad/s, 1.0 in [1e-6, 1000.0]): Standard deviation of the angular rate at the start.
 * - gravity (m/s², 9.80665 in [0.001, 1000.0]): Gravity g, by which the specific force is divided.
 * - gyroscope (0 measurement, 1 input): What the gyroscope is: a measurement of the rate in the state
 *   (Cirillo), or the input that turns the attitude, with the gyroscope's variances as the rate's covariance
 *   in every step.
 * - integration (0 exponential, 1 first-order): Integration of the angular rate over a step: by the
 *   exponential map, exact for a rate that is constant over the step, or by the first-order step of the papers
 *   followed by normalisation.
 */
extern const AhrsFilter ahrs_EKF;
typedef union AhrsEKF {
  uint64_t aligned;
  unsigned char bytes[680];
} AhrsEKF;

/**
 * DcmImu. An extended Kalman filter whose state is the vertical seen from the sensor (the bottom row C3 of the
 * rotation matrix) and the gyroscope's bias, with an accelerometer covariance that grows with the external
 * acceleration. The heading is integrated outside of it, with the estimated bias.
 *
 * Source: Hyyti & Visala 2015, eqs 1-15 and A.1-A.8.
 *
 * Parameters, in this order:
 * - dcm_process (1/s, 0.1 in [0.0, 1000000.0]): Process noise σ_C of C3: its variance grows by (σ_C dt)² in a
 *   step, eq. 10.
 * - bias_process (rad/s², 0.0001 in [0.0, 1000000.0]): Process noise σ_b of the bias: its variance grows by
 *   (σ_b dt)² in a step, eq. 10.
 * - acc_std (m/s², 0.5 in [1e-6, 1000000.0]): Standard deviation σ_f of the accelerometer at rest, eq. 11.
 * - acc_motion ((m/s²)^½, 10.0 in [0.0, 1000000.0]): How much the external acceleration a counts: σ_a² |a| is
 *   added to the variance, eq. 11.
 * - initial_dcm (1, 1.0 in [1e-6, 1000.0]): Standard deviation of C3 at the start.
 * - initial_bias (rad/s, 0.1 in [1e-9, 1000.0]): Standard deviation of the bias at the start.
 * - gravity (m/s², 9.80665 in [0.001, 1000.0]): Gravity g where the sensor is.
 * - prediction (0 exponential, 1 euler): How C3 is predicted: by the exact solution over the step, or by the
 *   first-order step as published, which fails at high angular rates (39° on a recording of up to 1454 °/s).
 */
extern const AhrsFilter ahrs_DcmImu;
typedef union AhrsDcmImu {
  uint64_t aligned;
  unsigned char bytes[568];
} AhrsDcmImu;

/**
 * MEKF. An error-state Kalman filter of attitude and gyroscope bias. Its noises are densities, so that they do
 * not depend on the sampling rate. The specific force counts less where its mean is not vertical (external
 * acceleration); the magnetometer corrects only the heading, and is left out where its field is strange or its
 * innovation too large; at rest the gyroscope shows its bias.
 *
 * Source: Markley, J. Guidance 26(2), 2003, with the error as a tilt and a turn in the earth frame.
 *
 * Parameters, in this order:
 * - gyr_noise (rad/s/√Hz, 0.002 in [1e-9, 1000.0]): Noise density of the gyroscope (angle random walk).
 * - bias_noise (rad/s²/√Hz, 0.0001 in [1e-9, 1000.0]): Noise density of the bias' rate (rate random walk).
 * - acc_noise (m/s²/√Hz, 0.3 in [1e-6, 1000.0]): Noise density of the accelerometer.
 * - heading_noise (rad/√Hz, 0.1 in [1e-6, 1000.0]): Noise density of the magnetometer's heading.
 * - acc_adaptation (√s, 0.3 in [0.0, 1000.0]): How much the mean horizontal specific force adds to the density
 *   of the accelerometer (0: nothing).
 * - acc_window (s, 10.0 in [1e-6, 1000000.0]): Time constant of that mean.
 * - mag_tolerance (1, 0.12 in [1e-6, 1000000.0]): Relative deviation of the field from its reference at which
 *   the heading's variance is four times as large.
 * - mag_window (s, 3.0 in [1e-6, 1000000.0]): Time constant of the reference field.
 * - mag_gate (1, 3.0 in [0.001, 1000000.0]): Innovations of the heading beyond this many standard deviations
 *   are not used.
 * - mag_recovery (s, 10.0 in [0.0, 1000000.0]): Time after which a field that was left out is used all the
 *   same.
 * - rest_gyr (rad/s, 0.03490658503988659 in [0.0, 1000.0]): Deviation of the angular rate from its mean below
 *   which the sensor may be at rest.
 * - rest_acc (m/s², 0.5 in [0.0, 1000.0]): Deviation of the specific force from its mean below which the
 *   sensor may be at rest.
 * - rest_time (s, 1.5 in [0.0, 1000000000.0]): Time that both have to be small for.
 * - rest_noise (rad/s/√Hz, 0.01 in [1e-9, 1000.0]): Noise density of the angular rate at rest, as a
 *   measurement of the bias.
 * - initial_inclination (rad, 0.1 in [1e-6, 1000.0]): Standard deviation of the inclination at the start.
 * - initial_heading (rad, 0.5 in [1e-6, 1000.0]): Standard deviation of the heading at the start.
 * - initial_bias (rad/s, 0.05 in [1e-9, 1000.0]): Standard deviation of the bias at the start; it never
 *   becomes larger.
 * - gravity (m/s², 9.80665 in [0.001, 1000.0]): Gravity g where the sensor is.
 * - magnetometer (0 heading, 1 vector): What of the field is used: its heading, or all of it (the inclination
 *   too).
 * - mag_delay (s, 0.0 in [0.0, 1.0]): How long after it is measured a magnetometer's sample comes, beside the
 *   gyroscope's: the field is turned into the present sensor frame by the angular rate.
 */
extern const AhrsFilter ahrs_MEKF;
typedef union AhrsMEKF {
  uint64_t aligned;
  unsigned char bytes[680];
} AhrsMEKF;

/**
 * VQF. Strapdown integration; the inclination is corrected by the specific force, low-pass filtered in an
 * almost inertial frame; the heading by a scalar offset. The gyroscope's bias is estimated at rest and in
 * motion, and a magnetic field that is strange in norm or dip is left out. A missing row is bridged: the next
 * measurement stands for all the time since the last one.
 *
 * Source: Laidig & Seel, Information Fusion 91, 2023 (arXiv 2203.17024); defaults and order of steps as
 * published with its package vqf.
 *
 * Parameters, in this order:
 * - tau_acc (s, 3.0 in [0.0, 1000000.0]): Time constant τ_acc of the low-pass filter of the specific force:
 *   how long acceleration has to cancel out.
 * - tau_mag (s, 9.0 in [0.0, 1000000.0]): Time constant τ_mag of the heading's correction.
 * - motion_bias_est_enabled (0 off, 1 on; 1): Whether the gyroscope's bias is estimated in motion.
 * - rest_bias_est_enabled (0 off, 1 on; 1): Whether rest is detected and the bias estimated then.
 * - mag_dist_rejection_enabled (0 off, 1 on; 1): Whether magnetic disturbances are detected and left out.
 * - bias_sigma_init (°/s, 0.5 in [1e-6, 1000.0]): Standard deviation of the bias at the start.
 * - bias_forgetting_time (s, 100.0 in [0.001, 1000000000.0]): Time in which the standard deviation of the bias
 *   grows from zero to 0.1 °/s.
 * - bias_clip (°/s, 2.0 in [1e-6, 1000000.0]): Largest bias per axis, and largest error that one sample can
 *   show.
 * - bias_sigma_motion (°/s, 0.1 in [1e-6, 1000.0]): Standard deviation of the bias in motion, in the steady
 *   state.
 * - bias_vertical_forgetting_factor (1, 0.0001 in [0.0, 1000.0]): How fast the bias about the vertical, which
 *   motion does not show, goes to zero: a factor on its information.
 * - bias_sigma_rest (°/s, 0.03 in [1e-6, 1000.0]): Standard deviation of the bias at rest, in the steady
 *   state.
 * - rest_min_t (s, 1.5 in [0.0, 1000000.0]): Time that the sensor has to be still for to count as resting.
 * - rest_filter_tau (s, 0.5 in [0.0, 1000000.0]): Time constant of the low-pass filters of the rest detection.
 * - rest_th_gyr (°/s, 2.0 in [1e-9, 1000000.0]): Largest deviation of the angular rate from its low-pass
 *   filtered value at rest.
 * - rest_th_acc (m/s², 0.5 in [1e-9, 1000000.0]): Largest deviation of the specific force from its low-pass
 *   filtered value at rest.
 * - mag_current_tau (s, 0.05 in [0.0, 1000000.0]): Time constant of the low-pass filter of norm and dip of the
 *   field (0: none).
 * - mag_ref_tau (s, 20.0 in [0.0, 1000000.0]): Time constant with which the reference of the field follows.
 * - mag_norm_th (1, 0.1 in [1e-9, 1000000.0]): Largest deviation of the field's norm, relative to the
 *   reference.
 * - mag_dip_th (°, 10.0 in [1e-9, 180.0]): Largest deviation of the field's dip.
 * - mag_new_time (s, 20.0 in [0.0, 1000000.0]): Time of movement after which a new undisturbed field is
 *   accepted.
 * - mag_new_first_time (s, 5.0 in [0.0, 1000000.0]): The same for the first one.
 * - mag_new_min_gyr (°/s, 20.0 in [0.0, 1000000.0]): Angular rate from which on it counts as movement.
 * - mag_min_undisturbed_time (s, 0.5 in [0.0, 1000000.0]): Time after which a field that fits the reference is
 *   believed again.
 * - mag_max_rejection_time (s, 60.0 in [0.0, 1000000.0]): Time for which a disturbed field is left out; after
 *   it, it counts less.
 * - mag_rejection_factor (1, 2.0 in [1.0, 1000000.0]): How much less, and how fast the time of rejection is
 *   won back in an undisturbed field.
 * - mag_delay (s, 0.0 in [0.0, 1.0]): How long after it is measured a magnetometer's sample comes, beside the
 *   gyroscope's: the field is turned into the present sensor frame by the angular rate.
 */
extern const AhrsFilter ahrs_VQF;
typedef union AhrsVQF {
  uint64_t aligned;
  unsigned char bytes[1032];
} AhrsVQF;

/**
 * SelfCalKF. An error-state Kalman filter that calibrates the sensors while it runs: bias and 3×3 matrix of
 * the gyroscope, bias of the accelerometer, hard iron and delay of the magnetometer. The local field may
 * wander in a correlated way; the velocity, which is never far from zero for long, shows the inclination; the
 * magnetometer never moves it.
 *
 * Source: this project, docs/selfcal.md.
 *
 * Parameters, in this order:
 * - gyr_noise (rad/s/√Hz, 0.0003 in [1e-9, 1000.0]): Noise density of the gyroscope (angle random walk).
 * - rate_noise (1/√Hz, 0.0007 in [0.0, 1000.0]): Noise density of the gyroscope for each rad/s that it turns.
 * - gyr_range (rad/s, 0.0 in [0.0, 1000.0]): The largest rate that an axis of the gyroscope shows; 0 where it
 *   is not known, and found where readings stand still.
 * - bias_noise (rad/s²/√Hz, 5e-5 in [0.0, 1000.0]): Noise density of the bias' rate (rate random walk).
 * - velocity (m/s, 0.3 in [1e-6, 1000.0]): Standard deviation of the velocity.
 * - velocity_time (s, 0.5 in [0.001, 1000.0]): The time for which a velocity lasts.
 * - velocity_noise (m/s²/√Hz, 0.01 in [1e-6, 1000.0]): Noise density of the accelerometer.
 * - mag_noise (1/√Hz, 0.04 in [1e-6, 1000.0]): Noise density of a component of the magnetometer, in norms of
 *   the field.
 * - mag_rate_noise (s/rad/√Hz, 0.0007 in [0.0, 1000.0]): How much it grows for each rad/s that the sensor
 *   turns.
 * - mag_tolerance (1, 0.09 in [1e-6, 1000000000.0]): Deviation of the field from its reference, in its norms,
 *   at which it begins to count less (1e9: every field counts alike).
 * - mag_tail (1, 1.7 in [0.001, 1000000.0]): How slowly it does: the weight is (1 +
 *   (deviation/tolerance)²/tail)⁻².
 * - mag_new_time (s, 20.0 in [0.0, 1000000.0]): Time of movement after which a field that is not the
 *   reference's, but the same all the time, is the new reference. A reference that has been seen for less time
 *   itself is given up after that time, and after a quarter of this at the earliest.
 * - disturbance (1, 0.018 in [0.0, 1000.0]): Standard deviation of the field's disturbance, in norms of the
 *   field. Here and in all that follows, 0 takes the state out of the estimate.
 * - disturbance_time (s, 8.0 in [0.001, 1000000.0]): The time for which a disturbance lasts.
 * - hard_iron_noise (1/√s, 0.001 in [0.0, 1000.0]): How fast the hard iron wanders, in norms of the field.
 * - largest_hard_iron (1, 0.1 in [0.0, 1000.0]): The largest standard deviation of the hard iron.
 * - rest_gyr (rad/s, 0.03490658503988659 in [0.0, 1000.0]): Deviation of the angular rate from its mean below
 *   which the sensor may be at rest.
 * - rest_acc (m/s², 0.5 in [0.0, 1000.0]): Deviation of the specific force from its mean below which the
 *   sensor may be at rest.
 * - rest_time (s, 1.5 in [0.0, 1000000000.0]): Time that both have to be small for.
 * - rest_noise (rad/s/√Hz, 0.0005 in [1e-9, 1000.0]): Noise density of the angular rate at rest, as a
 *   measurement of the bias.
 * - rest_velocity (m/s, 0.02 in [1e-6, 1000.0]): Standard deviation of the velocity at rest.
 * - initial_inclination (rad, 0.5 in [1e-6, 1000.0]): Standard deviation of the inclination at the start.
 * - initial_heading (rad, 1.0 in [1e-6, 1000.0]): Standard deviation of the heading at the start.
 * - initial_bias (rad/s, 0.0087 in [0.0, 1000.0]): Standard deviation of the gyroscope's bias at the start; it
 *   never becomes larger.
 * - initial_matrix (1, 0.003 in [0.0, 1000.0]): The same of each entry of the gyroscope's matrix.
 * - initial_velocity (m/s, 1.0 in [1e-6, 1000.0]): The same of the velocity.
 * - initial_acc_bias (m/s², 0.04 in [0.0, 1000.0]): The same of the accelerometer's bias.
 * - initial_gravity (m/s², 0.05 in [0.0, 1000.0]): The same of gravity.
 * - initial_hard_iron (1, 0.001 in [0.0, 1000.0]): The same of the hard iron, in norms of the field.
 * - initial_field (1, 0.05 in [0.0, 1000.0]): The same of the reference field, in its norms.
 * - initial_delay (s, 0.015 in [0.0, 1.0]): The same of the magnetometer's delay.
 * - latency (s, 0.0 in [-1.0, 1.0]): Delay of all sensors behind the attitude that is wanted, by which the
 *   output is turned ahead.
 * - gravity (m/s², 9.80665 in [0.001, 1000.0]): Gravity g where the sensor is.
 */
extern const AhrsFilter ahrs_SelfCalKF;
typedef union AhrsSelfCalKF {
  uint64_t aligned;
  unsigned char bytes[5000];
} AhrsSelfCalKF;

/**
 * BasicVQF. VQF without estimation of the gyroscope's bias, rest detection and magnetic disturbance rejection:
 * strapdown integration, the inclination by the specific force, low-pass filtered in an almost inertial frame,
 * the heading by a scalar offset.
 *
 * Source: Laidig & Seel, Information Fusion 91, 2023 (arXiv 2203.17024): strapdown integration, inclination
 * and heading correction.
 *
 * Parameters, in this order:
 * - tau_acc (s, 3.0 in [0.0, 1000000.0]): Time constant τ_acc of the low-pass filter of the specific force:
 *   how long acceleration has to cancel out.
 * - tau_mag (s, 9.0 in [0.0, 1000000.0]): Time constant τ_mag of the heading's correction.
 * - mag_delay (s, 0.0 in [0.0, 1.0]): How long after it is measured a magnetometer's sample comes, beside the
 *   gyroscope's: the field is turned into the present sensor frame by the angular rate.
 */
extern const AhrsFilter ahrs_BasicVQF;
typedef union AhrsBasicVQF {
  uint64_t aligned;
  unsigned char bytes[440];
} AhrsBasicVQF;

/**
 * Fusion. The angular rate is corrected by the error between measured and predicted vertical, and between
 * measured and predicted heading, which leaves the inclination alone. The gain falls from 10 to its value in
 * the first three seconds, and again after the gyroscope has left its range. A measurement whose error is
 * beyond the rejection's angle is left out, until that has lasted too long. Equal to the imufusion package at
 * a constant rate, with time instead of its counts of samples: in a gap of more than 1/gain the feedback
 * counts for that long only, and without a magnetometer the heading of the start is kept, not zeroed.
 *
 * Source: Madgwick, PhD thesis, University of Bristol 2014, chapter 7; x-io Technologies, Fusion 1.3.
 *
 * Parameters, in this order:
 * - gain (rad/s, 0.5 in [0.0, 1000000.0]): Gain of the feedback: an error decays at this rate. 0 is the
 *   gyroscope alone, after the start.
 * - gyroscope_range (°/s, 0.0 in [0.0, 1000000.0]): Range of the gyroscope; beyond 98 % of it on an axis the
 *   filter starts anew from its attitude. 0: no limit.
 * - acceleration_rejection (°, 0.0 in [0.0, 90.0]): Error of the vertical beyond which the accelerometer is
 *   left out. 0: never.
 * - magnetic_rejection (°, 0.0 in [0.0, 90.0]): Error of the heading beyond which the magnetometer is left
 *   out. 0: never.
 * - rejection_timeout (s, 0.0 in [0.0, 1000000.0]): Time of rejection after which a sensor is used all the
 *   same; a sample that is not rejected takes off nine times its length. 0: nothing is ever left out.
 * - bias (0 off, 1 on; 0): Whether the gyroscope's bias is estimated at rest, axis by axis, with a cut-off of
 *   0.02 Hz.
 * - stationary_threshold (°/s, 3.0 in [1e-6, 1000000.0]): Angular rate on an axis, less the bias, beyond which
 *   the sensor is not at rest.
 * - stationary_period (s, 3.0 in [0.0, 1000000.0]): Time for which the rate must have been below it.
 * - integration (0 first-order, 1 exponential): Integration of the angular rate over a step: by the
 *   first-order step of the original followed by normalisation, or by the exponential map, exact for a rate
 *   that is constant over the step.
 */
extern const AhrsFilter ahrs_Fusion;
typedef union AhrsFusion {
  uint64_t aligned;
  unsigned char bytes[448];
} AhrsFusion;

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* AHRS_RS_H */
