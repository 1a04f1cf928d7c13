//! Memory for pictures, asked for before it is used: a target that does not fit is an error
//! with advice and not the end of the process.

use hyperspan::Aligned;

use crate::failure::Failure;

/// `count` elements of `value`.
pub(crate) fn filled<T: Copy>(count: usize, value: T) -> Result<Aligned<T>, Failure> {
    let bytes = count.saturating_mul(size_of::<T>());
    Aligned::filled(value, count).map_err(|_| too_large(bytes as u64))
}

/// Is there room for `bytes` more? A system that promises memory which it does not have (and
/// ends the process that believes it) is asked what it really has.
pub(crate) fn check(bytes: u64) -> Result<(), Failure> {
    let fits = available().is_none_or(|available| bytes <= available);
    if fits { Ok(()) } else { Err(too_large(bytes)) }
}

fn too_large(bytes: u64) -> Failure {
    let mib = bytes.div_ceil(1 << 20);
    Failure::new(format!(
        "the pictures and data asked for need {mib} MiB, more than this machine has free: \
         choose a smaller --size, fewer --aov, or draw parts of the picture with --crop"
    ))
}

/// Bytes that are free, where the system says so: Linux does.
fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib.saturating_mul(1024))
}
