//! Memory limits of Linux control groups: a container or a batch job may have far less memory than its machine.
//!
//! The limits of a group and of all groups above it apply. File cache counted as usage can be reclaimed.

use std::path::{Path, PathBuf};

/// Returns the least memory that any group of the process has left, in bytes. `groups` is the content of
/// `/proc/self/cgroup`, `root` the mount point of the groups; both versions are supported. None if there is no limit.
pub fn free(groups: &str, root: &Path) -> Option<u64> {
    groups.lines().filter_map(|line| group(line, root)).min()
}

/// Returns the memory left in the group of one line: `0::/path` (version 2), or `7:memory:/path`.
fn group(line: &str, root: &Path) -> Option<u64> {
    let mut fields = line.splitn(3, ':');
    let (_, controllers, path) = (fields.next()?, fields.next()?, fields.next()?);
    let (mount, names) = if controllers.is_empty() {
        (root.to_path_buf(), ["memory.max", "memory.current", "inactive_file"])
    } else if controllers.split(',').any(|name| name == "memory") {
        (root.join("memory"), ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"])
    } else {
        return None;
    };
    let own: PathBuf = mount.join(path.trim_start_matches('/'));
    own.ancestors().take_while(|at| at.starts_with(&mount)).filter_map(|at| left(at, names)).min()
}

fn left(group: &Path, [limit, usage, cache]: [&str; 3]) -> Option<u64> {
    let text = |name: &str| std::fs::read_to_string(group.join(name)).ok();
    let number = |name: &str| text(name)?.trim().parse::<u64>().ok();
    let stat = text("memory.stat").unwrap_or_default();
    let cached = stat.lines().find_map(|line| line.strip_prefix(cache)?.trim().parse::<u64>().ok());
    // Version 1 stores a number near 2^63 for no limit.
    let limit = number(limit).filter(|limit| *limit < 1 << 60)?;
    Some(limit.saturating_sub(number(usage)?.saturating_sub(cached.unwrap_or(0))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn write(folder: &Path, files: &[(&str, &str)]) {
        for (name, text) in files {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
    }

    #[test]
    fn the_tightest_group_counts_and_cache_is_free() {
        let root = tempfile::tempdir().unwrap();
        write(
            root.path(),
            &[
                ("a/memory.max", "1000\n"),
                ("a/memory.current", "900\n"),
                ("a/memory.stat", "anon 500\ninactive_file 300\n"),
                ("a/b/memory.max", "max\n"),
                ("a/b/memory.current", "100\n"),
            ],
        );
        assert_eq!(free("0::/a/b\n", root.path()), Some(400));
        assert_eq!(free("0::/\n", root.path()), None);
        assert_eq!(free("0::/elsewhere/gone\n", root.path()), None);
    }

    #[test]
    fn version_1_is_known() {
        let root = tempfile::tempdir().unwrap();
        write(
            root.path(),
            &[
                ("memory/job/memory.limit_in_bytes", "5000\n"),
                ("memory/job/memory.usage_in_bytes", "2000\n"),
                ("memory/job/memory.stat", "inactive_file 1\ntotal_inactive_file 500\n"),
                ("memory/memory.limit_in_bytes", "9223372036854771712\n"),
                ("memory/memory.usage_in_bytes", "8000\n"),
            ],
        );
        assert_eq!(free("5:cpu,cpuacct:/job\n4:memory:/job\n", root.path()), Some(3500));
        assert_eq!(free("5:cpu:/job\nnonsense\n", root.path()), None);
    }
}
