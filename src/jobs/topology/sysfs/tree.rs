//! Files of `/sys` and `/proc` below a root. Tests use another root.

use crate::topology::field;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Numbers of hardware threads or nodes, as by the system.
pub(super) type Set = BTreeSet<u32>;

/// Numbers are below this; a list with larger ones is rejected.
const LARGEST_NUMBER: u32 = 1 << 16;

/// Folder of the files of a hardware thread.
pub(super) fn of_thread(thread: u32) -> String {
    format!("sys/devices/system/cpu/cpu{thread}")
}

/// A root folder and the files below it.
#[derive(Debug, Clone)]
pub(super) struct Tree(PathBuf);

impl Tree {
    pub(super) fn new(root: &Path) -> Self {
        Self(root.to_path_buf())
    }

    pub(super) fn root(&self) -> &Path {
        &self.0
    }

    /// A file's text without surrounding white space; `None` if there is no text.
    pub(super) fn text(&self, path: &str) -> Option<String> {
        let text = fs::read_to_string(self.0.join(path)).ok()?;
        let text = text.trim();
        (!text.is_empty()).then(|| text.to_owned())
    }

    pub(super) fn number(&self, path: &str) -> Option<u64> {
        self.text(path)?.parse().ok()
    }

    pub(super) fn list(&self, path: &str) -> Option<Set> {
        list(&self.text(path)?)
    }

    pub(super) fn holds(&self, path: &str) -> bool {
        self.0.join(path).exists()
    }

    /// The threads that share a core, die or package with a thread, from the first file that has a list: newer versions
    /// of Linux use other file names. `None` if there is no list, or if it does not contain the thread itself.
    pub(super) fn siblings(&self, thread: u32, names: &[&str]) -> Option<Set> {
        let file = |name: &&str| self.list(&format!("{}/topology/{name}", of_thread(thread)));
        let found = names.iter().find_map(file)?;
        found.contains(&thread).then_some(found)
    }

    /// Threads that the calling thread is bound to.
    pub(super) fn bound(&self) -> Option<Set> {
        list(field(&self.status()?, "Cpus_allowed_list")?)
    }

    /// Nodes whose memory the control group grants.
    pub(super) fn granted_nodes(&self) -> Option<Set> {
        list(field(&self.status()?, "Mems_allowed_list")?)
    }

    fn status(&self) -> Option<String> {
        self.text("proc/thread-self/status")
            .or_else(|| self.text("proc/self/status"))
    }

    /// Threads that the control group grants, in either version of control groups. Inside a container, the
    /// files of its group are often in the root folder of the control groups.
    pub(super) fn granted_threads(&self) -> Option<Set> {
        let groups = self.text("proc/self/cgroup")?;
        let group = |controller: &str| {
            let mut lines = groups.lines().map(|line| line.splitn(3, ':'));
            lines.find_map(|mut parts| {
                let (controllers, path) = (parts.nth(1)?, parts.next()?);
                let named = controllers.split(',').any(|known| known == controller);
                named.then(|| path.trim_end_matches('/').to_owned())
            })
        };
        let file = |folder: &str, group: &str, name: &str| {
            self.list(&format!("sys/fs/cgroup{folder}{group}/{name}"))
                .or_else(|| self.list(&format!("sys/fs/cgroup{folder}/{name}")))
        };
        let first = group("cpuset").and_then(|group| {
            let names = ["cpuset.effective_cpus", "cpuset.cpus"];
            names.iter().find_map(|name| file("/cpuset", &group, name))
        });
        first.or_else(|| file("", &group("")?, "cpuset.cpus.effective"))
    }
}

/// The numbers of a list such as `0-3,8`; `None` if it is empty or not a list.
fn list(text: &str) -> Option<Set> {
    let mut numbers = Set::new();
    for range in text.split(',') {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        let (first, last): (u32, u32) = (first.trim().parse().ok()?, last.trim().parse().ok()?);
        if last >= LARGEST_NUMBER {
            return None;
        }
        numbers.extend(first..=last);
    }
    (!numbers.is_empty()).then_some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_those_of_the_kernel() {
        let set = |text: &str| list(text).map(|set| set.into_iter().collect::<Vec<_>>());
        assert_eq!(set("0-2,8"), Some(vec![0, 1, 2, 8]));
        assert_eq!(set("5"), Some(vec![5]));
        for text in ["", "x", "1-", "3-1", "0-4294967295", "0-99999999999"] {
            assert_eq!(set(text), None, "{text}");
        }
    }
}
