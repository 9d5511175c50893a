//! Which vector instructions recordings are computed with.

use std::sync::OnceLock;

use ahrs_rs::Settings;
use ahrs_rs_lanes::simd::Isa;

use crate::registry::{ENTRIES, Number};

/// The environment variable that chooses the instructions, for tests and measurements: a name of [`Isa::ALL`], or `scalar`
/// for one recording after the other.
pub const VARIABLE: &str = "AHRS_RS_ISA";

/// The value of [`VARIABLE`] without lanes.
const SCALAR: &str = "scalar";

/// The instructions that this processor has and for which the filters are compiled, the fastest last.
pub fn available() -> Vec<Isa> {
    let makes = |isa: &Isa| {
        ENTRIES.first().is_some_and(|entry| <f64 as Number>::bank(entry, *isa, &[], Settings::default()).is_some())
    };
    Isa::ALL.iter().map(|&(_, isa)| isa).filter(makes).collect()
}

/// The instructions to use: those that the environment names, else the fastest; none for one recording after the other. An error
/// says what can be named. Found once.
pub fn chosen() -> Result<Option<Isa>, String> {
    static CHOSEN: OnceLock<Result<Option<Isa>, String>> = OnceLock::new();
    CHOSEN.get_or_init(|| choose(std::env::var(VARIABLE).ok().as_deref(), &available())).clone()
}

/// [`chosen`] for a value of the variable.
fn choose(name: Option<&str>, available: &[Isa]) -> Result<Option<Isa>, String> {
    let Some(name) = name.filter(|name| !name.is_empty()) else { return Ok(available.last().copied()) };
    if name == SCALAR {
        return Ok(None);
    }
    if let Some(isa) = Isa::from_name(name).filter(|isa| available.contains(isa)) {
        return Ok(Some(isa));
    }
    let names: Vec<_> = [SCALAR].into_iter().chain(available.iter().map(|isa| isa.name())).collect();
    Err(format!("{VARIABLE}: expected one of {} on this machine and build, got {name:?}", names.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_chooses_what_there_is_and_nothing_else() {
        let both = [Isa::Portable, Isa::Avx2];
        assert_eq!(choose(None, &both), Ok(Some(Isa::Avx2)));
        assert_eq!(choose(Some(""), &both), Ok(Some(Isa::Avx2)));
        assert_eq!(choose(Some("portable"), &both), Ok(Some(Isa::Portable)));
        assert_eq!(choose(Some("scalar"), &both), Ok(None));
        assert_eq!(choose(None, &[]), Ok(None));
        let error = choose(Some("avx512"), &both);
        let expected = "AHRS_RS_ISA: expected one of scalar, portable, avx2 on this machine and build, got \"avx512\"";
        assert_eq!(error, Err(expected.to_string()));
    }
}
