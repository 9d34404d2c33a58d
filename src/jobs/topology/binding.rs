//! Binds the calling thread to hardware threads, and reports success only if it took effect.

use super::description::Topology;
use super::system::BindingError;

impl Topology {
    /// Binds the calling thread to hardware threads, numbered as by the system. Pages that it touches first then come
    /// from the memory near them.
    ///
    /// # Errors
    /// The topology describes another machine, or the system refuses.
    pub fn bind_current_thread(&self, threads: &[u32]) -> Result<(), BindingError> {
        if self.is_this_system() {
            self.system.bind_thread(threads)
        } else {
            Err(BindingError::Elsewhere)
        }
    }

    /// Makes pages that the calling thread touches first come from a NUMA node, which may have no cores.
    ///
    /// # Errors
    /// The topology describes another machine, or the system refuses.
    pub fn bind_memory_of_current_thread(&self, node: u32) -> Result<(), BindingError> {
        if self.is_this_system() {
            self.system.bind_memory(node)
        } else {
            Err(BindingError::Elsewhere)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::sysfs;

    /// Binds a thread through one description of this machine. Every new description then has only this
    /// thread.
    fn a_thread_stays_where_it_was_bound(topology: &Topology) {
        let thread = topology.cores[topology.cores.len() - 1].threads[0];
        match topology.bind_current_thread(&[thread]) {
            Ok(()) => {
                let readings = [Topology::current(), sysfs::of_this_machine()];
                for narrowed in readings.map(Result::unwrap) {
                    assert_eq!(
                        narrowed.threads(),
                        1,
                        "a process's own binding is respected"
                    );
                    assert_eq!(narrowed.cores[0].threads, [thread]);
                    let node = narrowed.current_numa_node();
                    assert_eq!(node, topology.numa_node_of(thread));
                }
            }
            // Some sandboxes forbid it and report so.
            Err(error) => assert!(matches!(error, BindingError::Refused { .. }), "{error}"),
        }
    }

    #[test]
    fn threads_stay_where_they_were_bound() {
        for read in [Topology::current, sysfs::of_this_machine] {
            // A separate thread: the other threads of the test stay unbound.
            std::thread::spawn(move || a_thread_stays_where_it_was_bound(&read().unwrap()))
                .join()
                .unwrap();
        }
    }

    #[test]
    fn what_there_is_not_cannot_be_bound_to() {
        let topology = sysfs::of_this_machine().unwrap();
        for threads in [&[][..], &[u32::MAX]] {
            let refused = topology.bind_current_thread(threads).unwrap_err();
            assert!(matches!(refused, BindingError::Refused { .. }), "{refused}");
        }
        let refused = topology.bind_memory_of_current_thread(0).unwrap_err();
        assert_eq!(refused, BindingError::NoMemoryBinding);
    }

    #[test]
    #[cfg(feature = "hwloc")]
    fn a_machine_that_does_not_exist_binds_nobody() {
        let topology = Topology::synthetic("package:2 core:2 pu:1").unwrap();
        assert_eq!(
            topology.bind_current_thread(&[0]),
            Err(BindingError::Elsewhere)
        );
    }
}
