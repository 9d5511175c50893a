//! Repeatable random numbers: every run and every machine tests the same values.

/// The generator `SplitMix64` (Steele, Lea & Flood, OOPSLA 2014).
#[derive(Clone)]
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// One of 0 … n − 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
    /// In [low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1_u64 << 53) as f64)
    }
    /// True with the probability `p`.
    pub fn chance(&mut self, p: f64) -> bool {
        self.uniform(0.0, 1.0) < p
    }
    /// Nearly normal, of variance one: the sum of twelve uniform numbers.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform(-0.5, 0.5)).sum()
    }
    /// A number of random sign whose magnitude is spread evenly over the powers of ten from `low` to `high`.
    pub fn spread(&mut self, low: f64, high: f64) -> f64 {
        let magnitude = 10.0_f64.powf(self.uniform(low, high));
        if self.chance(0.5) { -magnitude } else { magnitude }
    }
    pub fn normal3(&mut self) -> [f64; 3] {
        [self.normal(), self.normal(), self.normal()]
    }
    /// A direction, nearly uniform on the sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        let v = self.normal3();
        let norm = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        v.map(|c| c / norm)
    }
    /// A unit quaternion, nearly uniform over the rotations.
    pub fn rotation(&mut self) -> [f64; 4] {
        let q = [self.normal(), self.normal(), self.normal(), self.normal()];
        let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        q.map(|c| c / norm)
    }
}
