//! Static equilibrium: which contacts bear the mean load, and how far the structure yields.

use super::{ActiveSet, COAST_FLANK, DRIVE_FLANK, Model};
use crate::numerics::linalg;
use faer::Mat;

/// Part of a sum's terms that is the round-off of their sum.
const ROUND_OFF: f64 = 1e-12;

/// Contacts opened and closed until an equilibrium is given up: many times what sixteen need.
const MOST_CHANGES: usize = 1000;

/// A contact as a static state meets it, in the turned modes.
struct Standing {
    /// +1 or −1, as that of the contact.
    side: f64,
    /// Participation w of its deflection.
    deflection: Vec<f64>,
    /// Modal force g of a unit of its force, with a minus sign.
    force: Vec<f64>,
    /// Displacements under that, K⁻¹ g.
    yielding: Vec<f64>,
    /// Stiffness k \[N/m\].
    stiffness: f64,
    /// `Σ w q` at which it closes \[m\].
    shut: f64,
    /// Rate of that \[m/s\].
    shut_rate: f64,
}

impl Standing {
    /// That of a contact of a model.
    fn of(model: &Model, contact: usize) -> Self {
        let contact = &model.contacts[contact];
        let segment = &contact.cycle(0).segments[0];
        let [gap, opening] = contact.gap(segment, 0.0);
        let (error, error_rate) = model.lines[model.line(segment)].transmission_error_at(0, 0.0);
        let [deflection, force] = model.participations(segment.direction);
        Self {
            side: contact.side,
            yielding: model.elastic_response(&force),
            deflection,
            force,
            stiffness: segment.stiffness_at(0.0),
            shut: error + contact.side * gap,
            shut_rate: error_rate + contact.side * opening,
        }
    }

    /// How far it is beyond the place where it closes \[m\], the sign that of its side.
    fn stretch(&self, modes: &[f64]) -> f64 {
        dot(&self.deflection, modes) - self.shut
    }

    /// Size of what that is a difference of \[m\].
    fn room(&self, modes: &[f64]) -> f64 {
        let terms = self
            .deflection
            .iter()
            .zip(modes)
            .map(|(w, q)| (w * q).abs());
        self.shut.abs() + terms.sum::<f64>()
    }
}

/// `Σ a b` over as many as both have.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The largest modulus.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// The rigid motions that closed contacts hold.
struct Held {
    /// Orthonormal, each over the rigid modes.
    basis: Vec<Vec<f64>>,
    /// Velocities of the rigid modes with which the contacts do not move against each other.
    rates: Vec<f64>,
}

impl Held {
    fn by(closed: &[&Standing], rigid: &[usize]) -> Self {
        let mut held = Self {
            basis: Vec::new(),
            rates: vec![0.0; rigid.len()],
        };
        for own in closed {
            let along: Vec<f64> = rigid.iter().map(|&r| own.deflection[r]).collect();
            let mut rest = along.clone();
            for basis in &held.basis {
                let part = dot(&rest, basis);
                for (rest, h) in rest.iter_mut().zip(basis) {
                    *rest -= part * h;
                }
            }
            let size = dot(&rest, &rest).sqrt();
            if size <= ROUND_OFF * dot(&along, &along).sqrt() {
                continue;
            }
            let basis: Vec<f64> = rest.iter().map(|a| a / size).collect();
            let missing = (own.shut_rate - dot(&along, &held.rates)) / size;
            for (rate, h) in held.rates.iter_mut().zip(&basis) {
                *rate += missing * h;
            }
            held.basis.push(basis);
        }
        held
    }
}

/// A state of rest with some contacts closed.
struct Equilibrium {
    /// Their forces \[N\], in order.
    forces: Vec<f64>,
    /// Displacements of the turned modes.
    modes: Vec<f64>,
    /// Velocities of the rigid ones.
    rates: Vec<f64>,
    /// What loads the rigid motions that are not held.
    drift: Vec<f64>,
}

impl Equilibrium {
    /// The open contact that a drift of the rigid motions meets first.
    fn met_by_drift(&self, active: ActiveSet, all: &[Standing], rigid: &[usize]) -> Option<usize> {
        let way = |contact: usize| {
            let own = &all[contact];
            let speed: f64 = (rigid.iter().zip(&self.drift))
                .map(|(&r, drift)| own.side * own.deflection[r] * drift)
                .sum();
            let [size, fastest] = [&own.deflection, &self.drift].map(|values| largest(values));
            // A motion that a contact does not feel is felt by round-off.
            (speed > ROUND_OFF * size * fastest)
                .then(|| (contact, -own.side * own.stretch(&self.modes) / speed))
        };
        (0..all.len())
            .filter(|contact| !active.holds(*contact))
            .filter_map(way)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(contact, _)| contact)
    }
}

impl Model {
    /// Static equilibrium under the mean torques with all contacts at the start of their cycles: on
    /// one of the flanks where there is nothing else that it closes, else on all contacts that share
    /// the load.
    pub(super) fn static_equilibrium(&self) -> Vec<f64> {
        let (mut state, force) = self.equilibrium_on(DRIVE_FLANK);
        let mut flank = DRIVE_FLANK;
        if force < 0.0 {
            (state, _) = self.equilibrium_on(COAST_FLANK);
            flank = COAST_FLANK;
        }
        let modes = self.basis.turned_modes(&state);
        let closed = |contact: usize| {
            let standing = Standing::of(self, contact);
            standing.side * standing.stretch(&modes) > ROUND_OFF * standing.room(&modes)
        };
        let count = self.contacts.len();
        match count > 2 || (0..count).any(|other| other != flank && closed(other)) {
            true => self.shared_equilibrium(flank),
            false => state,
        }
    }

    /// Static equilibrium with the load shared by the contacts that it closes. Contacts that would
    /// pull are opened, those in the way of the others are closed, until neither is left: a linear
    /// complementarity problem. A rigid motion that nothing holds drifts along what loads it until
    /// a contact meets it; one that none meets stays where it is.
    fn shared_equilibrium(&self, flank: usize) -> Vec<f64> {
        let n = self.blocks.len();
        let load = self.load_on_modes();
        let at_load = self.elastic_response(&load);
        let all: Vec<Standing> = (0..self.contacts.len())
            .map(|contact| Standing::of(self, contact))
            .collect();
        let mut active = ActiveSet::FREE.toggled(flank);
        let mut found = self.equilibrium_with(active, &all, &load, &at_load);
        for _ in 0..MOST_CHANGES {
            let pulls = active
                .iter()
                .zip(&found.forces)
                .find(|(contact, force)| all[*contact].side * **force < 0.0);
            let change = (pulls.map(|(contact, _)| contact))
                .or_else(|| found.met_by_drift(active, &all, self.basis.rigid()))
                .or_else(|| {
                    (0..all.len()).find(|&contact| {
                        let (own, modes) = (&all[contact], &found.modes);
                        let beyond = own.side * own.stretch(modes);
                        !active.holds(contact) && beyond > ROUND_OFF * own.room(modes)
                    })
                });
            let Some(change) = change else { break };
            active = active.toggled(change);
            found = self.equilibrium_with(active, &all, &load, &at_load);
        }
        found.modes.resize(2 * n, 0.0);
        for (&rigid, rate) in self.basis.rigid().iter().zip(&found.rates) {
            found.modes[n + rigid] = *rate;
        }
        self.basis.state_of_turned(&found.modes)
    }

    /// Equilibrium with exactly these contacts closed, whatever the signs of their forces:
    /// `H y` the rigid motions that they hold, H with orthonormal columns,
    ///
    /// ```text
    /// W H y − (W K⁻¹ G + 1/k) F = d − W K⁻¹ f,      Hᵀ Gᵀ F = Hᵀ f
    /// ```
    fn equilibrium_with(
        &self,
        active: ActiveSet,
        all: &[Standing],
        load: &[f64],
        at_load: &[f64],
    ) -> Equilibrium {
        let rigid = self.basis.rigid();
        let closed: Vec<&Standing> = active.iter().map(|contact| &all[contact]).collect();
        let held = Held::by(&closed, rigid);
        let (count, order) = (closed.len(), closed.len() + held.basis.len());
        let along = |vector: &[f64], basis: &[f64]| -> f64 {
            rigid.iter().zip(basis).map(|(&r, h)| vector[r] * h).sum()
        };
        let matrix = Mat::from_fn(order, order, |i, j| match (i < count, j < count) {
            (true, true) => {
                let own = if i == j {
                    1.0 / closed[i].stiffness
                } else {
                    0.0
                };
                -dot(&closed[i].deflection, &closed[j].yielding) - own
            }
            (true, false) => along(&closed[i].deflection, &held.basis[j - count]),
            (false, true) => along(&closed[j].force, &held.basis[i - count]),
            (false, false) => 0.0,
        });
        let right: Vec<f64> = (closed.iter())
            .map(|own| own.shut - dot(&own.deflection, at_load))
            .chain(held.basis.iter().map(|basis| along(load, basis)))
            .collect();
        let solution = match order {
            0 => Vec::new(),
            _ => linalg::solve(matrix.as_ref(), &right),
        };
        let (forces, shifts) = solution.split_at(count);
        let mut modes = at_load.to_vec();
        let loads: Vec<f64> = rigid.iter().map(|&r| load[r]).collect();
        let mut unbalanced = loads.clone();
        for (own, force) in closed.iter().zip(forces) {
            for (mode, yielding) in modes.iter_mut().zip(&own.yielding) {
                *mode -= force * yielding;
            }
            for (left, &r) in unbalanced.iter_mut().zip(rigid) {
                *left -= force * own.force[r];
            }
        }
        for (basis, shift) in held.basis.iter().zip(shifts) {
            for (&r, h) in rigid.iter().zip(basis) {
                modes[r] += shift * h;
            }
            let along: f64 = dot(&unbalanced, basis);
            for (left, h) in unbalanced.iter_mut().zip(basis) {
                *left -= along * h;
            }
        }
        let round_off = ROUND_OFF * largest(&loads);
        Equilibrium {
            forces: forces.to_vec(),
            modes,
            rates: held.rates,
            drift: unbalanced
                .iter()
                .map(|f| if f.abs() > round_off { *f } else { 0.0 })
                .collect(),
        }
    }

    /// Static equilibrium with no more than one contact closed, and the force that it would have
    /// to bear along its direction \[N\]. That is the one that the rigid relative rotation asks for,
    /// where there is one; otherwise the one that stiffness and gap settle on.
    fn equilibrium_on(&self, contact: usize) -> (Vec<f64>, f64) {
        let n = self.blocks.len();
        let contact = &self.contacts[contact];
        let segment = &contact.cycle(0).segments[0];
        let k = segment.stiffness_at(0.0);
        let [b, opening] = contact.gap(segment, 0.0);
        let side = contact.side;
        let (error, error_rate) = self.lines[self.line(segment)].transmission_error_at(0, 0.0);
        let rigid = self.relative_rotation();
        let [w, g] = self.participations(segment.direction);
        let load = self.load_on_modes();
        let along = |first: f64, x: &[f64]| w.iter().zip(x).fold(first, |sum, (w, x)| sum + w * x);
        // Deflection of the elastic modes: δ = free − flexibility F.
        let [at_load, at_unit] = [&load, &g].map(|force| self.elastic_response(force));
        let free = along(-error, &at_load);
        let flexibility = along(0.0, &at_unit);
        let asked = match rigid {
            Some(r) => load[r] / g[r],
            None => k * (free - side * b) / (1.0 + k * flexibility),
        };
        // A contact does not pull.
        let force = match rigid.is_some() || side * asked > 0.0 {
            true => asked,
            false => 0.0,
        };
        let left: Vec<f64> = load
            .iter()
            .zip(&g)
            .map(|(load, g)| load - g * force)
            .collect();
        let mut modes = self.elastic_response(&left);
        modes.resize(2 * n, 0.0);
        if let Some(r) = rigid {
            let deflection = force / k + side * b;
            modes[r] = (deflection - (free - flexibility * force)) / w[r];
            modes[n + r] = (error_rate + side * opening) / w[r];
        }
        // The flank that is in the way of the load, where none is reached, is the other one.
        let asked = if rigid.is_none() && force == 0.0 {
            free
        } else {
            asked
        };
        (self.basis.state_of_turned(&modes), asked)
    }

    /// Displacements of the turned modes under a constant force; those of rigid ones are left zero.
    fn elastic_response(&self, force: &[f64]) -> Vec<f64> {
        let n = force.len();
        let mut out = vec![0.0; n];
        let elastic: Vec<usize> = (0..n).filter(|i| !self.basis.rigid().contains(i)).collect();
        match self.basis.coupled() {
            None => {
                for &i in &elastic {
                    out[i] = force[i] / -self.blocks[i].generator[1][0];
                }
            }
            Some(coupled) if !elastic.is_empty() => {
                let entry = |i: usize, j: usize| coupled.stiffness[n * elastic[i] + elastic[j]];
                let matrix = Mat::from_fn(elastic.len(), elastic.len(), entry);
                let right: Vec<f64> = elastic.iter().map(|&i| force[i]).collect();
                for (&i, x) in elastic.iter().zip(linalg::solve(matrix.as_ref(), &right)) {
                    out[i] = x;
                }
            }
            Some(_) => {}
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Drive, InitialState, OperatingPoint, fixtures};
    use crate::shaft::{ModalStructure, StructureContact};

    /// The contacts that the start closes; nothing is accelerated there, nothing moves, and none
    /// pulls.
    fn closed(structure: &ModalStructure, load: f64) -> Vec<usize> {
        let point = OperatingPoint { load, speed: 100.0 };
        let drive = fixtures::constant_mesh(10e-6, 4e8);
        let model = Model::new(structure, &drive, point).unwrap();
        let start = model.start(&InitialState::Static);
        let segments = model.segments_at(0, 0.0);
        let n = model.modes();
        let mut rate = vec![0.0; 2 * n];
        model.derivative(&segments, start.contact, 0, 0.0, &start.state, &mut rate);
        let size = |state: &[f64], scale: &dyn Fn(usize) -> f64| {
            (state.iter().enumerate()).fold(0.0_f64, |most, (i, x)| most.max((x / scale(i)).abs()))
        };
        let load = (model.load_on_modes().iter()).fold(0.0_f64, |most, f| most.max(f.abs()));
        assert!(
            size(&rate[n..], &|_| load.max(100.0)) < 1e-11,
            "{rate:?} of {load}"
        );
        assert_eq!(size(&rate[..n], &|_| 1.0), 0.0);
        for contact in start.contact.iter() {
            let own = &model.contacts[contact];
            let (deflection, _) = model.deflection_on(&segments[contact], 0, &start.state, 0.0);
            assert!(own.side * deflection > own.half_gap);
        }
        start.contact.iter().collect()
    }

    fn elastic() -> ModalStructure {
        ModalStructure {
            rated_force: 1000.0,
            ..ModalStructure::of_modes(
                &[900.0, 2000.0, 4000.0],
                0.01,
                &[0.6, 0.5, -0.3],
                &[0.6, 0.2, -0.3],
            )
        }
    }

    #[test]
    fn contacts_in_the_way_share_the_load() {
        let mut structure = elastic();
        assert_eq!(closed(&structure, 1.0), [0]);
        structure.contacts = vec![
            StructureContact::stop(&[0.5, -0.4, 0.1], 5e-6, 2e8),
            StructureContact::stop(&[0.4, 0.2, -0.1], 2e-6, 1e8),
            StructureContact::stop(&[-0.5, 0.1, 0.1], 30e-6, 1e8),
        ];
        assert_eq!(closed(&structure, 1.0), [0, 2, 3]);
        // A preloaded one is closed at any load.
        structure.contacts[2].law.gap = -40e-6;
        for load in [1.0, 0.0, -1.0] {
            assert!(closed(&structure, load).contains(&4), "{load}");
        }
    }

    /// A stop that the others put in their way by less than a thousandth of what they yield bears as well.
    #[test]
    fn a_contact_hardly_in_the_way_bears() {
        let mut structure = elastic();
        structure.contacts = vec![
            StructureContact::stop(&[0.5, -0.4, 0.1], 5e-6, 2e8),
            StructureContact::stop(&[0.4, 0.2, -0.1], 1e-3, 1e8),
        ];
        let point = OperatingPoint {
            load: 1.0,
            speed: 100.0,
        };
        let model = Model::new(&structure, &fixtures::constant_mesh(10e-6, 4e8), point).unwrap();
        let start = model.start(&InitialState::Static);
        let contact = 3;
        let segment = model.segments_at(0, 0.0)[contact];
        let (deflection, _) = model.deflection_on(&segment, 0, &start.state, 0.0);
        for (short, bears) in [(2e-9, true), (-2e-9, false)] {
            structure.contacts[1].law.gap = deflection - short;
            assert_eq!(closed(&structure, 1.0).contains(&contact), bears, "{short}");
        }
    }

    /// Without a load the gears stand on the drive flank.
    #[test]
    fn an_unloaded_drive_stands_on_its_drive_flank() {
        let structure = fixtures::structure(&[0.0], 0.0, &[1.3], &[1.3]);
        let point = OperatingPoint {
            load: 0.0,
            speed: 100.0,
        };
        let model = Model::new(&structure, &fixtures::constant_mesh(10e-6, 4e8), point).unwrap();
        let state = model.static_equilibrium();
        assert!(
            (model.deflection(&state, 0.0).0 - 10e-6).abs() < 1e-20,
            "{state:?}"
        );
    }

    /// What a stretch is a difference of: every term, and where the contact closes.
    #[test]
    fn room_is_the_size_of_all_terms() {
        let standing = Standing {
            side: 1.0,
            deflection: vec![2.0, -3.0],
            force: Vec::new(),
            yielding: Vec::new(),
            stiffness: 1.0,
            shut: -4.0,
            shut_rate: 0.0,
        };
        assert_eq!(standing.room(&[1.0, 5.0]), 21.0);
        assert_eq!(standing.stretch(&[1.0, 5.0]), -9.0);
    }

    /// One stop so near that the drive flank is not reached.
    #[test]
    fn a_contact_that_takes_all_the_load_opens_the_flank() {
        let mut structure = elastic();
        structure.contacts = vec![StructureContact::stop(&[0.6, 0.5, -0.3], 1e-6, 1e10)];
        assert_eq!(closed(&structure, 1.0), [2]);
    }

    /// Friction turns the whole drive, which no contact feels beyond round-off: it does not drift into one.
    #[test]
    fn what_no_contact_feels_stays() {
        let mut structure = ModalStructure {
            rated_force: 1000.0,
            friction: vec![0.3, 0.1, 0.0],
            ..ModalStructure::of_modes(
                &[0.0, 0.0, 3000.0],
                0.01,
                &[0.61, -0.49, 0.2],
                &[0.61, -0.49, 0.2],
            )
        };
        let stop = [-0.2 * 0.61, 0.2 * 0.49, -0.3];
        structure.contacts = vec![StructureContact::stop(&stop, 40e-6, 1e8)];
        let drive = Drive {
            friction: 0.1,
            ..fixtures::constant_mesh(10e-6, 4e8)
        };
        let point = OperatingPoint {
            load: 1.0,
            speed: 100.0,
        };
        let model = Model::new(&structure, &drive, point).unwrap();
        let start = model.start(&InitialState::Static);
        assert_eq!(start.contact, ActiveSet::DRIVE);
        let (alone, _) = model.equilibrium_on(DRIVE_FLANK);
        let size = largest(&alone);
        for (shared, alone) in start.state.iter().zip(&alone) {
            assert!((shared - alone).abs() < 1e-13 * size, "{shared} {alone}");
        }
    }

    /// Two rotations, the second held by a further mesh only, which a drag presses together.
    #[test]
    fn a_rotation_that_nothing_else_holds_drifts_into_its_contact() {
        let mut structure = ModalStructure {
            rated_force: 1000.0,
            constant_load: vec![150.0, 0.0, 0.0],
            ..ModalStructure::of_modes(
                &[0.0, 0.0, 3000.0],
                0.01,
                &[0.0, 0.7, 0.2],
                &[0.0, 0.7, 0.2],
            )
        };
        structure.contacts = vec![
            StructureContact::stop(&[0.5, -0.2, 0.3], 8e-6, 3e8),
            StructureContact::stop(&[-0.5, 0.2, 0.3], 8e-6, 3e8),
        ];
        assert_eq!(closed(&structure, 1.0), [0, 2]);
        structure.constant_load[0] = -150.0;
        assert_eq!(closed(&structure, 1.0), [0, 3]);
        // On the coast flank with the other sign of the load.
        assert_eq!(closed(&structure, -1.0), [1, 3]);
    }
}
