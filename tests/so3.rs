//! The laws of rotations, each run for scalars and for lanes of several widths.
//!
//! Tolerances are multiples of the scalar's epsilon: a component of a quaternion product is a sum of four products and
//! rounds by at most 2 epsilon, a rotated unit vector by at most 6; what follows is counted from these.

#![allow(clippy::indexing_slicing, reason = "an index out of range fails the test, as it should")]
#![allow(clippy::float_cmp, reason = "where a law is exact it is tested exactly")]

#[path = "support/double_double.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod double_double;
#[path = "so3/euler.rs"]
mod euler;
#[path = "so3/exponential.rs"]
mod exponential;
#[cfg(feature = "glam")]
#[path = "so3/glam.rs"]
mod glam;
#[path = "so3/group.rs"]
mod group;
#[path = "so3/kinds.rs"]
mod kinds;
#[path = "so3/outlined.rs"]
mod outlined;
#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;
#[path = "so3/special.rs"]
mod special;

use ahrs_rs::Pair;

/// Makes a test of each law that runs it for every kind of scalar.
macro_rules! laws {
    ($($module:ident :: $law:ident),+ $(,)?) => {$(
        #[test]
        fn $law() {
            $module::$law::<f32>();
            $module::$law::<f64>();
            $module::$law::<Pair<f64>>();
            $module::$law::<Pair<Pair<f64>>>();
            $module::$law::<Pair<Pair<f32>>>();
        }
    )+};
}

laws! {
    kinds::there_are_examples_that_differ_from_lane_to_lane,
    group::multiplication_is_associative,
    group::the_conjugate_is_the_inverse,
    group::the_norm_is_multiplicative,
    group::rotation_is_a_homomorphism,
    group::the_matrix_is_orthonormal_and_right_handed,
    group::the_matrix_rotates_as_the_quaternion,
    group::a_quaternion_and_its_negative_are_one_rotation,
    group::selection_is_by_lane,
    group::renormalization_squares_the_error,
    group::a_quaternion_is_scaled_to_unit_norm_wherever_it_has_a_direction,
    exponential::the_exponential_agrees_with_a_reference_of_100_bits,
    exponential::exponentials_of_parallel_vectors_add,
    exponential::the_exponential_of_the_negative_is_the_inverse,
    exponential::the_exponential_of_what_is_beyond_its_range_is_the_identity,
    exponential::rotate_by_turns_by_rate_times_time,
    exponential::the_first_order_step_is_short_by_a_third_of_the_cube,
    euler::a_quaternion_comes_back_from_its_euler_angles_everywhere,
    euler::euler_angles_come_back_from_their_quaternion,
    euler::euler_angles_are_yaw_then_pitch_then_roll,
    euler::at_the_poles_roll_is_zero,
    special::the_shortest_rotation_takes_a_direction_up,
    special::the_turn_to_north_takes_a_horizontal_vector_to_y,
    special::frames_are_rotations_with_the_named_axes,
}
