//! Errors of attitudes against a reference, without keeping the attitudes.

use ahrs_rs::trig::atan2;
use ahrs_rs::{Quat, Real, Scalar};

use crate::simd::{Instructions, Kernel, Vector};

/// Which angle of the error quaternion e = q ⊗ q_ref* in the earth frame (BROAD; `ahrs_rs.metrics` in Python).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// That of the whole rotation.
    Total,
    /// That about the vertical.
    Heading,
    /// That between the verticals.
    Inclination,
}

/// Sums of squared errors in rad², and how many samples are in them; one sum a lane.
#[derive(Clone, Debug)]
pub struct Sums {
    /// The sums.
    pub squares: Vec<f64>,
    /// The samples that had a reference.
    pub count: u64,
}

impl Sums {
    /// Nothing yet.
    pub fn new(lanes: usize) -> Self {
        Sums { squares: vec![0.0; lanes], count: 0 }
    }

    /// The root of the mean square of a lane in rad; NaN where no sample had a reference.
    pub fn rmse(&self, lane: usize) -> f64 {
        let squares = self.squares.get(lane).copied().unwrap_or(f64::NAN);
        if self.count == 0 { f64::NAN } else { (squares / self.count as f64).sqrt() }
    }
}

impl Metric {
    /// Every metric with its name.
    pub const ALL: [(&'static str, Metric); 3] =
        [("total", Metric::Total), ("heading", Metric::Heading), ("inclination", Metric::Inclination)];

    /// The metric of a name, or `None`.
    pub fn from_name(name: &str) -> Option<Metric> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|&(_, metric)| metric)
    }

    /// Adds the errors of rows of attitudes, in the order of [`Rows`](crate::bank::Rows), to the sums.
    pub fn score<T: Real, I: Instructions<T>>(
        self,
        instructions: I,
        quat: &[T],
        reference: &[Option<[T; 4]>],
        sums: &mut Sums,
    ) {
        instructions.run(Score::<I::Vector> { metric: self, quat, reference, sums });
    }

    /// Half the angle's tangent as a quotient of two lengths.
    #[inline(always)]
    fn half<S: Scalar>(self, e: Quat<S>) -> (S, S) {
        match self {
            Metric::Total => (e.vector().norm2().sqrt(), e.w.abs()),
            Metric::Heading => (e.z.abs(), e.w.abs()),
            Metric::Inclination => ((e.x * e.x + e.y * e.y).sqrt(), (e.w * e.w + e.z * e.z).sqrt()),
        }
    }
}

struct Score<'a, S: Scalar> {
    metric: Metric,
    quat: &'a [S::Real],
    reference: &'a [Option<[S::Real; 4]>],
    sums: &'a mut Sums,
}

impl<S: Vector> Kernel for Score<'_, S> {
    #[inline(always)]
    fn run(self) {
        let lanes = S::LANES;
        let mut squares = S::zero();
        for (row, reference) in self.quat.chunks_exact(4 * lanes).zip(self.reference) {
            let &Some([w, x, y, z]) = reference else { continue };
            let mut parts = row.chunks_exact(lanes);
            let mut next = || S::load(parts.next().unwrap_or_default());
            let q = Quat::new(next(), next(), next(), next());
            let reference = Quat::new(S::splat(w), S::splat(x), S::splat(y), S::splat(z));
            let (across, along) = self.metric.half(q * reference.conj());
            let half = atan2(across, along);
            squares = squares + half * half;
            self.sums.count += 1;
        }
        // Sums of a tile in the filter's precision, those of a recording in f64.
        for (lane, sum) in self.sums.squares.iter_mut().enumerate().take(lanes) {
            *sum += 4.0 * squares.lane(lane).to_f64();
        }
    }
}
