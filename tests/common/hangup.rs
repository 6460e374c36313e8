//! Whether a hang-up can be tested: not where the tests themselves were started with it ignored.

/// Whether this process, and so what it starts, ignores SIGHUP (the first signal of the mask), as under
/// nohup. Then that is said aloud.
pub fn is_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    let ignored = mask.is_some_and(|mask| mask & 1 == 1);
    if ignored {
        println!("SIGHUP is not tested: it is ignored here, as under nohup");
    }
    ignored
}
