//! When is the system of a set of closed contacts built? When a motion first closes the set; beforehand, if
//! there are few sets.

use super::ClosedModes;
use super::excitation::unresonant;
use super::reached_sets::{self, MOST_BYTES};
use super::series::Series;
use super::slot::Slot;
use super::system::{SharedData, System};
use crate::propagate::{TableError, TableSize};
use std::sync::OnceLock;
use std::sync::atomic::Ordering;

impl<'m> ClosedModes<'m> {
    /// The stored data of a set of closed contacts, for which [`Self::slot_or_build`] has been called.
    #[inline(always)]
    pub(super) fn slot(&self, set: usize) -> &Slot<'m> {
        match self.slots.get(set) {
            Some(slot) => slot,
            None => unreachable!("a slot is built before it is used"),
        }
    }

    /// The system of a slot.
    #[inline(always)]
    pub(super) fn system(&self, set: usize) -> &System {
        &self.slot(set).system
    }

    /// Returns the slot of a system and builds it if a motion reaches it for the first time.
    ///
    /// # Errors
    /// Its eigenvectors are too nearly parallel, an undamped mode is in resonance with a harmonic, or the
    /// systems built so far take too much memory.
    #[inline]
    pub(super) fn slot_or_build(&self, set: usize) -> Result<&Slot<'m>, TableError> {
        match self.slots.get(set) {
            Some(slot) => Ok(slot),
            None => {
                let slot = self.store_slot(set);
                slot.inspect_err(|error| {
                    self.refusal.get_or_init(|| *error);
                })
            }
        }
    }

    /// Builds and stores the slot of a system, and counts its bytes if no other thread has stored it before.
    fn store_slot(&self, set: usize) -> Result<&Slot<'m>, TableError> {
        let bytes = reached_sets::bytes(self.model.modes());
        self.check_room(self.used_bytes.load(Ordering::Relaxed) + bytes)?;
        let slot = self.build_slot(set)?;
        match self.slots.put(set, slot) {
            Some((slot, false)) => Ok(slot),
            Some((slot, true)) => {
                self.check_room(self.used_bytes.fetch_add(bytes, Ordering::Relaxed) + bytes)?;
                Ok(slot)
            }
            // Other threads have filled the table since the first check.
            None => Err(self.too_large(self.used_bytes.load(Ordering::Relaxed) + bytes)),
        }
    }

    /// Builds the slot of a system.
    fn build_slot(&self, set: usize) -> Result<Slot<'m>, TableError> {
        let (model, sets) = (self.model, &self.sets);
        let basis = self.bases.of(model, sets, set)?;
        unresonant(model, &basis, &self.frequencies)?;
        let closed: Vec<_> = sets.closed(set).collect();
        let shared_data = SharedData {
            model,
            frequencies: &self.frequencies,
            mixed: &self.mixed,
            step: self.step,
        };
        Ok(Slot {
            states: (0..model.contacts.len())
                .map(|contact| sets.state(set, contact))
                .collect(),
            system: System::new(&shared_data, &basis, &closed),
            basis,
            series: OnceLock::new(),
        })
    }

    /// Refuses more bytes than the limit for the systems that motions of this kernel reach.
    fn check_room(&self, used_bytes: usize) -> Result<(), TableError> {
        if used_bytes <= MOST_BYTES { Ok(()) } else { Err(self.too_large(used_bytes)) }
    }

    fn too_large(&self, bytes: usize) -> TableError {
        TableError::TooLarge {
            size: TableSize {
                systems: self.slots.count(),
                bytes,
            },
            most: MOST_BYTES,
        }
    }

    /// The series of a system with a slot.
    #[inline]
    pub(super) fn series(&self, set: usize) -> &[Series] {
        let slot = self.slot(set);
        slot.series.get_or_init(|| self.series_of(slot))
    }
}
