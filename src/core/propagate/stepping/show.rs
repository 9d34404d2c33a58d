//! A step as the observer sees it.

use super::Stepping;
use super::cubic::{derivative, hermite};
use super::mesh_state::MeshStates;
use crate::model::{MOST_CONTACTS, Segment, TrajectoryState};
use crate::propagate::observer::ShownContacts;
use crate::propagate::{Observer, Window};

impl Stepping {
    /// Shows a step to the observer: δ as the cubic through values and rates at its ends,
    /// F as the force of that cubic.
    pub(super) fn show<O: Observer>(
        &self,
        trajectory: &TrajectoryState,
        j: usize,
        [left, right]: [&MeshStates; 2],
        (start, segments): (&[f64], &mut [Segment]),
        observer: &mut O,
    ) {
        let active = trajectory.contact;
        let cubic = |contact: usize| {
            let motion = [left, right].map(|mesh| [mesh[contact].deflection, mesh[contact].rate]);
            hermite(motion[0], motion[1], self.step)
        };
        let mut shown = ShownContacts::<4, MOST_CONTACTS>::new(cubic(0));
        for contact in active.iter() {
            let side = self.contacts[contact].contact.side;
            let segment = self.segment(contact, trajectory.cycle, j);
            let stiffness = self.middle(contact, trajectory.cycle, j).stiffness;
            let deflection = cubic(contact);
            let rate = derivative(deflection, self.step);
            let gap = hermite(left[contact].gap, right[contact].gap, self.step);
            let opening = derivative(gap, self.step);
            let mut force = [0.0; 4];
            for i in 0..4 {
                force[i] = stiffness * (deflection[i] - side * gap[i])
                    + segment.damping * (rate[i] - side * opening[i]);
            }
            shown.push(contact, contact < self.flank_springs, deflection, force);
        }
        for (contact, segment) in segments.iter_mut().enumerate() {
            *segment = *self.segment(contact, trajectory.cycle, j);
        }
        let (first, second) = start.split_at(start.len() / 2);
        shown.show(
            &Window {
                cycle: trajectory.cycle,
                start: left[0].time,
                duration: self.step,
                segments,
                contact: active,
                first,
                second,
                ..Window::default()
            },
            observer,
        );
    }
}
