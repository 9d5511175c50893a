//! What a rotation of the sensor does to the estimate: what each filter claims in its description.

use ahrs_rs::filter::Equivariance;
use ahrs_rs::{Quat, Settings, Vec3};

use crate::bank::{ACC, BOTH, Case, Row, Sensors, doubles, run};
use crate::random::Random;
use crate::recording::{array, moving, quat};

/// Two thousand steps whose rounding adds up, and which a normalised gradient or a direction close to the vertical
/// magnifies: far above 2000 epsilon = 4e-13, far below what any dependence on the axes would show.
const BOUND: f64 = 1e-10;

/// The rows that the same sensor gives when it is mounted turned by `r`.
fn mounted(r: Quat<f64>, rows: &[Row]) -> Vec<Row> {
    let turned = |v: [f64; 3]| array(r.rotate(Vec3::of(v)));
    let row = |row: &Row| Row { gyr: turned(row.gyr), acc: turned(row.acc), mag: turned(row.mag), dt: row.dt };
    rows.iter().map(row).collect()
}

/// How the estimates differ after taking the mounting off: as rotations of the earth, sample by sample.
fn differences(case: &Case, r: Quat<f64>, sensors: Sensors) -> Vec<Quat<f64>> {
    let mut rows = moving(31, 2000);
    for k in (40..60).chain(100..103) {
        rows[k].acc = [f64::NAN; 3];
        rows[k + 30].mag = [f64::NAN; 3];
        rows[k + 60].gyr = [f64::NAN; 3];
    }
    let estimates = |rows: &[Row]| run(case.make(&[], Settings::default()).as_mut(), rows, sensors);
    let (plain, turned) = (estimates(&rows), estimates(&mounted(r, &rows)));
    let pairs = turned.iter().zip(&plain);
    pairs.map(|(turned, plain)| quat(turned.quat) * (quat(plain.quat) * r.conj()).conj()).collect()
}

#[test]
fn a_mounted_sensor_gives_the_mounted_attitude_as_claimed() {
    let mut tested = 0;
    for case in doubles() {
        let mut random = Random(32);
        for _ in 0..6 {
            let r = quat(random.rotation());
            let exact = match case.spec.equivariance {
                Equivariance::No(_) => continue,
                Equivariance::Heading => vec![],
                Equivariance::Exact => vec![BOTH],
            };
            for sensors in exact {
                for difference in differences(&case, r, sensors) {
                    let error = difference.vector().norm2().sqrt();
                    assert!(error < BOUND, "{}, mounted by {r:?}: {error:e}", case.spec.name);
                }
            }
            // Without a field, up to a constant heading.
            let heading = differences(&case, r, ACC);
            for difference in &heading {
                let tilt = difference.x.hypot(difference.y);
                let drift = (*difference * heading[0].conj()).vector().norm2().sqrt();
                assert!(tilt < BOUND && drift < BOUND, "{}, mounted by {r:?}: {tilt:e}, {drift:e}", case.spec.name);
            }
            tested += 1;
        }
    }
    assert!(tested > 0, "no filter of the registry claims a law");
}
