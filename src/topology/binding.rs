//! Binds the calling thread to hardware threads, and says so only where it took effect.

use super::Topology;
use hwlocality::bitmap::BitmapIndex as NodeIndex;
use hwlocality::cpu::binding::CpuBindingFlags;
use hwlocality::cpu::cpuset::CpuSet;
use hwlocality::memory::binding::{MemoryBindingFlags, MemoryBindingPolicy};
use hwlocality::memory::nodeset::NodeSet;
use hwlocality::object::types::ObjectType;
use thiserror::Error;

/// Why a thread is not bound.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BindingError {
    /// The topology describes another machine.
    #[error("the topology is not that of this machine")]
    Elsewhere,
    /// The system does not bind.
    #[error("the system does not bind threads: {detail}")]
    Refused {
        /// hwloc's own words.
        detail: String,
    },
    /// The system accepted it and did something else.
    #[error("the system bound a thread elsewhere than asked")]
    NotKept,
}

impl Topology {
    /// Binds the calling thread to hardware threads, as the system numbers them. Pages that it
    /// touches first then come from the memory near them.
    ///
    /// # Errors
    /// The topology is of another machine, or the system does not bind.
    pub fn bind_current_thread(&self, threads: &[u32]) -> Result<(), BindingError> {
        if !self.is_this_system() {
            return Err(BindingError::Elsewhere);
        }
        let refused = |detail: String| BindingError::Refused { detail };
        let hwloc = self.hwloc();
        let mut set = CpuSet::new();
        for unit in hwloc.objects_with_type(ObjectType::PU) {
            let known = unit.os_index().and_then(|index| u32::try_from(index).ok());
            if let (Some(index), Some(own)) = (known, unit.cpuset())
                && threads.contains(&index)
            {
                set |= &*own;
            }
        }
        hwloc
            .bind_cpu(&set, CpuBindingFlags::THREAD)
            .map_err(|error| refused(error.to_string()))?;
        let bound = hwloc
            .cpu_binding(CpuBindingFlags::THREAD)
            .map_err(|error| refused(error.to_string()))?;
        match bound == set {
            true => Ok(()),
            false => Err(BindingError::NotKept),
        }
    }

    /// Lets pages that the calling thread touches first come from a NUMA node, which may have no
    /// cores.
    ///
    /// # Errors
    /// The topology is of another machine, or the system does not bind.
    pub fn bind_memory_of_current_thread(&self, node: u32) -> Result<(), BindingError> {
        if !self.is_this_system() {
            return Err(BindingError::Elsewhere);
        }
        let index = NodeIndex::try_from(node as usize).map_err(|_| BindingError::NotKept)?;
        let (policy, flags) = (MemoryBindingPolicy::Bind, MemoryBindingFlags::THREAD);
        (self.hwloc())
            .bind_memory(&NodeSet::from(index), policy, flags)
            .map_err(|error| BindingError::Refused {
                detail: error.to_string(),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_stays_where_it_was_bound() {
        // A thread of its own: others of the test keep their freedom.
        std::thread::spawn(|| {
            let topology = Topology::current().unwrap();
            let thread = topology.cores[topology.cores.len() - 1].threads[0];
            match topology.bind_current_thread(&[thread]) {
                Ok(()) => {
                    let narrowed = Topology::current().unwrap();
                    assert_eq!(
                        narrowed.threads(),
                        1,
                        "a process's own binding is respected"
                    );
                    assert_eq!(narrowed.cores[0].threads, [thread]);
                }
                // Some sandboxes forbid it, and say so.
                Err(error) => assert!(matches!(error, BindingError::Refused { .. }), "{error}"),
            }
        })
        .join()
        .unwrap();
    }

    #[test]
    fn a_machine_that_does_not_exist_binds_nobody() {
        let topology = Topology::synthetic("package:2 core:2 pu:1").unwrap();
        assert_eq!(
            topology.bind_current_thread(&[0]),
            Err(BindingError::Elsewhere)
        );
    }
}
