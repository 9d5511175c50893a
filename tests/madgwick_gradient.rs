//! Madgwick's gradients against numeric derivatives of the objective that they descend.
//!
//! With a, m the unit measurements, b the earth's field with north on its axis and the inclination measured now, the
//! objective is ½‖R(q)ᵀz − a‖² + ½‖R(q)ᵀb − m‖²: a polynomial of the fourth degree in q, of which two central
//! differences give the derivative exactly, but for rounding.

#![allow(clippy::unwrap_used, reason = "a test that fails may panic")]

#[path = "support/random.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod random;

use ahrs_rs::filters::Integration;
use ahrs_rs::filters::madgwick::{Gradient, Madgwick, Params};
use ahrs_rs::{Estimator, Filter, Frame, Quat, Settings, Vec3};
use random::Random;

/// Objectives of up to 50 round by 1e-14; divided by the step and by a norm of at least 0.05, and doubled, 2e-12.
const TOLERANCE: f64 = 1e-11;

/// R(q)ᵀ in the published form, for unnormalised q too: ½ − y² − z² on the diagonal, doubled.
fn published_rows(q: Quat<f64>) -> [[f64; 3]; 3] {
    let Quat { w, x, y, z } = q;
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// The objective; without a field where that is `None`. Each pair is a direction of the earth and what is measured.
fn objective(q: Quat<f64>, pairs: &[([f64; 3], [f64; 3])]) -> f64 {
    let rows = published_rows(q);
    let squares = pairs.iter().flat_map(|(earth, measured)| {
        rows.iter().zip(measured).map(move |(row, measured)| {
            let predicted: f64 = row.iter().zip(earth).map(|(r, e)| r * e).sum();
            (predicted - measured).powi(2)
        })
    });
    0.5 * squares.sum::<f64>()
}

fn numeric_gradient(q: Quat<f64>, pairs: &[([f64; 3], [f64; 3])]) -> Quat<f64> {
    let along = |unit: [f64; 4]| {
        let slope = |step: f64| {
            let moved = Quat::of(unit).scale(step);
            (objective(q.plus(moved), pairs) - objective(q.plus(-moved), pairs)) / (2.0 * step)
        };
        // Richardson: the error of either is its step's square times the same number.
        (4.0 * slope(0.25) - slope(0.5)) / 3.0
    };
    Quat::new(
        along([1.0, 0.0, 0.0, 0.0]),
        along([0.0, 1.0, 0.0, 0.0]),
        along([0.0, 0.0, 1.0, 0.0]),
        along([0.0, 0.0, 0.0, 1.0]),
    )
}

/// Directions of the earth with what is measured, north on x or y.
fn pairs(q: Quat<f64>, a: Option<[f64; 3]>, m: Option<[f64; 3]>, north_on_x: bool) -> Vec<([f64; 3], [f64; 3])> {
    let field = |m: [f64; 3]| {
        let h = q.rotate(Vec3::of(m));
        let horizontal = h.x.hypot(h.y);
        if north_on_x { [horizontal, 0.0, h.z] } else { [0.0, horizontal, h.z] }
    };
    a.map(|a| ([0.0, 0.0, 1.0], a)).into_iter().chain(m.map(|m| (field(m), m))).collect()
}

fn estimator(q: Quat<f64>, params: &Params<f64>) -> Estimator<f64, Madgwick<f64>> {
    let mut estimator = Estimator::new(params, Settings::default());
    estimator.start_from(q);
    estimator
}

/// What the filter says of its gradient at `q`: 2 q* ⊗ ∇f/‖∇f‖. A step of no length does not move it.
fn innovation(q: Quat<f64>, a: Option<[f64; 3]>, m: Option<[f64; 3]>, gradient: Gradient) -> [f64; 3] {
    let mut estimator = estimator(q, &Params { gradient, ..Params::default() });
    // Lengths do not matter: m/s² and µT.
    let (acc, mag) = (a.map(|a| Vec3::of(a) * 9.8), m.map(|m| Vec3::of(m) * 50.0));
    estimator.step(Vec3::zero(), acc, mag, 0.0);
    let mut values = Vec::new();
    estimator.filter().output(0, &mut |value| values.push(value));
    values.try_into().unwrap()
}

/// An attitude, and the directions that accelerometer and magnetometer measure.
type Example = (Quat<f64>, Option<[f64; 3]>, Option<[f64; 3]>);

/// Random attitudes and measurements, of either sensor or both.
fn examples() -> Vec<Example> {
    let mut random = Random(1);
    let example = |k| {
        let q = Quat::of(random.rotation());
        let (a, m) = (random.direction(), random.direction());
        (q, (k % 3 != 1).then_some(a), (k % 3 != 2).then_some(m))
    };
    (0..600).map(example).collect()
}

fn assert_near(value: [f64; 3], expected: Vec3<f64>) {
    let error = (Vec3::of(value) - expected).norm2().sqrt();
    assert!(error <= TOLERANCE, "{value:?} and {expected:?} differ by {error:e}");
}

#[test]
fn the_tangent_gradient_is_the_projected_numeric_gradient() {
    let mut tested = 0;
    for (q, a, m) in examples() {
        let gradient = numeric_gradient(q, &pairs(q, a, m, false));
        let tangent = gradient.plus(q.scale(-gradient.dot(q)));
        let norm = tangent.dot(tangent).sqrt();
        if norm > 0.05 {
            let expected = (q.conj() * tangent).vector() * (2.0 / norm);
            assert_near(innovation(q, a, m, Gradient::Tangent), expected);
            tested += 1;
        }
    }
    assert!(tested > 300, "{tested} examples are not enough");
}

#[test]
fn the_tangent_gradient_does_not_depend_on_where_north_is() {
    for (q, a, m) in examples() {
        let north_on_y = numeric_gradient(q, &pairs(q, a, m, false));
        let turned: Quat<f64> = Frame::Nwu.from_enu::<f64>() * q;
        let north_on_x = numeric_gradient(turned, &pairs(turned, a, m, true));
        let vector = |q: Quat<f64>, gradient: Quat<f64>| (q.conj() * gradient).vector();
        let error = vector(q, north_on_y) - vector(turned, north_on_x);
        assert!(error.norm2().sqrt() <= TOLERANCE, "{error:?}");
    }
}

#[test]
fn the_paper_gradient_is_the_numeric_gradient_of_the_published_form_with_north_on_x() {
    let mut tested = 0;
    for (q, a, m) in examples() {
        let turned: Quat<f64> = Frame::Nwu.from_enu::<f64>() * q;
        let gradient = numeric_gradient(turned, &pairs(turned, a, m, true));
        let norm = gradient.dot(gradient).sqrt();
        if norm > 0.05 {
            let expected = (turned.conj() * gradient).vector() * (2.0 / norm);
            assert_near(innovation(q, a, m, Gradient::Paper), expected);
            tested += 1;
        }
    }
    assert!(tested > 300, "{tested} examples are not enough");
}

#[test]
fn a_step_descends_at_the_rate_beta() {
    for (q, a, m) in examples() {
        for integration in [Integration::Exponential, Integration::FirstOrder] {
            let pairs = pairs(q, a, m, false);
            let gradient = numeric_gradient(q, &pairs);
            let tangent = gradient.plus(q.scale(-gradient.dot(q)));
            let norm = tangent.dot(tangent).sqrt();
            if norm < 0.05 {
                continue;
            }
            let params = Params { beta: 0.1, integration, ..Params::default() };
            let mut estimator = estimator(q, &params);
            let (acc, mag) = (a.map(Vec3::of), m.map(Vec3::of));
            let dt = 1e-3;
            let after = estimator.step(Vec3::zero(), acc, mag, dt).quat;
            // q moves by β dt, so the objective falls by that times the norm of its gradient; the curvature, below 8,
            // gives back at most half of it times the square of the step.
            let fall = objective(q, &pairs) - objective(after, &pairs);
            let expected = 0.1 * dt * norm;
            assert!((fall - expected).abs() <= 4.0 * (0.1 * dt) * (0.1 * dt), "{fall:e}, {expected:e}");
        }
    }
}
