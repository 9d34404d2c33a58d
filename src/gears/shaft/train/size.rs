//! How many finite elements does a train have? The count precedes the assembly, for elements of any size.

use super::{TrainDrive, TrainError, TrainShaft};

/// Largest number of degrees of freedom of a train. The finest flexible drive has 3612. The dense matrices of 4000
/// degrees of freedom take about 1.2 GB.
const MOST_FREEDOMS: f64 = 4000.0;

/// Largest number of beam elements of a train, including those of held shafts.
const MOST_ELEMENTS: f64 = 4000.0;

/// Number of matrices in memory during the solution for the modes: mass and stiffness, three of coupling, four of the
/// dense solution.
const MATRICES: f64 = 9.0;

/// The end of a hub gets no separate node if another node is within this part of the outer diameter: an element much
/// shorter than the others would only cost accuracy.
const SAME_NODE: f64 = 1e-3;

/// Freedoms of a node.
const NODE_FREEDOMS: f64 = 6.0;

/// A part of a flexible shaft between neighbouring positions and ends of sections, in equal elements.
#[derive(Debug, Clone, Copy)]
pub(super) struct ElementRun {
    /// Section of the shaft.
    pub section: usize,
    /// Start \[m\].
    pub from: f64,
    /// End \[m\].
    pub to: f64,
    /// Outer diameter, hubs included \[m\].
    pub outer_diameter: f64,
    /// Number of elements, an integer as a float, as it may exceed integer types if a unit is wrong.
    pub elements: f64,
}

impl TrainShaft {
    /// Largest length of a beam element of a section \[m\] at this outer diameter \[m\].
    fn longest_element(&self, section: usize, outer_diameter: f64) -> f64 {
        let section = &self.sections[section];
        section.element.or(self.element).unwrap_or(outer_diameter)
    }

    /// The stretches of a flexible shaft with nodes at these `places` \[m\], ascending, and at the ends of hubs.
    pub(super) fn stretches(&self, places: &[f64]) -> Vec<ElementRun> {
        let near = 1e-9 * self.length();
        let mut stretches = Vec::new();
        let mut end = 0.0;
        for (section, shaft_section) in self.sections.iter().enumerate() {
            let start = end;
            end = start + shaft_section.length;
            let inside = |at: &&f64| start + near < **at && **at < end - near;
            let mut stations: Vec<f64> = places.iter().filter(inside).copied().collect();
            stations.push(end);
            stations.dedup_by(|a, b| (*a - *b).abs() <= near);
            let hubs = self
                .gears
                .iter()
                .filter_map(|gear| Some((gear.hub?, gear.at)));
            for at in hubs.flat_map(|(hub, at)| hub.ends(at)) {
                let known = stations.iter().chain([&start]);
                let apart = known
                    .map(|other| (at - other).abs())
                    .fold(f64::INFINITY, f64::min);
                if inside(&&at) && apart > SAME_NODE * shaft_section.outer {
                    stations.push(at);
                }
            }
            stations.sort_by(f64::total_cmp);
            let mut from = start;
            for to in stations {
                let outer_diameter = self.outer_at(shaft_section, 0.5 * (from + to));
                let elements = (to - from) / self.longest_element(section, outer_diameter);
                stretches.push(ElementRun {
                    section,
                    from,
                    to,
                    outer_diameter,
                    elements: (elements * (1.0 - 1e-9)).ceil().max(1.0),
                });
                from = to;
            }
        }
        stretches
    }
}

impl TrainDrive {
    /// Checks that the matrices of the train are not too large.
    ///
    /// # Errors
    /// [`TrainError::TooFine`], [`TrainError::OffShaft`].
    pub(super) fn check_size(&self) -> Result<(), TrainError> {
        let mut elements = 0.0;
        let of_housing = (self.housing.as_ref()).map_or(0, |joined| joined.housing.freedoms());
        let mut freedoms = NODE_FREEDOMS * self.loose_gears().count() as f64 + of_housing as f64;
        let mut finest = ([0; 2], 0.0);
        for (index, shaft) in self.shafts.iter().enumerate() {
            let of_node = match (shaft.motion.may_deflect(), shaft.motion.may_rotate()) {
                (true, _) => NODE_FREEDOMS,
                (false, turns) => f64::from(u8::from(turns)),
            };
            let mut of_section = vec![0.0; shaft.sections.len()];
            for stretch in shaft.stretches(&self.places(index)?) {
                of_section[stretch.section] += stretch.elements;
            }
            for (section, &count) in of_section.iter().enumerate() {
                if count > finest.1 {
                    finest = ([index, section], count);
                }
            }
            let total: f64 = of_section.iter().sum();
            elements += total;
            freedoms += of_node * (total + 1.0);
        }
        // Written so that a NaN is rejected.
        if freedoms <= MOST_FREEDOMS && elements <= MOST_ELEMENTS {
            return Ok(());
        }
        let (place, elements_of_section) = finest;
        let shaft = &self.shafts[place[0]];
        Err(TrainError::TooFine {
            place,
            shaft: shaft.name.clone(),
            element: shaft.longest_element(place[1], shaft.sections[place[1]].outer),
            elements_of_section,
            elements,
            freedoms,
            gigabytes: 1e-9 * MATRICES * 8.0 * freedoms * freedoms,
        })
    }
}
