//! What are the names of the meshes, contacts and shafts of a train?

use super::speeds::Layout;
use super::{GearPlace, TrainDrive};
use crate::structure::SliderPart;

impl TrainDrive {
    /// Names of the first mesh and of every further one.
    pub fn mesh_names(&self) -> Vec<String> {
        let names = |gears: [GearPlace; 2]| {
            let [one, two] = gears.map(|place| &self.gear(place).name);
            format!("{one} and {two}")
        };
        self.pairs().map(names).collect()
    }

    /// Names of all contacts: drive flank and coast flank of the first mesh and of every further one, then stages of
    /// couplings, forward and backward, the states of their hysteresis, and stops.
    pub fn contact_names(&self) -> Vec<String> {
        let meshes = self.mesh_names().into_iter();
        let flanks = meshes
            .flat_map(|mesh| ["drive", "coast"].map(|side| format!("{side} flank of {mesh}")));
        let stages = self.couplings.iter().flat_map(|coupling| {
            let [one, two] = coupling.shafts.map(|shaft| &self.shafts[shaft].name);
            (1..)
                .zip(&coupling.stages)
                .flat_map(move |(number, stage)| {
                    let ways = stage.side.ways().iter();
                    ways.map(move |(_, way)| format!("stage {number} of {one} and {two}, {way}"))
                })
        });
        let elements = self.couplings.iter().flat_map(|coupling| {
            let [one, two] = coupling.shafts.map(|shaft| &self.shafts[shaft].name);
            (1..=coupling.hysteresis.len()).flat_map(move |number| {
                let element = format!("hysteresis {number} of {one} and {two}");
                SliderPart::ALL.map(|(_, part)| format!("{element}, {part}"))
            })
        });
        let stops = self.stops.iter();
        let stops = stops.map(|stop| format!("stop of {}", self.shafts[stop.shaft].name));
        flanks.chain(stages).chain(elements).chain(stops).collect()
    }

    /// Shafts besides those of the first mesh, one per speed, with their turns `[p, q]`: p in q cycles of the first
    /// mesh.
    pub(super) fn further_shafts(&self, layout: &Layout) -> Vec<(String, [u32; 2])> {
        let mut known: Vec<_> = (self.gears.iter())
            .map(|&place| layout.turns[self.body_of(place)])
            .collect();
        let shafts = self.shafts.iter().zip(&layout.turns);
        shafts
            .filter_map(|(shaft, turns)| {
                let new = !known.contains(turns);
                known.push(*turns);
                Some((format!("shaft {}", shaft.name), turns.filter(|_| new)?))
            })
            .collect()
    }
}
