//! Passes a step to the observer.

use super::Stepping;
use super::cubic::{derivative, hermite};
use super::mesh_state::MeshState;
use crate::model::{Segment, TrajectoryState};
use crate::propagate::{ClosedContact, Observer, Window};

impl Stepping {
    /// Passes a step to the observer: δ as the cubic through values and rates at its ends, F as the force of that
    /// cubic.
    pub(super) fn show<O: Observer, const M: usize>(
        &self,
        trajectory: &TrajectoryState,
        j: usize,
        [left, right]: [&[MeshState; M]; 2],
        (start, segments): (&[f64], &mut [Segment]),
        observer: &mut O,
    ) {
        let active = trajectory.contact;
        let cubic = |contact: usize| {
            let motion = [left, right].map(|mesh| [mesh[contact].deflection, mesh[contact].rate]);
            hermite(motion[0], motion[1], self.step)
        };
        let mesh = cubic(0);
        let mut contacts = [0; M];
        let mut series = [[[0.0; 4]; 2]; M];
        for (index, contact) in active.iter().enumerate() {
            let side = self.contacts[contact].contact.side;
            let segment = self.segment(contact, trajectory.cycle, j);
            let stiffness = self.middle(contact, trajectory.cycle, j).stiffness;
            let deflection = cubic(contact);
            let rate = derivative(deflection, self.step);
            let gap = hermite(left[contact].gap, right[contact].gap, self.step);
            let opening = derivative(gap, self.step);
            let force = std::array::from_fn(|i| {
                stiffness * (deflection[i] - side * gap[i])
                    + segment.damping * (rate[i] - side * opening[i])
            });
            contacts[index] = contact;
            series[index] = [deflection, force];
        }
        for (contact, segment) in segments.iter_mut().enumerate() {
            *segment = *self.segment(contact, trajectory.cycle, j);
        }
        let (first, second) = start.split_at(start.len() / 2);
        let window = Window {
            cycle: trajectory.cycle,
            start: left[0].time,
            duration: self.step,
            segments,
            contact: active,
            deflection: &mesh,
            closed: &ClosedContact::each(&contacts, &series)[..active.count()],
            first,
            second,
            ..Window::default()
        };
        window.show::<4, O>(self.flank_springs, observer);
    }
}
