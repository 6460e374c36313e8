//! How much memory a process may still take: of the machine, of the control groups that a container or
//! a batch job is in, and of what the shell's `ulimit` leaves.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Whose memory it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MemoryBound {
    /// The machine's.
    Machine,
    /// That of a control group.
    Group,
    /// The address space that `ulimit -v` allows.
    AddressSpace,
    /// The data that `ulimit -d` allows.
    Data,
}

impl MemoryBound {
    /// By what factor the free memory must exceed a run's fields and matrices. Beyond `ulimit` the program
    /// is ended at once, and blocks that were freed and not yet given back count: case 3, clamped, at 100
    /// cells needs 111 MB and was ended with 117 left, not with 127.
    pub(super) fn margin(self) -> f64 {
        match self {
            Self::Machine | Self::Group => 1.0,
            Self::AddressSpace | Self::Data => 1.2,
        }
    }
}

impl fmt::Display for MemoryBound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Machine => "of memory are free",
            Self::Group => "are left of the memory that the container or the job may take",
            Self::AddressSpace => "are left of the address space that ulimit -v allows",
            Self::Data => "are left of the data that ulimit -d allows",
        })
    }
}

/// Memory that is available.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FreeMemory {
    /// How much.
    pub bytes: u64,
    /// By which bound.
    pub bound: MemoryBound,
}

/// The memory that is available at present, by the narrowest bound. `None` where the system does not
/// report it.
pub fn free_memory() -> Option<FreeMemory> {
    let memory = MemoryRefreshKind::nothing().with_ram();
    let of_machine = System::new_with_specifics(RefreshKind::nothing().with_memory(memory))
        .ok()
        .map(|system| system.available_memory())
        .filter(|bytes| *bytes > 0)
        .map(|bytes| FreeMemory {
            bytes,
            bound: MemoryBound::Machine,
        });
    narrowest(of_machine, Path::new("/"))
}

/// By the narrowest bound, of the machine and of those in the files below `root`.
fn narrowest(of_machine: Option<FreeMemory>, root: &Path) -> Option<FreeMemory> {
    of_machine
        .into_iter()
        .chain(bounds(root))
        .min_by_key(|free| free.bytes)
}

/// The bounds that Linux reports in files below `root`: none elsewhere.
fn bounds(root: &Path) -> impl Iterator<Item = FreeMemory> {
    let free = |bound| move |bytes| FreeMemory { bytes, bound };
    let groups = groups(root).into_iter().map(free(MemoryBound::Group));
    let [space, data] = limits(root);
    groups
        .chain(space.map(free(MemoryBound::AddressSpace)))
        .chain(data.map(free(MemoryBound::Data)))
}

/// The files of a version of control groups.
struct Files {
    /// Where groups are, below the root.
    mount: &'static str,
    limit: &'static str,
    usage: &'static str,
    /// What memory.stat calls the cache of files, of the group and of those in it.
    cache: [&'static str; 2],
}

const VERSION_2: Files = Files {
    mount: "sys/fs/cgroup",
    limit: "memory.max",
    usage: "memory.current",
    cache: ["inactive_file", "active_file"],
};

const VERSION_1: Files = Files {
    mount: "sys/fs/cgroup/memory",
    limit: "memory.limit_in_bytes",
    usage: "memory.usage_in_bytes",
    cache: ["total_inactive_file", "total_active_file"],
};

/// What each control group of the process may still take, if it is bounded.
fn groups(root: &Path) -> Vec<u64> {
    let own = fs::read_to_string(root.join("proc/self/cgroup")).unwrap_or_default();
    let mut free = Vec::new();
    for line in own.lines() {
        // "0::/path" of version 2, "4:memory:/path" of version 1.
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else {
            continue;
        };
        let files = match controllers {
            "" => VERSION_2,
            _ if controllers.split(',').any(|name| name == "memory") => VERSION_1,
            _ => continue,
        };
        let mount = root.join(files.mount);
        // In a container the path may be that outside it, of which nothing is seen.
        let path: PathBuf = mount.join(path.trim_start_matches('/'));
        let inner = if path.is_dir() { &path } else { &mount };
        let all = inner.ancestors().take_while(|it| it.starts_with(&mount));
        free.extend(all.filter_map(|group| free_of_group(group, &files)));
    }
    free
}

/// What is left of a group's limit, the cache of files counting as free: the system drops it when memory
/// is asked for.
fn free_of_group(group: &Path, files: &Files) -> Option<u64> {
    let number = |name: &str| {
        let text = fs::read_to_string(group.join(name)).ok()?;
        text.trim().parse::<u64>().ok()
    };
    // "max" where there is none.
    let limit = number(files.limit)?;
    let usage = number(files.usage)?;
    let stat = fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let cache: u64 = stat
        .lines()
        .filter_map(|line| line.split_once(' '))
        .filter(|(name, _)| files.cache.contains(name))
        .filter_map(|(_, bytes)| bytes.trim().parse::<u64>().ok())
        .sum();
    Some(limit.saturating_sub(usage.saturating_sub(cache)))
}

/// What is left of the address space and of the data that the process may have, where that is bounded.
fn limits(root: &Path) -> [Option<u64>; 2] {
    let read = |name: &str| fs::read_to_string(root.join("proc/self").join(name));
    let limits = read("limits").unwrap_or_default();
    let status = read("status").unwrap_or_default();
    [
        ("Max address space", "VmSize:"),
        ("Max data size", "VmData:"),
    ]
    .map(|(limit, usage)| {
        // The soft one; "unlimited" is not a number.
        let limit = after(&limits, limit)?.parse::<u64>().ok()?;
        let used = after(&status, usage)?.parse::<u64>().ok()?;
        Some(limit.saturating_sub(1024 * used))
    })
}

/// The word behind these at the beginning of a line.
fn after<'a>(text: &'a str, begin: &str) -> Option<&'a str> {
    text.lines()
        .find_map(|line| line.strip_prefix(begin))?
        .split_whitespace()
        .next()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tree of files with these contents.
    fn tree(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a folder");
        for (path, text) in files {
            let path = root.path().join(path);
            let folder = path.parent().expect("a file's path");
            fs::create_dir_all(folder).expect("a folder");
            fs::write(path, text).expect("a file");
        }
        root
    }

    fn found(files: &[(&str, &str)]) -> Vec<FreeMemory> {
        bounds(tree(files).path()).collect()
    }

    fn group(bytes: u64) -> FreeMemory {
        let bound = MemoryBound::Group;
        FreeMemory { bytes, bound }
    }

    #[test]
    fn the_cache_of_files_counts_as_free() {
        // 4 GB, of which 3.9 are taken, 3.8 of them by the cache; version 2 in a container.
        let stat = "anon 100000000\nfile 3800000000\nkernel 1\ninactive_file 3000000000\n\
                    active_file 800000000\nunevictable 0\n";
        let two = [
            ("proc/self/cgroup", "0::/\n"),
            ("sys/fs/cgroup/memory.max", "4000000000\n"),
            ("sys/fs/cgroup/memory.current", "3900000000\n"),
            ("sys/fs/cgroup/memory.stat", stat),
        ];
        assert_eq!(found(&two), [group(3_900_000_000)]);
        let stat = "cache 3\ninactive_file 7\ntotal_inactive_file 3000000000\n\
                    total_active_file 800000000\ntotal_rss 100000000\n";
        let one = [
            (
                "proc/self/cgroup",
                "5:cpu,cpuacct:/docker/af\n4:memory:/docker/af\n0::/\n",
            ),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "4000000000\n"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "3900000000\n"),
            ("sys/fs/cgroup/memory/memory.stat", stat),
        ];
        assert_eq!(found(&one), [group(3_900_000_000)]);
    }

    #[test]
    fn every_group_about_the_process_counts() {
        let files = [
            ("proc/self/cgroup", "0::/user.slice/job\n"),
            ("sys/fs/cgroup/user.slice/memory.max", "1000\n"),
            ("sys/fs/cgroup/user.slice/memory.current", "900\n"),
            ("sys/fs/cgroup/user.slice/memory.stat", "active_file 50\n"),
            ("sys/fs/cgroup/user.slice/job/memory.max", "max\n"),
            ("sys/fs/cgroup/user.slice/job/memory.current", "900\n"),
        ];
        assert_eq!(found(&files), [group(150)]);
        // More cache than is used, and more used than is allowed, as files are read one by one.
        let odd = [
            ("proc/self/cgroup", "0::/\n"),
            ("sys/fs/cgroup/memory.max", "1000\n"),
            ("sys/fs/cgroup/memory.current", "900\n"),
            ("sys/fs/cgroup/memory.stat", "active_file 1000\n"),
        ];
        assert_eq!(found(&odd), [group(1000)]);
        let over = [odd[0], odd[1], ("sys/fs/cgroup/memory.current", "1200\n")];
        assert_eq!(found(&over), [group(0)]);
        assert_eq!(found(&[]), []);
    }

    #[test]
    fn what_ulimit_allows_counts_less_what_is_in_use() {
        let limits = "Limit  Soft Limit  Hard Limit  Units\n\
                      Max data size             unlimited            unlimited            bytes\n\
                      Max address space         1536000000           unlimited            bytes\n";
        let status =
            "Name:\tvesica\nVmPeak:\t  900000 kB\nVmSize:\t  500000 kB\nVmData:\t  100000 kB\n";
        let free = found(&[("proc/self/limits", limits), ("proc/self/status", status)]);
        let bound = MemoryBound::AddressSpace;
        let bytes = 1_024_000_000;
        assert_eq!(free, [FreeMemory { bytes, bound }]);
    }

    /// Version 1 where the group is seen, as outside of a container: it and those about it, by the names that
    /// this version has.
    #[test]
    fn groups_of_version_1_are_followed_to_the_root() {
        let folder = "sys/fs/cgroup/memory/batch/job";
        let in_job = |file: &str| format!("{folder}/{file}");
        let files = [
            ("proc/self/cgroup".to_owned(), "4:cpu,memory:/batch/job\n"),
            (in_job("memory.limit_in_bytes"), "5000\n"),
            (in_job("memory.usage_in_bytes"), "4000\n"),
            // Not those of version 2, nor what a child of the group has alone.
            (in_job("memory.max"), "1\n"),
            (
                in_job("memory.stat"),
                "active_file 900\ntotal_active_file 20\n",
            ),
            (
                "sys/fs/cgroup/memory/batch/memory.limit_in_bytes".to_owned(),
                "9000\n",
            ),
            (
                "sys/fs/cgroup/memory/batch/memory.usage_in_bytes".to_owned(),
                "8999\n",
            ),
        ];
        let files = files.each_ref().map(|(path, text)| (path.as_str(), *text));
        assert_eq!(found(&files), [group(1020), group(1)]);
    }

    #[test]
    fn the_narrowest_bound_counts() {
        let root = tree(&[
            ("proc/self/cgroup", "0::/\n"),
            ("sys/fs/cgroup/memory.max", "4000\n"),
            ("sys/fs/cgroup/memory.current", "1000\n"),
            (
                "proc/self/limits",
                "Max data size 1030000 unlimited bytes\nMax address space 1040000 unlimited bytes\n",
            ),
            ("proc/self/status", "VmSize: 1000 kB\nVmData: 1000 kB\n"),
        ]);
        let machine = |bytes| {
            let bound = MemoryBound::Machine;
            Some(FreeMemory { bytes, bound })
        };
        assert_eq!(narrowest(machine(2999), root.path()), machine(2999));
        assert_eq!(narrowest(machine(3001), root.path()), Some(group(3000)));
        assert_eq!(narrowest(None, root.path()), Some(group(3000)));
        let limits = bounds(root.path()).skip(1).collect::<Vec<_>>();
        let left = |bytes, bound| FreeMemory { bytes, bound };
        assert_eq!(
            limits,
            [
                left(16_000, MemoryBound::AddressSpace),
                left(6_000, MemoryBound::Data)
            ]
        );
        let empty = tree(&[]);
        assert_eq!(narrowest(machine(7), empty.path()), machine(7));
        assert_eq!(narrowest(None, empty.path()), None);
    }

    #[test]
    fn the_system_tells_of_some_memory() {
        let free = free_memory();
        if cfg!(any(target_os = "linux", target_os = "macos")) {
            assert!(free.is_some());
        }
        assert!(free.is_none_or(|free| free.bytes > 1 << 20), "{free:?}");
    }
}
