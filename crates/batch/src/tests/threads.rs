//! Work on several threads: every item once, no more threads than there is work, a panic stays with its recording.

use std::collections::HashSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use ahrs_rs::Settings;
use ahrs_rs_lanes::stream::{Stream, Tile};
use ndarray::{Array1, Array2, s};

use super::data::recording;
use crate::isa;
use crate::lanes;
use crate::recording::{Outputs, Recording, Time};
use crate::registry::{Entry, Number, entry};
use crate::threads::{Job, Plan, Watch, contained, default_threads, in_threads, run_all, side_by_side, threads};

#[test]
fn every_item_is_done_once_on_no_more_threads_than_there_are_items() {
    for count in [1, 2, 3, 100] {
        for len in [0_usize, 1, 2, 7, 1000] {
            let mut items: Vec<_> = (0..len).map(|_| AtomicUsize::new(0)).collect();
            let seen = Mutex::new(HashSet::new());
            in_threads(count, &mut items, |item| {
                item.fetch_add(1, Ordering::Relaxed);
                seen.lock().unwrap().insert(thread::current().id());
            });
            assert!(items.iter().all(|item| item.load(Ordering::Relaxed) == 1));
            assert!(seen.lock().unwrap().len() <= count.min(len));
        }
    }
}

#[test]
fn threads_are_bounded_by_the_items_and_by_the_work_where_no_number_is_asked_for() {
    assert_eq!(threads(Some(10_000), 3, 0), 3);
    assert_eq!(threads(Some(2), 3, 0), 2);
    assert_eq!(threads(None, 1000, 0), 1);
    assert_eq!(threads(None, 1000, 1_000_000), default_threads().min(1000));
    assert_eq!(threads(None, 0, 1_000_000), 1);
}

#[test]
fn a_panic_of_a_worker_reaches_the_caller() {
    let done = AtomicUsize::new(0);
    let mut items = [0, 1, 2, 3];
    let caught = contained(|| {
        in_threads(2, &mut items, |item| {
            assert!(*item != 2, "planted");
            done.fetch_add(1, Ordering::Relaxed);
        });
    });
    assert!(caught.is_err());
}

#[test]
fn a_panic_gives_its_text() {
    assert_eq!(contained(|| 3), Ok(3));
    assert_eq!(contained(|| -> usize { panic!("planted") }), Err("planted".to_owned()));
    assert_eq!(contained(|| -> usize { panic!("planted {}", 1 + 1) }), Err("planted 2".to_owned()));
    assert_eq!(contained(|| -> usize { std::panic::panic_any(7) }), Err("without a message".to_owned()));
}

/// A filter that panics when it has come so far.
struct Failing {
    inner: Box<dyn Stream<f64>>,
    samples: usize,
}

impl Stream<f64> for Failing {
    fn start_from(&mut self, q0: [f64; 4]) {
        self.inner.start_from(q0);
    }
    fn is_fresh(&self) -> bool {
        self.inner.is_fresh()
    }
    fn update(&mut self, gyr: [f64; 3], acc: Option<[f64; 3]>, mag: Option<[f64; 3]>, dt: f64) -> u16 {
        self.inner.update(gyr, acc, mag, dt)
    }
    fn run(&mut self, tile: &mut Tile<'_, f64>) {
        self.samples = self.samples.checked_sub(tile.gyr.len()).unwrap();
        self.inner.run(tile);
    }
    fn quat(&self) -> [f64; 4] {
        self.inner.quat()
    }
    fn gyr_bias(&self) -> Option<[f64; 3]> {
        self.inner.gyr_bias()
    }
    fn bias_stays_zero(&self) -> bool {
        self.inner.bias_stays_zero()
    }
    fn output(&self, index: usize) -> Vec<f64> {
        self.inner.output(index)
    }
    fn save(&mut self) -> Vec<f64> {
        self.inner.save()
    }
    fn load(&mut self, values: &[f64]) -> bool {
        self.inner.load(values)
    }
    fn is_unit(&self) -> bool {
        self.inner.is_unit()
    }
}

type Room = (Array2<f64>, Array1<u16>);

/// The attitudes that four recordings get, or what their filters say that panic; `run` is given the jobs.
fn outcomes(
    entry: &Entry,
    samples: [usize; 4],
    run: impl FnOnce(&mut [Job<'_, f64>]),
) -> Vec<Result<Vec<u64>, String>> {
    let values: Vec<f64> = entry.spec.params.iter().map(ahrs_rs::params::ParamSpec::default).collect();
    let data: Vec<_> = (0..4).map(|seed| recording::<f64>(4 * seed + 1, 600)).collect();
    let mut rooms: Vec<Room> = data.iter().map(|_| (Array2::zeros((600, 4)), Array1::zeros(600))).collect();
    let mut jobs: Vec<_> = data
        .iter()
        .zip(&mut rooms)
        .zip(samples)
        .map(|((data, (quat, status)), samples)| Job {
            stream: Box::new(Failing { inner: f64::stream(entry, &values, Settings::default()).unwrap(), samples })
                as Box<dyn Stream<f64>>,
            recording: Recording {
                gyr: data.gyr.view(),
                acc: data.acc.as_ref().map(|acc| acc.view()),
                mag: None,
                time: Time { stamps: None, first: 0.01, step: 0.01 },
            },
            outputs: Outputs {
                quat: quat.view_mut(),
                gyr_bias: None,
                status: status.slice_mut(s![..]),
                extra: Vec::new(),
            },
            infinite: false,
            panicked: None,
        })
        .collect();
    run(&mut jobs);
    let told: Vec<_> = jobs.iter().map(|job| job.panicked.clone()).collect();
    drop(jobs);
    let bits = |(quat, _): &Room| quat.iter().map(|value| value.to_bits()).collect();
    rooms.iter().zip(told).map(|(room, told)| told.map_or_else(|| Ok(bits(room)), Err)).collect()
}

#[test]
fn a_panic_over_one_recording_leaves_all_others_as_they_are_alone() {
    let entry = entry("Mahony").unwrap();
    let values: Vec<f64> = entry.spec.params.iter().map(ahrs_rs::params::ParamSpec::default).collect();
    let plan = |threads| Plan { entry, values: &values, settings: Settings::default(), isa: None, threads };
    let whole = outcomes(entry, [1000; 4], |jobs| run_all(jobs, &plan(Some(1)), &Watch::default()));
    assert!(whole.iter().all(Result::is_ok));
    for threads in [1, 2, 4] {
        let watch = Watch::default();
        let found = outcomes(entry, [1000, 300, 1000, 10], |jobs| run_all(jobs, &plan(Some(threads)), &watch));
        assert_eq!((&found[0], &found[2]), (&whole[0], &whole[2]));
        for failed in [&found[1], &found[3]] {
            assert!(failed.as_ref().unwrap_err().contains("unwrap"));
        }
        assert_eq!(watch.count(), 4);
    }
}

#[test]
fn where_lanes_panic_each_recording_is_computed_alone_from_where_it_began() {
    let entry = entry("Mahony").unwrap();
    let values: Vec<f64> = entry.spec.params.iter().map(ahrs_rs::params::ParamSpec::default).collect();
    let plan = Plan { entry, values: &values, settings: Settings::default(), isa: None, threads: Some(1) };
    let whole = outcomes(entry, [1000; 4], |jobs| run_all(jobs, &plan, &Watch::default()));
    let isa = *isa::available().last().unwrap();
    let found = outcomes(entry, [1000, 300, 1000, 1000], |jobs| {
        let mut group: Vec<_> = jobs.iter_mut().collect();
        let watch = Watch::default();
        side_by_side(&mut group, &watch, |group| {
            // All of it is computed, and the streams have gone on, when it panics.
            let mut bank = f64::bank(entry, isa, &[values.as_slice()], Settings::default()).unwrap().unwrap();
            lanes::run(bank.as_mut(), group, &watch);
            panic!("planted");
        });
    });
    for index in [0, 2, 3] {
        assert_eq!(found[index], whole[index]);
    }
    assert!(found[1].is_err());
}
