//! What is the static equilibrium under the mean load? Which contacts carry it, and how is the structure
//! deflected?

use super::error::{ModelError, NoStaticState};
use super::rest::{self, Contacts, ROUND_OFF, StaticContact, StaticState, dot_of_moduli};
use super::{ActiveSet, Block, COAST_FLANK, DRIVE_FLANK, Model};
use crate::numerics::linalg::{self, add_scaled, dot};
use faer::Mat;
use std::f64::consts::TAU;

/// Stiffness of a rigid stop in the search for a static equilibrium, in units of the squared fastest rate divided
/// by ρ of the stop. At the start of a motion the state is moved onto the stop, which removes the overlap.
const RIGID: f64 = 1e8;

/// A contact in a static state, in the rotated modes.
struct RotatedStaticContact {
    /// Side of the contact, +1 or −1.
    side: f64,
    /// Participation w of its deflection.
    deflection: Vec<f64>,
    /// Modal force of a unit of its force with the sign reversed, g.
    force: Vec<f64>,
    /// Stiffness k \[N/m\].
    stiffness: f64,
    /// `Σ w q` at which it closes \[m\].
    shut: f64,
    /// Rate of `shut` \[m/s\].
    shut_rate: f64,
}

impl RotatedStaticContact {
    /// The contact with index `place`, at the start of its first cycle.
    fn of(model: &Model, place: usize) -> Self {
        let contact = &model.contacts[place];
        let segment = &contact.cycle(0).segments[0];
        if contact.release.of_slider() || !model.is_spring(place) {
            // Dry sliders, dry friction and rests start without a force: here no motion closes them.
            let nothing = vec![0.0; model.modes()];
            return Self {
                side: 1.0,
                deflection: nothing.clone(),
                force: nothing,
                stiffness: segment.stiffness.mean(),
                shut: 1.0,
                shut_rate: 0.0,
            };
        }
        let [gap, opening] = contact.gap(segment, 0.0);
        let (error, error_rate) = model.lines[model.line(segment)].transmission_error_at(0, 0.0);
        let [deflection, force] = model.participations(segment.direction);
        let stiffness = match model.stop_of(place) {
            Some(stop) => RIGID * model.fastest_rate().powi(2) / stop.push,
            None => segment.stiffness_at(0.0),
        };
        Self {
            side: contact.side,
            deflection,
            force,
            stiffness,
            shut: error + contact.side * gap,
            shut_rate: error_rate + contact.side * opening,
        }
    }

    /// Whether modal displacements stretch the contact by more than round-off.
    fn is_stretched(&self, modes: &[f64]) -> bool {
        let stretch = self.side * (dot(&self.deflection, modes) - self.shut);
        stretch > ROUND_OFF * (self.shut.abs() + dot_of_moduli(&self.deflection, modes))
    }

    /// The contact as an input of the search ([`super::rest`]).
    ///
    /// * `at_load`: displacements of the elastic modes under the load.
    /// * `push`: effect of a unit of the contact's force on the modes.
    /// * `compliance`: displacement of the contact by a unit force of every contact \[m/N\].
    /// * `rigid_motions`: indices of the rigid motions that deflect contacts.
    fn static_contact(
        &self,
        at_load: &[f64],
        push: &[f64],
        compliance: Vec<f64>,
        rigid_motions: &[usize],
    ) -> StaticContact {
        StaticContact {
            offset: self.side * (dot(&self.deflection, at_load) - self.shut),
            size: self.shut.abs() + dot_of_moduli(&self.deflection, at_load),
            stiffness: self.stiffness,
            along: self.rigid_part(&self.deflection, rigid_motions),
            push: self.rigid_part(push, rigid_motions),
            compliance,
        }
    }

    /// Participations of the contact in rigid motions, times its side and without round-off.
    fn rigid_part(&self, values: &[f64], rigid_motions: &[usize]) -> Vec<f64> {
        let noise = ROUND_OFF * values.iter().fold(0.0_f64, |most, w| w.abs().max(most));
        (rigid_motions.iter())
            .map(
                |&r| {
                    if values[r].abs() > noise { self.side * values[r] } else { 0.0 }
                },
            )
            .collect()
    }
}

/// Static equilibrium under the mean torques with all contacts at the start of their cycles.
pub(super) struct Equilibrium {
    /// The blocks' state.
    pub state: Vec<f64>,
    /// The contacts that carry a force beyond round-off.
    pub bearing: ActiveSet,
}

impl Model {
    /// The fastest rate of the blocks and of the mesh cycle \[1/s\].
    fn fastest_rate(&self) -> f64 {
        let rates = self.blocks.iter().map(Block::fastest);
        rates.fold(TAU / self.period(), f64::max)
    }

    /// The contacts that carry the mean load statically beyond round-off, all at the start of their cycles.
    ///
    /// # Panics
    /// If a model was changed after [`Model::new`] and has no static equilibrium.
    pub fn bearing_contacts(&self) -> ActiveSet {
        self.resting().bearing
    }

    /// The static equilibrium of a model from [`Model::new`].
    pub(super) fn resting(&self) -> Equilibrium {
        self.static_equilibrium()
            .unwrap_or_else(|error| panic!("a model changed since it was made: {error}"))
    }

    /// Static equilibrium under the mean torques with all contacts at the start of their cycles. If the two
    /// flanks are the only contacts, and one can carry the load alone, it does. Otherwise all contacts that the
    /// load closes share it.
    ///
    /// # Errors
    /// [`ModelError::NoEquilibrium`].
    pub(super) fn static_equilibrium(&self) -> Result<Equilibrium, ModelError> {
        // Oil carries no static load, and neither do flanks that do not exist.
        let is_solid = |contact: &usize| {
            let is_flank = [DRIVE_FLANK, COAST_FLANK].contains(contact);
            !self.is_of_film(*contact) && (!is_flank || self.has_flanks())
        };
        let solid: Vec<usize> = (0..self.contacts.len()).filter(is_solid).collect();
        let all: Vec<RotatedStaticContact> = (solid.iter())
            .map(|&contact| RotatedStaticContact::of(self, contact))
            .collect();
        let mut modes = vec![0.0; self.blocks.len()];
        if self.has_flanks() {
            let (mut state, mut force) = self.equilibrium_on(DRIVE_FLANK);
            let mut flank = DRIVE_FLANK;
            if force < 0.0 {
                (state, force) = self.equilibrium_on(COAST_FLANK);
                flank = COAST_FLANK;
            }
            modes = self.basis.turned_modes(&state);
            let pushes = force.is_finite() && all[flank].side * force >= 0.0;
            let stretched = |contact: &usize| all[*contact].is_stretched(&modes);
            let bearing = (0..all.len())
                .filter(stretched)
                .fold(ActiveSet::FREE, ActiveSet::toggled);
            let alone = bearing == ActiveSet::FREE || bearing.only() == Some(flank);
            if all.len() == 2 && pushes && alone {
                return Ok(Equilibrium { state, bearing });
            }
        }
        let shared = self.shared_equilibrium(&all, &modes).map_err(|none| {
            let contacts = none.contacts.iter().map(|&place| solid[place]).collect();
            NoStaticState { contacts, ..none }
        })?;
        let bearing = (solid.iter().enumerate())
            .filter(|(place, _)| shared.bearing.holds(*place))
            .fold(ActiveSet::FREE, |set, (_, &contact)| set.toggled(contact));
        Ok(Equilibrium { bearing, ..shared })
    }

    /// Static equilibrium in which all contacts that the load closes share it ([`super::rest`]). The search
    /// starts from the modal displacements `modes`. A rigid motion without restraint drifts under its load until
    /// it closes a contact. If it can close none, it keeps its displacement.
    fn shared_equilibrium(
        &self,
        all: &[RotatedStaticContact],
        modes: &[f64],
    ) -> Result<Equilibrium, NoStaticState> {
        let n = self.blocks.len();
        let rigid_motions = &self.basis.rigid()[self.basis.without_contact().len()..];
        let load = self.load_on_modes();
        let at_load = self.elastic_response(&load);
        let elastic_responses =
            |force: &dyn Fn(&RotatedStaticContact) -> Vec<f64>| -> Vec<Vec<f64>> {
                let forces = all
                    .iter()
                    .map(|rotated| self.elastic_response(&force(rotated)));
                forces.collect()
            };
        let responses_to_forces = elastic_responses(&|rotated| rotated.force.clone());
        let responses_to_deflections = elastic_responses(&|rotated| rotated.deflection.clone());
        let flexibility = |i: usize, j: usize, responses: &[Vec<f64>]| {
            all[i].side * all[j].side * dot(&all[i].deflection, &responses[j])
        };
        let contacts = |static_contact: &dyn Fn(usize) -> StaticContact| Contacts {
            contacts_at_rest: (0..all.len()).map(static_contact).collect(),
            load: rigid_motions.iter().map(|&r| load[r]).collect(),
        };
        let whole = contacts(&|i| {
            let compliance = (0..all.len())
                .map(|j| flexibility(i, j, &responses_to_forces))
                .collect();
            all[i].static_contact(&at_load, &all[i].force, compliance, rigid_motions)
        });
        let smooth = contacts(&|i| {
            let half = |i, j| 0.5 * flexibility(i, j, &responses_to_deflections);
            let compliance = (0..all.len()).map(|j| half(i, j) + half(j, i)).collect();
            all[i].static_contact(&at_load, &all[i].deflection, compliance, rigid_motions)
        });
        let from = self.sought_from(all, modes, rigid_motions);
        let rest_state = rest::static_state(&smooth, &whole, &from)?;
        let mut modes = at_load;
        let contacts_with_forces = all.iter().zip(&rest_state.forces);
        for ((rotated, force), response) in contacts_with_forces.zip(&responses_to_forces) {
            add_scaled(&mut modes, -rotated.side * force, response);
        }
        for (&r, place) in rigid_motions.iter().zip(&rest_state.place) {
            modes[r] = *place;
        }
        modes.resize(2 * n, 0.0);
        for (&r, rate) in rigid_motions.iter().zip(rates(all, &whole, &rest_state)) {
            modes[n + r] = rate;
        }
        Ok(Equilibrium {
            state: self.basis.state_of_turned(&modes),
            bearing: whole.stretched(&rest_state.forces, &rest_state.place),
        })
    }

    /// The start of the search: given modal displacements, and no contact forces.
    fn sought_from(
        &self,
        all: &[RotatedStaticContact],
        modes: &[f64],
        rigid_motions: &[usize],
    ) -> StaticState {
        let known = modes.iter().all(|q| q.is_finite());
        StaticState {
            forces: vec![0.0; all.len()],
            place: (rigid_motions.iter())
                .map(|&r| if known { modes[r] } else { 0.0 })
                .collect(),
            ..StaticState::default()
        }
    }

    /// The state of static equilibrium with no closed contact except possibly this one, and the force that the
    /// contact would have to carry along its direction \[N\]. The balance of the rigid relative rotation determines
    /// the force. Without such a rotation stiffness and gap determine it. If the contact is then not reached, the
    /// second value is the free deflection \[m\], of which only the sign is used.
    fn equilibrium_on(&self, contact: usize) -> (Vec<f64>, f64) {
        let n = self.blocks.len();
        let contact = &self.contacts[contact];
        let segment = &contact.cycle(0).segments[0];
        let k = segment.stiffness_at(0.0);
        let [b, opening] = contact.gap(segment, 0.0);
        let side = contact.side;
        let (error, error_rate) = self.lines[self.line(segment)].transmission_error_at(0, 0.0);
        let [w, g] = self.participations(segment.direction);
        // A rigid rotation with drag may not move this contact.
        let rigid = self
            .relative_rotation()
            .filter(|&r| w[r] != 0.0 && g[r] != 0.0);
        let load = self.load_on_modes();
        let along = |first: f64, x: &[f64]| w.iter().zip(x).fold(first, |sum, (w, x)| sum + w * x);
        // Deflection of the elastic modes: δ = free − flexibility F.
        let [at_load, at_unit] = [&load, &g].map(|force| self.elastic_response(force));
        let free = along(-error, &at_load);
        let flexibility = along(0.0, &at_unit);
        let required_force = match rigid {
            Some(r) => load[r] / g[r],
            None => k * (free - side * b) / (1.0 + k * flexibility),
        };
        // A contact does not pull.
        let force = if rigid.is_some() || side * required_force > 0.0 {
            required_force
        } else {
            0.0
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
        let state = self.basis.state_of_turned(&modes);
        // The sign of the free deflection selects the flank.
        (
            state,
            if rigid.is_none() && force == 0.0 { free } else { required_force },
        )
    }

    /// Displacements of the rotated elastic modes under a constant force. Those of the rigid modes are zero.
    fn elastic_response(&self, force: &[f64]) -> Vec<f64> {
        let n = force.len();
        let mut out = vec![0.0; n];
        let modes = 0..self.modes_of_structure();
        let elastic: Vec<usize> = modes.filter(|i| !self.basis.rigid().contains(i)).collect();
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

/// Velocities of the rigid motions. They keep touching contacts on their surfaces.
fn rates(all: &[RotatedStaticContact], contacts: &Contacts, rest: &StaticState) -> Vec<f64> {
    let stretches = contacts.stretches(&rest.forces, &rest.place);
    let touches = |i: &usize| stretches[*i] >= -contacts.noise(*i, &rest.forces, &rest.place);
    let touching: Vec<usize> = (0..all.len()).filter(touches).collect();
    let mut rates = vec![0.0; contacts.load.len()];
    let mut constrained: Vec<&[f64]> = Vec::new();
    for i in touching {
        let along = &contacts.contacts_at_rest[i].along[..];
        constrained.push(along);
        let basis = rest::span(constrained.iter().copied());
        if basis.len() < constrained.len() {
            constrained.pop();
            continue;
        }
        let last = &basis[basis.len() - 1];
        let missing = all[i].side * all[i].shut_rate - dot(along, &rates);
        add_scaled(&mut rates, missing / dot(along, last), last);
    }
    rates
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Drive, InitialState, OUT_OF_REACH, OperatingPoint, fixtures};
    use crate::structure::{Coupling, ModalStructure, StructureContact};

    /// The contacts that are closed at the start. Checks that all accelerations and velocities are zero, and
    /// that no contact pulls.
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
        // A preloaded contact is closed at any load.
        structure.contacts[2].law.gap = -40e-6;
        for load in [1.0, 0.0, -1.0] {
            assert!(closed(&structure, load).contains(&4), "{load}");
        }
    }

    /// A stop that is compressed by less than a thousandth of the deflection of the others carries load too.
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

    /// Without a load the gears rest on the drive flank.
    #[test]
    fn an_unloaded_drive_stands_on_its_drive_flank() {
        let structure = fixtures::structure(&[0.0], 0.0, &[1.3], &[1.3]);
        let point = OperatingPoint {
            load: 0.0,
            speed: 100.0,
        };
        let model = Model::new(&structure, &fixtures::constant_mesh(10e-6, 4e8), point).unwrap();
        let state = model.static_equilibrium().unwrap().state;
        assert!(
            (model.deflection(&state, 0.0).0 - 10e-6).abs() < 1e-20,
            "{state:?}"
        );
    }

    /// The reference for round-off is the sum of moduli of the terms of a stretch: 30 m here.
    #[test]
    fn a_stretch_within_round_off_is_none() {
        let mut standing = RotatedStaticContact {
            side: 1.0,
            deflection: vec![2.0, -3.0],
            force: Vec::new(),
            stiffness: 1.0,
            shut: -4.0,
            shut_rate: 0.0,
        };
        for (beyond, stretched) in [(29e-12, false), (31e-12, true)] {
            standing.shut = -13.0 - beyond;
            assert_eq!(standing.is_stretched(&[1.0, 5.0]), stretched, "{beyond}");
        }
    }

    /// One stop is so close that the drive flank is not reached.
    #[test]
    fn a_contact_that_takes_all_the_load_opens_the_flank() {
        let mut structure = elastic();
        structure.contacts = vec![StructureContact::stop(&[0.6, 0.5, -0.3], 1e-6, 1e10)];
        assert_eq!(closed(&structure, 1.0), [2]);
    }

    /// Friction rotates the whole drive. This rotation deflects no contact beyond round-off. It must
    /// therefore not drift until it closes one.
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
        let size = alone.iter().fold(0.0_f64, |most, x| x.abs().max(most));
        for (shared, alone) in start.state.iter().zip(&alone) {
            assert!((shared - alone).abs() < 1e-13 * size, "{shared} {alone}");
        }
    }

    /// A free mass without flanks stays where it is, because no flank can carry a load.
    #[test]
    fn a_free_mass_without_flanks_stays() {
        let structure = ModalStructure {
            coupling: Some(Coupling {
                damping: vec![0.0; 4],
                gyroscopic: vec![0.0, 0.2, -0.2, 0.0],
                stiffness: vec![0.0; 4],
            }),
            ..ModalStructure::of_modes(&[0.0, 3.0], 0.1, &[0.5, 1.0], &[0.0, 0.0])
        };
        let point = OperatingPoint {
            load: 0.0,
            speed: 1.5,
        };
        let drive = fixtures::constant_mesh(OUT_OF_REACH, 9.0);
        let mut model = Model::new(&structure, &drive, point).unwrap();
        model.half_gap = 1.0;
        assert!(!model.has_flanks());
        let start = model.start(&InitialState::Static);
        assert_eq!(start.state, [0.0; 4]);
        assert_eq!(start.contact, ActiveSet::FREE);
    }

    /// Two rotations. Only a further mesh, which a drag closes, restrains the second one.
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
