//! Which contacts of a model are layers of a film, and which of them exclude each other?
//!
//! The film of oil of a flank is a row of layers: contacts without a spring, each with a constant damping over an
//! interval of the thickness of the film. Of the layers and the flank, at most one is closed.

use super::contact::{ActiveSet, COAST_FLANK};
use super::{Model, Release};

impl Model {
    /// Whether a contact is a layer of the film of a flank.
    pub fn is_of_film(&self, contact: usize) -> bool {
        self.contacts[contact].release == Release::Film
    }

    /// The flank to whose film a contact belongs. The contact may be a layer or the flank itself. `None` for
    /// other contacts, and without a film.
    fn film_of(&self, contact: usize) -> Option<usize> {
        let first = self.flank_springs - 2 * self.film_layers;
        match contact {
            _ if self.film_layers == 0 => None,
            0..=COAST_FLANK => Some(contact),
            _ if self.is_of_film(contact) => Some((contact - first) % 2),
            _ => None,
        }
    }

    /// The other contacts of the same film, which are never closed together with it.
    pub(super) fn others_of_film(&self, contact: usize) -> ActiveSet {
        let first = self.flank_springs - 2 * self.film_layers;
        let Some(flank) = self.film_of(contact) else {
            return ActiveSet::FREE;
        };
        let layers = (first + flank..self.flank_springs).step_by(2);
        let all = layers.chain([flank]);
        (all.filter(|other| *other != contact)).fold(ActiveSet::FREE, ActiveSet::toggled)
    }

    /// The layer that ends where a contact begins: for a layer the layer before it, for a flank the last
    /// layer. `None` for the first layer, for other contacts and without a film.
    pub fn layer_before(&self, contact: usize) -> Option<usize> {
        let first = self.flank_springs - 2 * self.film_layers;
        match contact {
            _ if self.film_layers == 0 => None,
            0..=COAST_FLANK => Some(self.flank_springs - 2 + contact),
            _ => (contact >= first + 2 && self.is_of_film(contact)).then(|| contact - 2),
        }
    }

    /// Whether two contacts belong to one film, so that they are never closed together.
    pub fn are_in_same_film(&self, one: usize, other: usize) -> bool {
        one != other
            && self
                .film_of(one)
                .is_some_and(|own| self.film_of(other) == Some(own))
    }

    /// Whether a contact is a passed layer: a later layer of its film, or the flank, is closed.
    pub fn is_passed(&self, contact: usize, active: ActiveSet) -> bool {
        let behind = |other: usize| {
            self.are_in_same_film(contact, other) && (other > contact || other <= COAST_FLANK)
        };
        self.film_layers > 0 && self.is_of_film(contact) && active.iter().any(behind)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::model::{Division, Drive, Film, FlankError, fixtures};

    fn film(layers: usize) -> Film {
        Film {
            coefficient: 2e-5,
            thickness: [50e-6, 1e-6],
            layers,
        }
    }

    /// At most one layer of a flank, or the flank, is closed. A layer is passed if a later one is closed.
    #[test]
    fn layers_of_a_flank_take_turns() {
        let drive = Drive {
            film: Some(film(3)),
            ..fixtures::two_level_mesh(1e-5)
        };
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[0.9, 0.4], &[0.9, 0.4]);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        assert_eq!((model.contacts.len(), model.flank_springs), (8, 8));
        let set = |contacts: &[usize]| contacts.iter().fold(ActiveSet::FREE, |s, &c| s.toggled(c));
        assert_eq!(model.toggled(set(&[2]), 4), set(&[4]));
        assert_eq!(model.toggled(set(&[6]), 0), set(&[0]));
        assert_eq!(model.toggled(set(&[0]), 0), ActiveSet::FREE);
        assert_eq!(model.toggled(set(&[4, 3]), 6), set(&[6, 3]));
        assert!(model.is_passed(2, set(&[4])) && model.is_passed(6, set(&[0])));
        assert!(!model.is_passed(4, set(&[2])) && !model.is_passed(3, set(&[0])));
        assert!(!model.is_passed(0, set(&[6])));
        let before = [0, 1, 2, 3, 4, 7].map(|contact| model.layer_before(contact));
        assert_eq!(before, [Some(6), Some(7), None, None, Some(2), Some(5)]);
        // The flanks carry the load, not the oil.
        assert!(model.bearing_contacts().iter().all(|own| own < 2));
    }

    /// A tooth lacks 20 µm in the second of three cycles. The layers end where its flank closes.
    #[test]
    fn layers_follow_a_faulty_tooth() {
        let mut drive = Drive {
            film: Some(film(3)),
            ..fixtures::two_level_mesh(1e-5)
        };
        let faulty = drive.mesh.iter().map(|division| Division {
            error: FlankError::series([20e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            ..*division
        });
        let faulty = faulty.collect();
        let cycles = [drive.mesh.clone(), faulty, drive.mesh.clone()];
        drive.tooth_cycles[0] = cycles.map(|first| vec![first]).to_vec();
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[0.9, 0.4], &[0.9, 0.4]);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        for cycle in 0..3 {
            let segments = model.segments_at(cycle, 0.0);
            for flank in 0..2 {
                let gap = |contact: usize| model.contacts[contact].gap(&segments[contact], 0.0)[0];
                let last = model.layer_before(flank).unwrap();
                let end = gap(last) + model.contacts[last].band;
                assert!((end - gap(flank)).abs() < 1e-18, "{cycle} {flank}");
            }
        }
    }
}
