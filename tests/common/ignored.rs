//! Whether a signal can be tested: not where the tests themselves were started with it ignored.

/// Whether this process, and so what it starts, ignores a signal, as SIGHUP under nohup and SIGINT in the
/// background of a shell's script. Then that is said aloud.
pub fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    let ignored = mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1);
    if ignored {
        println!("signal {signal} is not tested: it is ignored here");
    }
    ignored
}
