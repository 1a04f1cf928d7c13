//! The instruction set that rungs and product run on.

use fearless_simd::Level;
use hyperspan::simd::Simd;

/// An instruction set of this machine.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Machine {
    /// Not `auto`, but what that came to.
    pub(crate) name: &'static str,
    /// As the product calls it.
    pub(crate) simd: Simd,
    /// As the rungs do.
    pub(crate) level: Level,
}

/// Reads `--simd`.
pub(crate) fn machine(text: &str) -> Result<Machine, String> {
    // From the narrowest to the widest.
    let all: Vec<Machine> = Simd::all()
        .filter_map(|(name, simd)| Some(Machine { name, simd, level: level(name)? }))
        .collect();
    let found = if text == "auto" { all.last() } else { all.iter().find(|m| m.name == text) };
    found.copied().ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|machine| machine.name).collect();
        format!("this machine has auto, {}", names.join(", "))
    })
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn level(name: &str) -> Option<Level> {
    use fearless_simd::Simd as Lanes;
    let best = Level::new();
    match name {
        "scalar" => Some(Level::baseline()),
        "sse2" => best.as_sse2().map(Lanes::level),
        "sse4.2" => best.as_sse4_2().map(Lanes::level),
        "avx2" => best.as_avx2().map(Lanes::level),
        "avx512" => best.as_avx512().map(Lanes::level),
        _ => None,
    }
}

/// There are two elsewhere: what the target always has, and the widest.
#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn level(name: &str) -> Option<Level> {
    Some(if name == "scalar" { Level::baseline() } else { Level::new() })
}
