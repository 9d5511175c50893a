//! Parameters of filters: each is documented once, where it is declared, and that text reaches constructors, stubs,
//! the command line and the docs.

use core::fmt;

use crate::scalar::{Mask, Scalar};

/// One parameter of a filter.
#[derive(Clone, Copy, Debug)]
pub struct ParamSpec {
    /// The keyword.
    pub name: &'static str,
    /// Meaning and source.
    pub doc: &'static str,
    /// What values it takes.
    pub kind: ParamKind,
}

/// What values a parameter takes.
#[derive(Clone, Copy, Debug)]
pub enum ParamKind {
    /// A number.
    Real {
        /// SI unit.
        unit: &'static str,
        /// The value where none is given.
        default: f64,
        /// The smallest value allowed.
        min: f64,
        /// The largest value allowed.
        max: f64,
    },
    /// One of several names; the first is the default. In a list of values it is the name's index.
    Choice {
        /// The names.
        options: &'static [&'static str],
    },
    /// On or off. In a list of values it is 1 or 0.
    Switch {
        /// Where none is given.
        default: bool,
    },
}

impl ParamSpec {
    /// The value where none is given.
    pub fn default(&self) -> f64 {
        match self.kind {
            ParamKind::Real { default, .. } => default,
            ParamKind::Choice { .. } => 0.0,
            ParamKind::Switch { default } => f64::from(u8::from(default)),
        }
    }

    /// The value if it is allowed.
    pub fn check(&'static self, value: f64) -> Result<f64, ParamError> {
        let allowed = match self.kind {
            ParamKind::Real { min, max, .. } => value >= min && value <= max,
            ParamKind::Choice { options } => (0..options.len()).any(|index| is_index(index, value)),
            ParamKind::Switch { .. } => is_index(0, value) || is_index(1, value),
        };
        if allowed { Ok(value) } else { Err(ParamError { spec: self, value }) }
    }
}

/// A value that its parameter does not take.
#[derive(Clone, Copy, Debug)]
pub struct ParamError {
    /// The parameter.
    pub spec: &'static ParamSpec,
    /// What came.
    pub value: f64,
}

impl fmt::Display for ParamError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.spec.name;
        match self.spec.kind {
            ParamKind::Real { unit, min, max, .. } => {
                let space = if unit.is_empty() { "" } else { " " };
                write!(f, "{name} must be in [{min}, {max}]{space}{unit}, got {}", self.value)
            }
            ParamKind::Choice { options } => {
                write!(f, "{name} must be the index of one of {options:?}, got {}", self.value)
            }
            ParamKind::Switch { .. } => write!(f, "{name} must be 0 (off) or 1 (on), got {}", self.value),
        }
    }
}

impl core::error::Error for ParamError {}

/// A choice between names, declared with [`choice!`](crate::choice).
pub trait Choice: Copy + Default {
    /// What the choice is about.
    const DOC: &'static str;
    /// The names, the default first.
    const OPTIONS: &'static [&'static str];
    /// Every choice, in the order of the names.
    fn every() -> impl IntoIterator<Item = Self>;
    /// The choice of an index into [`Choice::OPTIONS`]; the default beyond the last.
    fn from_value(value: f64) -> Self;
}

/// The parameters of one filter, declared with [`params!`](crate::params).
pub trait ParamSet<S>: Clone {
    /// Reads values in the order of the filter's [`ParamSpec`]s; missing ones are the defaults.
    fn from_values(values: &[f64]) -> Result<Self, ParamError>;
    /// Reads a list of values for each lane; lanes beyond the last have those of the first. Choices are those of the first.
    fn from_lanes(sets: &[&[f64]]) -> Result<Self, ParamError>;
    /// Sets parameter `index`, in every lane; false where there is none, or where it does not take the value. Computed in the
    /// scalar alone: a microcontroller has no unit for `f64`.
    fn set(&mut self, index: usize, value: S) -> bool;
}

/// The value of parameter `index` in a list of values, or its default.
pub fn value(specs: &'static [ParamSpec], index: usize, values: &[f64]) -> Result<f64, ParamError> {
    match (specs.get(index), values.get(index)) {
        (Some(spec), Some(&value)) => spec.check(value),
        (Some(spec), None) => Ok(spec.default()),
        (None, _) => Ok(0.0),
    }
}

/// True where the value is exactly the index.
pub fn is_index(index: usize, value: f64) -> bool {
    value - index as f64 == 0.0
}

/// Replaces a parameter by a value in its range; false where it is not in it.
pub fn set_real<S: Scalar>(parameter: &mut S, value: S, min: S, max: S) -> bool {
    let allowed = (min.le(value) & value.le(max)).all();
    if allowed {
        *parameter = value;
    }
    allowed
}

/// Replaces a choice, or a switch, by the one of `options` whose index is the value; false where there is none.
pub fn set_option<S: Scalar, T>(parameter: &mut T, value: S, options: impl IntoIterator<Item = T>) -> bool {
    let mut index = S::zero();
    for option in options {
        if (value.le(index) & index.le(value)).all() {
            *parameter = option;
            return true;
        }
        index = index + S::one();
    }
    false
}

/// Rounds a value to the scalar.
pub fn real<S: Scalar>(value: f64) -> S {
    S::of(value)
}

/// Declares an enum of named choices; the first is the default.
#[macro_export]
macro_rules! choice {
    ($(#[doc = $doc:literal])+ pub enum $name:ident { $first:ident = $first_text:literal $(, $more:ident = $text:literal)* $(,)? }) => {
        $(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum $name {
            #[default]
            #[doc = concat!("`", $first_text, "`")]
            $first,
            $(#[doc = concat!("`", $text, "`")] $more),*
        }
        impl $crate::params::Choice for $name {
            const DOC: &'static str = concat!($($doc),+);
            const OPTIONS: &'static [&'static str] = &[$first_text $(, $text)*];
            fn every() -> impl IntoIterator<Item = Self> {
                [$name::$first $(, $name::$more)*]
            }
            fn from_value(value: f64) -> Self {
                let chosen = Self::every().into_iter().enumerate().find(|&(index, _)| $crate::params::is_index(index, value));
                chosen.map_or_else(Self::default, |(_, choice)| choice)
            }
        }
    };
}

/// Declares the parameters of a filter: a struct `Params<S>` and the table `PARAMS` that describes it.
#[macro_export]
macro_rules! params {
    ($(
        $(#[doc = $doc:literal])*
        $kind:ident $name:ident : $what:tt $(= $default:literal $(in [$min:expr, $max:expr])?)?
    );* $(;)?) => {
        /// The filter's parameters; [`PARAMS`] says what each is.
        pub struct Params<S> {
            $($(#[doc = $doc])* #[doc = concat!(" (`", stringify!($name), "`)")] pub $name: $crate::params!(@type S $kind $what),)*
            /// Keeps the scalar's type where no parameter is a number.
            pub scalar: core::marker::PhantomData<S>,
        }
        /// What each parameter is, in the order of a list of values.
        pub const PARAMS: &[$crate::params::ParamSpec] = &[
            $($crate::params::ParamSpec {
                name: stringify!($name),
                doc: $crate::params!(@doc $kind $what $($doc)*),
                kind: $crate::params!(@kind $kind $what $($default $(, $min, $max)?)?),
            },)*
        ];
        // By hand, because the types of the fields come from a macro, and derive takes none.
        impl<S: Clone> Clone for Params<S> {
            fn clone(&self) -> Self {
                Params { $($name: self.$name.clone(),)* scalar: core::marker::PhantomData }
            }
        }
        impl<S: core::fmt::Debug> core::fmt::Debug for Params<S> {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.debug_struct("Params")$(.field(stringify!($name), &self.$name))*.finish_non_exhaustive()
            }
        }
        impl<S: $crate::Scalar> Default for Params<S> {
            fn default() -> Self {
                Params {
                    $($name: $crate::params!(@default S $kind $what $($default)?),)*
                    scalar: core::marker::PhantomData,
                }
            }
        }
        impl<S: $crate::Scalar> $crate::params::ParamSet<S> for Params<S> {
            fn from_values(values: &[f64]) -> Result<Self, $crate::params::ParamError> {
                let mut index = 0..;
                $(
                    let $name = $crate::params::value(PARAMS, index.next().unwrap_or(0), values)?;
                )*
                let _ = (&mut index, values);
                Ok(Params { $($name: $crate::params!(@read S $kind $what $name),)* scalar: core::marker::PhantomData })
            }
            fn from_lanes(sets: &[&[f64]]) -> Result<Self, $crate::params::ParamError> {
                let all: Self = Self::from_values(sets.first().copied().unwrap_or_default())?;
                #[allow(unused_mut, reason = "where no parameter is a number")]
                let mut all = all;
                for (lane, values) in sets.iter().enumerate().skip(1) {
                    let one: Self = Self::from_values(values)?;
                    $($crate::params!(@lane $kind all one lane $name);)*
                    let _ = (lane, one);
                }
                Ok(all)
            }
            fn set(&mut self, index: usize, value: S) -> bool {
                let mut indices = 0..;
                $(
                    if indices.next() == Some(index) {
                        return $crate::params!(@set S self value $kind $name $what $($default $(, $min, $max)?)?);
                    }
                )*
                let _ = (&mut indices, index, value);
                false
            }
        }
    };
    (@set $s:ident $self:ident $value:ident real $name:ident $unit:tt $default:literal, $min:expr, $max:expr) => {
        $crate::params::set_real(&mut $self.$name, $value, <$s as $crate::Scalar>::of($min), <$s as $crate::Scalar>::of($max))
    };
    (@set $s:ident $self:ident $value:ident choice $name:ident $choice:tt) => {
        $crate::params::set_option(&mut $self.$name, $value, <$choice as $crate::params::Choice>::every())
    };
    (@set $s:ident $self:ident $value:ident switch $name:ident $bool:tt $default:literal) => {
        $crate::params::set_option(&mut $self.$name, $value, [false, true])
    };
    (@lane real $all:ident $one:ident $lane:ident $name:ident) => {
        $crate::Scalar::set_lane(&mut $all.$name, $lane, $crate::Scalar::lane($one.$name, $lane))
    };
    (@lane choice $all:ident $one:ident $lane:ident $name:ident) => {};
    (@lane switch $all:ident $one:ident $lane:ident $name:ident) => {};
    (@type $s:ident real $unit:tt) => { $s };
    (@type $s:ident choice $choice:tt) => { $choice };
    (@type $s:ident switch $bool:tt) => { bool };
    (@doc real $unit:tt $($doc:literal)*) => { concat!($($doc),*) };
    (@doc choice $choice:tt) => { <$choice as $crate::params::Choice>::DOC };
    (@doc switch $bool:tt $($doc:literal)*) => { concat!($($doc),*) };
    (@kind real $unit:tt $default:literal, $min:expr, $max:expr) => {
        $crate::params::ParamKind::Real { unit: $unit, default: $default, min: $min, max: $max }
    };
    (@kind choice $choice:tt) => {
        $crate::params::ParamKind::Choice { options: <$choice as $crate::params::Choice>::OPTIONS }
    };
    (@kind switch $bool:tt $default:literal) => { $crate::params::ParamKind::Switch { default: $default } };
    (@default $s:ident real $unit:tt $default:literal) => { $crate::params::real::<$s>($default) };
    (@default $s:ident choice $choice:tt) => { <$choice as Default>::default() };
    (@default $s:ident switch $bool:tt $default:literal) => { $default };
    (@read $s:ident real $unit:tt $value:ident) => { $crate::params::real::<$s>($value) };
    (@read $s:ident choice $choice:tt $value:ident) => { <$choice as $crate::params::Choice>::from_value($value) };
    (@read $s:ident switch $bool:tt $value:ident) => { $crate::params::is_index(1, $value) };
}
