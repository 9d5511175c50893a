//! The table from which parameters reach constructors, command line and docs: it is complete and means what it says.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails may panic")]
#![allow(clippy::float_cmp, reason = "defaults are compared with themselves")]
#![allow(clippy::cast_precision_loss, reason = "indices are small")]

use std::collections::HashSet;
use std::fmt::Debug;

use ahrs_rs::filters::SPECS;
use ahrs_rs::params::{ParamKind, ParamSet, ParamSpec};
use ahrs_rs::{Filter, FilterSpec, Frame, GyrHold, Scalar};

/// What `from_values` says to values of one filter: how the parameters print, or the error's text.
type Read = fn(&[f64]) -> Result<String, String>;

/// A filter with what reads its parameters and how its defaults print, for one scalar.
struct Readable {
    spec: &'static FilterSpec,
    read: Read,
    default: String,
}

fn readable<S: Scalar, F: Filter<S>>() -> Readable
where
    F::Params: Debug + Default,
{
    Readable {
        spec: F::SPEC,
        read: |values| F::Params::from_values(values).map(|p| format!("{p:?}")).map_err(|error| error.to_string()),
        default: format!("{:?}", F::Params::default()),
    }
}

macro_rules! all {
    ($($filter:path),+) => {
        fn all() -> Vec<Readable> {
            let mut all = Vec::new();
            $({
                use $filter as F;
                all.extend([readable::<f64, F<f64>>(), readable::<f32, F<f32>>()]);
            })+
            assert!(!all.is_empty(), "the registry is empty");
            all
        }
    };
}
ahrs_rs::for_each_filter!(all);

fn defaults(spec: &FilterSpec) -> Vec<f64> {
    spec.params.iter().map(ParamSpec::default).collect()
}

/// The values with one of them replaced.
fn with(mut values: Vec<f64>, index: usize, value: f64) -> Vec<f64> {
    values.splice(index..=index, [value]);
    values
}

#[track_caller]
fn assert_unique<'a>(what: &str, names: impl Iterator<Item = &'a str>) {
    let mut seen = HashSet::new();
    for name in names {
        assert!(!name.trim().is_empty(), "a name of {what} is empty");
        assert!(seen.insert(name), "{what}: {name} is there twice");
    }
}

#[test]
fn names_are_unique() {
    assert_unique("the registry", SPECS.iter().map(|spec| spec.name));
    assert_unique("the frames", Frame::ALL.iter().map(|&(name, _)| name));
    assert_unique("the holds", GyrHold::ALL.iter().map(|&(name, _)| name));
    for spec in SPECS {
        assert_unique(spec.name, spec.params.iter().map(|param| param.name));
        assert_unique(spec.name, spec.presets.iter().map(|preset| preset.name));
        assert_unique(spec.name, spec.outputs.iter().map(|output| output.name));
        for param in spec.params {
            if let ParamKind::Choice { options } = param.kind {
                assert_unique(param.name, options.iter().copied());
            }
        }
    }
}

#[test]
fn the_registry_and_its_macro_list_the_same_filters() {
    let from_macro: Vec<_> = all().iter().step_by(2).map(|readable| readable.spec.name).collect();
    let from_table: Vec<_> = SPECS.iter().map(|spec| spec.name).collect();
    assert_eq!(from_macro, from_table);
}

#[test]
fn everything_is_documented() {
    for spec in SPECS {
        for text in [spec.doc, spec.source] {
            assert!(text.len() > 10, "{}: {text:?} says nothing", spec.name);
        }
        for param in spec.params {
            assert!(param.doc.trim().len() > 10, "{}.{}: {:?} says nothing", spec.name, param.name, param.doc);
        }
        for output in spec.outputs {
            assert!(output.doc.len() > 10 && !output.is_empty(), "{}.{}", spec.name, output.name);
        }
        if let ahrs_rs::filter::Equivariance::No(reason) = spec.equivariance {
            assert!(reason.len() > 10, "{}: a law that does not hold has a reason", spec.name);
        }
    }
}

#[test]
fn defaults_are_allowed_and_ranges_are_ranges() {
    for spec in SPECS {
        for param in spec.params {
            assert!(param.check(param.default()).is_ok(), "{}.{}", spec.name, param.name);
            match param.kind {
                ParamKind::Real { default, min, max, .. } => {
                    assert!(min.is_finite() && max.is_finite() && min < max, "{}.{}", spec.name, param.name);
                    assert!(min <= default && default <= max);
                }
                ParamKind::Choice { options } => assert!(options.len() > 1, "{}.{}", spec.name, param.name),
                ParamKind::Switch { default } => assert_eq!(param.default() > 0.5, default),
            }
        }
    }
}

#[test]
fn presets_set_parameters_that_there_are_to_values_that_they_take() {
    for readable in all() {
        for preset in readable.spec.presets {
            assert_unique(preset.name, preset.values.iter().map(|&(name, _)| name));
            let mut values = defaults(readable.spec);
            for &(name, value) in preset.values {
                let index = readable.spec.params.iter().position(|param| param.name == name);
                values = with(values, index.unwrap_or_else(|| panic!("{}: no {name}", preset.name)), value);
            }
            assert!((readable.read)(&values).is_ok(), "{} of {}", preset.name, readable.spec.name);
        }
    }
}

#[test]
fn no_values_and_missing_values_are_the_defaults() {
    for readable in all() {
        let defaults = defaults(readable.spec);
        for given in 0..=defaults.len() {
            let values: Vec<_> = defaults.iter().copied().take(given).collect();
            assert_eq!((readable.read)(&values).unwrap(), readable.default, "{}, {given} given", readable.spec.name);
        }
    }
}

#[test]
fn each_value_reaches_the_parameter_of_its_name() {
    for readable in all() {
        for (index, param) in readable.spec.params.iter().enumerate() {
            let print = |value| (readable.read)(&with(defaults(readable.spec), index, value)).unwrap();
            match param.kind {
                ParamKind::Real { min, max, .. } => {
                    // A value with few bits, so that it prints alike in f32 and f64.
                    let value = [0.5, 2.0, 0.0].into_iter().find(|&value| min <= value && value <= max).unwrap();
                    let expected = format!("{}: {value:?}", param.name);
                    assert!(print(value).contains(&expected), "{}: {}", expected, print(value));
                }
                ParamKind::Choice { options } => {
                    let printed: HashSet<_> = (0..options.len()).map(|option| print(option as f64)).collect();
                    assert_eq!(printed.len(), options.len(), "{}: every option is another", param.name);
                    assert!(printed.iter().all(|text| text.contains(&format!("{}: ", param.name))));
                }
                ParamKind::Switch { .. } => {
                    for (value, name) in [(0.0, "false"), (1.0, "true")] {
                        assert!(print(value).contains(&format!("{}: {name}", param.name)), "{}", print(value));
                    }
                }
            }
        }
    }
}

#[test]
fn the_ends_of_a_range_are_allowed_and_what_is_beyond_is_refused_by_name() {
    for readable in all() {
        for (index, param) in readable.spec.params.iter().enumerate() {
            let read = |value| (readable.read)(&with(defaults(readable.spec), index, value));
            let (allowed, mut refused) = match param.kind {
                ParamKind::Real { min, max, .. } => (vec![min, max], vec![min.next_down(), max.next_up()]),
                ParamKind::Choice { options } => {
                    let last = options.len() as f64 - 1.0;
                    ((0..options.len()).map(|option| option as f64).collect(), vec![last + 1.0, -1.0, 0.5, 1e300])
                }
                ParamKind::Switch { .. } => (vec![0.0, 1.0], vec![2.0, -1.0, 0.5]),
            };
            refused.extend([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
            for value in allowed {
                assert!(read(value).is_ok(), "{}.{} refuses {value}", readable.spec.name, param.name);
            }
            for value in refused {
                let error = read(value).unwrap_err();
                assert!(error.starts_with(param.name), "{error:?} does not name {}", param.name);
                assert!(error.contains(&format!("{value}")), "{error:?} does not say what came: {value}");
            }
        }
    }
}
