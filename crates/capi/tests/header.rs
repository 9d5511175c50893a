//! `include/ahrs_rs.h` is made of the functions, by cbindgen, and of the registry. The test says whether the tracked file is
//! current; `make header` (the variable `AHRS_WRITE_HEADER`) writes it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails may panic")]

use std::fmt::Write;
use std::path::Path;

use ahrs_rs::FilterSpec;
use ahrs_rs::params::ParamKind;
use ahrs_rs_c::FILTERS;
use cbindgen::{Builder, Config, DocumentationStyle, Language};

const HEAD: &str = "/* The filters of ahrs_rs in C. Made by `make header` from crates/capi/src and the registry; do not edit.
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
";

/// Lines of a comment, broken before 110 characters; the lines after the first begin with `indent`.
fn comment(text: &str, indent: &str) -> String {
    let mut lines = String::from("\n *");
    let mut width = 2;
    for word in text.split_whitespace() {
        let letters = word.chars().count();
        if width + letters > 110 {
            write!(lines, "\n *{indent}").unwrap();
            width = 2 + indent.len();
        }
        write!(lines, " {word}").unwrap();
        width += 1 + letters;
    }
    lines
}

/// What the header says of one filter.
fn declaration(spec: &FilterSpec, size: usize) -> String {
    let name = spec.name;
    let mut text = format!("\n/**{}\n *", comment(&format!("{name}. {}", spec.doc), ""));
    text += &comment(&format!("Source: {}.", spec.source), "");
    if !spec.params.is_empty() {
        text += "\n *\n * Parameters, in this order:";
    }
    for param in spec.params {
        let kind = match param.kind {
            ParamKind::Real { unit, default, min, max } => {
                let unit = if unit.is_empty() { String::new() } else { format!("{unit}, ") };
                format!("{unit}{default:?} in [{min:?}, {max:?}]")
            }
            ParamKind::Choice { options } => {
                let options: Vec<_> = options.iter().enumerate().map(|(i, name)| format!("{i} {name}")).collect();
                options.join(", ")
            }
            ParamKind::Switch { default } => format!("0 off, 1 on; {}", u8::from(default)),
        };
        text += &comment(&format!("- {} ({kind}): {}", param.name, param.doc), "  ");
    }
    text += "\n */\n";
    writeln!(text, "extern const AhrsFilter ahrs_{name};").unwrap();
    writeln!(text, "typedef union Ahrs{name} {{\n  uint64_t aligned;\n  unsigned char bytes[{size}];\n}} Ahrs{name};")
        .unwrap();
    text
}

fn header() -> String {
    let mut filters = String::from("\n/* The filters, each with the memory for one. */\n");
    for filter in FILTERS {
        // Pointers are the largest on the machine that this runs on; a multiple of the alignment.
        filters += &declaration((filter.spec)(), filter.size.next_multiple_of(8));
    }
    let config = Config {
        language: Language::C,
        header: Some(HEAD.to_owned()),
        include_guard: Some("AHRS_RS_H".to_owned()),
        no_includes: true,
        sys_includes: vec!["stddef.h".to_owned(), "stdint.h".to_owned()],
        cpp_compat: true,
        documentation: true,
        documentation_style: DocumentationStyle::Doxy,
        usize_is_size_t: true,
        line_length: 110,
        ..Config::default()
    };
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let bindings = Builder::new()
        .with_config(config)
        .with_src(source.join("lib.rs"))
        .with_src(source.join("filter.rs"))
        .generate()
        .unwrap();
    let mut written = Vec::new();
    bindings.write(&mut written);
    let text = String::from_utf8(written).unwrap();
    // Before the end of what is for C++ compilers, so that the filters are within it.
    let end = text.rfind("#ifdef __cplusplus").unwrap();
    let (functions, rest) = text.split_at(end);
    // C programmers are not told what Rust asks of them in a heading of its own.
    let functions = functions.replace(" * # Safety\n *\n", "");
    format!("{functions}{}\n{rest}", filters.trim_start())
}

#[test]
fn the_tracked_header_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/ahrs_rs.h");
    let made = header();
    if std::env::var_os("AHRS_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    assert!(std::fs::read_to_string(&path).unwrap_or_default() == made, "run `make header`");
}
