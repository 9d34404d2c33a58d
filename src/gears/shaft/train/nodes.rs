//! From the description of a train to an assembly with its nodes.

use super::frames::arm_vector;
use super::speeds::Layout;
use super::{GearPlace, Planet, PlanetarySet, TrainDrive, TrainError, TrainShaft};
use crate::shaft::assembly::{Assembly, Freedom};
use crate::shaft::beam::{Material, Section};
use crate::shaft::drive::{Motion, Support};
use crate::shaft::error::ShaftError;
use std::collections::BTreeSet;

/// The finite-element assembly of a train, and the nodes of its parts in it.
#[derive(Debug)]
pub(super) struct Assembled {
    pub assembly: Assembly,
    shafts: Vec<ShaftNodes>,
    /// Node of each loose gear.
    pub loose: Vec<usize>,
    /// Node of the carrier at each planet's pin.
    pub pins: Vec<usize>,
    /// Bearings with their names.
    pub supports: Vec<(String, Support)>,
    /// Every freedom of the housing.
    pub housing: Vec<(usize, Freedom)>,
}

/// The nodes of one shaft.
#[derive(Debug)]
struct ShaftNodes {
    /// Nodes by position \[m\], ascending; for a rigid shaft its carried nodes.
    places: Vec<(f64, usize)>,
    /// The nodes that are not carried by another node.
    independent: std::ops::Range<usize>,
}

/// Names of the kinds of parts on a shaft, for messages.
const STANDING: [&str; 5] = [
    "a gear",
    "a disc",
    "a bearing",
    "the torque",
    "a coupling, a stop or a planet",
];

impl TrainDrive {
    /// Adds all parts of the train to an assembly.
    pub(super) fn assembled(&self, layout: &Layout) -> Result<Assembled, ShaftError> {
        self.check_size()?;
        let mut assembly = Assembly::new();
        let mut shafts = Vec::with_capacity(self.shafts.len());
        let mut supports = Vec::new();
        let joined = self.housing.as_ref();
        let housing = joined.map_or(Ok(Vec::new()), |joined| {
            joined.housing.assembled(&mut assembly)
        })?;
        for (index, shaft) in self.shafts.iter().enumerate() {
            let places = self.places(index)?;
            assembly.turn(if self.gyroscopic { layout.speeds[index] } else { 0.0 });
            let nodes = if shaft.sections.is_empty() {
                rigid(&mut assembly, shaft, &places)?
            } else {
                self.flexible(&mut assembly, shaft, &places)?
            };
            nodes.fix(&mut assembly, shaft)?;
            for (at, disc) in &shaft.discs {
                // A body with only polar inertia is a machine behind a coupling, which lets the shaft tilt
                // without the machine.
                if disc.mass == 0.0 && disc.transverse_inertia == 0.0 {
                    assembly.add_polar_inertia(nodes.at(*at), disc.polar_inertia)?
                } else {
                    assembly.add_disc(nodes.at(*at), *disc)?
                }
            }
            for gear in shaft.gears.iter().filter(|gear| gear.loose.is_none()) {
                assembly.add_disc(nodes.at(gear.at), gear.body)?;
            }
            for (number, (at, bearing)) in (1..).zip(&shaft.bearings) {
                let axis = &layout.axes[index];
                let base = joined.and_then(|joined| joined.node_under([index, number - 1]));
                let base = match (base, bearing.pedestal) {
                    (Some(node), _) => Some(assembly.add_turned_node(node, axis.components())?),
                    (None, Some(pedestal)) => Some(pedestal.add(&mut assembly)?),
                    (None, None) => None,
                };
                let support = Support::add(&mut assembly, nodes.at(*at), base, *bearing)?;
                supports.push((format!("{} {number}", shaft.name), support));
            }
            assembly.add_drag(nodes.at(shaft.torque_at), None, shaft.drag.viscous)?;
            shafts.push(nodes);
        }
        let mut loose = Vec::new();
        for (number, place) in self.loose_gears().enumerate() {
            let speed = layout.speeds[self.shafts.len() + number];
            assembly.turn(if self.gyroscopic { speed } else { 0.0 });
            let on = shafts[place.shaft].at(self.gear(place).at);
            let (node, support) = self.loose(&mut assembly, place, on)?;
            supports.extend(support.map(|support| (self.gear(place).name.clone(), support)));
            loose.push(node);
        }
        for coupling in &self.couplings {
            let ends = [0, 1].map(|end| shafts[coupling.shafts[end]].at(coupling.at[end]));
            let [across, along, tilt, twist] = coupling.stiffness;
            let springs = [across, across, along, tilt, tilt, twist];
            assembly.add_spring_between(ends[0], ends[1], springs)?;
            assembly.add_drag(ends[0], Some(ends[1]), coupling.damping)?;
        }
        let mut pins = Vec::new();
        for (_, set, planet) in self.planets() {
            let (pin, support) = self.pin(&mut assembly, (set, planet), layout, &shafts)?;
            supports.push((self.shafts[planet.shaft].name.clone(), support));
            pins.push(pin);
        }
        let mut assembled = Assembled {
            assembly,
            shafts,
            loose,
            pins,
            supports,
            housing,
        };
        self.turn_with_carriers(&mut assembled, layout)?;
        Ok(assembled)
    }

    /// Positions of all parts on a shaft, which need nodes, ascending.
    pub(super) fn places(&self, index: usize) -> Result<Vec<f64>, TrainError> {
        let shaft = &self.shafts[index];
        let ends = (self.couplings.iter())
            .flat_map(|coupling| coupling.shafts.into_iter().zip(coupling.at))
            .chain(self.stops.iter().map(|stop| (stop.shaft, stop.at)))
            .chain(self.planetary.iter().map(|set| (set.carrier, set.at)))
            .filter(|&(of, _)| of == index);
        let standing: [Vec<f64>; 5] = [
            shaft.gears.iter().map(|gear| gear.at).collect(),
            shaft.discs.iter().map(|disc| disc.0).collect(),
            shaft.bearings.iter().map(|bearing| bearing.0).collect(),
            vec![shaft.torque_at],
            ends.map(|(_, at)| at).collect(),
        ];
        let length = shaft.length();
        let mut places = Vec::new();
        for (what, all) in STANDING.into_iter().zip(standing) {
            for at in all {
                let inside = (-1e-9 * length..=length * (1.0 + 1e-9)).contains(&at);
                if !(inside || shaft.sections.is_empty()) {
                    return Err(TrainError::OffShaft {
                        shaft: shaft.name.clone(),
                        what,
                        at,
                        length,
                    });
                }
                places.push(at);
            }
        }
        places.sort_by(f64::total_cmp);
        Ok(places)
    }

    /// The first element of every stretch of a flexible shaft between neighbouring positions at which
    /// torque enters or leaves: gears that are fixed to it, couplings, motor and load.
    pub(super) fn stretches(&self, index: usize, assembled: &Assembled) -> Vec<Torsion> {
        let shaft = &self.shafts[index];
        let ends = (self.couplings.iter())
            .flat_map(|coupling| coupling.shafts.into_iter().zip(coupling.at))
            .filter(|&(of, _)| of == index);
        let gears = shaft.gears.iter().filter(|gear| gear.loose.is_none());
        let mut places: Vec<f64> = (ends.map(|(_, at)| at))
            .chain(gears.map(|gear| gear.at))
            .chain([shaft.torque_at])
            .collect();
        places.sort_by(f64::total_cmp);
        let mut starts: Vec<usize> = (places.iter())
            .map(|&at| assembled.shafts[index].position(at))
            .collect();
        starts.dedup();
        starts.pop();
        (starts.into_iter())
            .filter_map(|start| self.torsion(shaft, &assembled.shafts[index].places[start..]))
            .collect()
    }

    /// The torsion spring between the first two of these nodes of a flexible shaft, given with their positions \[m\].
    /// `None` for a single node.
    fn torsion(&self, shaft: &TrainShaft, nodes: &[(f64, usize)]) -> Option<Torsion> {
        let [(from, first), (to, second), ..] = *nodes else {
            return None;
        };
        let middle = 0.5 * (from + to);
        let mut end = 0.0;
        let section = shaft.sections.iter().find(|section| {
            end += section.length;
            middle < end
        })?;
        let polar = Section::hollow(shaft.outer_at(section, middle), section.inner)
            .ok()?
            .polar_moment();
        Some(Torsion {
            nodes: [first, second],
            stiffness: self.shear_modulus * polar / (to - from),
        })
    }

    /// A shaft of beam elements, none longer than the limit of its section.
    fn flexible(
        &self,
        assembly: &mut Assembly,
        shaft: &TrainShaft,
        places: &[f64],
    ) -> Result<ShaftNodes, ShaftError> {
        let material = Material {
            young_modulus: self.young_modulus,
            shear_modulus: self.shear_modulus,
            density: self.density,
        };
        let mut nodes = vec![(0.0, assembly.add_node())];
        let first = nodes[0].1;
        for stretch in shaft.stretches(places) {
            let section = &shaft.sections[stretch.section];
            let kind = Section::hollow(stretch.outer_diameter, section.inner)?;
            let (from, length) = (stretch.from, stretch.to - stretch.from);
            let fresh: Vec<f64> = (0..=stretch.elements as usize)
                .map(|step| from + length * step as f64 / stretch.elements)
                .collect();
            assembly.continue_shaft(&fresh, kind, material, self.shear_coefficient)?;
            let last = nodes[nodes.len() - 1].1;
            nodes.extend(fresh[1..].iter().copied().zip(last + 1..));
        }
        let last = nodes[nodes.len() - 1].1;
        Ok(ShaftNodes {
            places: nodes,
            independent: first..last + 1,
        })
    }

    /// The node of a planet's pin on the carrier, and the planet's bearing on it.
    fn pin(
        &self,
        assembly: &mut Assembly,
        (set, planet): (&PlanetarySet, &Planet),
        layout: &Layout,
        shafts: &[ShaftNodes],
    ) -> Result<(usize, Support), ShaftError> {
        let [x, y] = arm_vector(&layout.axes, set, planet.shaft);
        let nodes = &shafts[set.carrier];
        let (body, along) = if self.shafts[set.carrier].sections.is_empty() {
            (nodes.independent.start, set.at)
        } else {
            (nodes.at(set.at), 0.0)
        };
        let pin = assembly.add_offset_node(body, [x, y, along])?;
        let node = shafts[planet.shaft].at(0.0);
        let support = Support::add(assembly, node, Some(pin), set.bearing)?;
        Ok((pin, support))
    }

    /// A gear that runs loose at a node of its shaft, and its bearing.
    fn loose(
        &self,
        assembly: &mut Assembly,
        place: GearPlace,
        on: usize,
    ) -> Result<(usize, Option<Support>), ShaftError> {
        let gear = self.gear(place);
        let node = assembly.add_node();
        assembly.add_disc(node, gear.body)?;
        let Some(loose) = &gear.loose else {
            return Ok((node, None));
        };
        // The bearing of the gear is as rigid as the mounts of the shaft.
        for freedom in self.shafts[place.shaft].motion.fixed_freedoms() {
            assembly.fix(node, *freedom)?;
        }
        let support = Support::add(assembly, node, Some(on), loose.bearing)?;
        assembly.add_drag(node, Some(on), loose.drag.viscous)?;
        Ok((node, Some(support)))
    }
}

/// An element between two nodes that twists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Torsion {
    pub nodes: [usize; 2],
    /// \[N m/rad\]
    pub stiffness: f64,
}

impl Torsion {
    /// Torque from the first node to the second, positive in the direction of rotation.
    pub fn terms(&self, sense: f64) -> Vec<(usize, Freedom, f64)> {
        let [from, to] = self.nodes;
        let stiffness = sense * self.stiffness;
        vec![
            (from, Freedom::RotationZ, stiffness),
            (to, Freedom::RotationZ, -stiffness),
        ]
    }
}

/// A shaft without sections: one body that carries everything.
fn rigid(
    assembly: &mut Assembly,
    shaft: &TrainShaft,
    places: &[f64],
) -> Result<ShaftNodes, ShaftError> {
    let bodies = shaft.discs.iter().map(|disc| &disc.1);
    let gears = shaft.gears.iter().filter(|gear| gear.loose.is_none());
    let mut inertia = 0.0;
    for disc in bodies.chain(gears.map(|gear| &gear.body)) {
        inertia += match shaft.motion {
            Motion::Rotation => disc.polar_inertia,
            Motion::All | Motion::Translation | Motion::Lateral | Motion::None => disc.mass,
        };
    }
    if inertia == 0.0 && shaft.motion != Motion::None {
        return Err(ShaftError::Train(TrainError::NoInertia {
            shaft: shaft.name.clone(),
        }));
    }
    let body = assembly.add_node();
    let mut nodes = Vec::with_capacity(places.len());
    for &at in places {
        nodes.push((at, assembly.add_carried_node(body, at)?));
    }
    Ok(ShaftNodes {
        places: nodes,
        independent: body..body + 1,
    })
}

impl ShaftNodes {
    /// The node nearest to a position.
    fn at(&self, place: f64) -> usize {
        (self.places.get(self.position(place))).map_or(self.independent.start, |node| node.1)
    }

    /// Index of the node nearest to a position.
    fn position(&self, place: f64) -> usize {
        let away = |position: &usize| (self.places[*position].0 - place).abs();
        (0..self.places.len())
            .min_by(|a, b| away(a).total_cmp(&away(b)))
            .unwrap_or(0)
    }

    /// Fixes the motions that are not free.
    fn fix(&self, assembly: &mut Assembly, shaft: &TrainShaft) -> Result<(), ShaftError> {
        for node in self.independent.clone() {
            for freedom in shaft.motion.fixed_freedoms() {
                assembly.fix(node, *freedom)?;
            }
        }
        let fixed = match shaft.motion {
            Motion::All | Motion::Translation | Motion::Rotation => return Ok(()),
            Motion::None => self.independent.clone(),
            Motion::Lateral if self.independent.len() > 1 => {
                let node = self.at(shaft.torque_at);
                node..node + 1
            }
            Motion::Lateral => self.independent.clone(),
        };
        for node in fixed {
            assembly.fix(node, Freedom::RotationZ)?;
        }
        Ok(())
    }
}

impl Assembled {
    /// The node at a position of a shaft.
    pub fn at(&self, shaft: usize, place: f64) -> usize {
        self.shafts[shaft].at(place)
    }

    /// The node of a gear.
    pub fn gear(&self, train: &TrainDrive, place: GearPlace) -> usize {
        let loose = train.loose_gears().position(|other| other == place);
        loose.map_or_else(
            || self.at(place.shaft, train.gear(place).at),
            |number| self.loose[number],
        )
    }

    /// All nodes of the marked shafts.
    pub fn nodes_of(&self, marked: &[bool]) -> BTreeSet<usize> {
        let shafts = self
            .shafts
            .iter()
            .zip(marked)
            .filter(|(_, marked)| **marked);
        let nodes = shafts.flat_map(|(shaft, _)| {
            let carried = shaft.places.iter().map(|(_, node)| *node);
            shaft.independent.clone().chain(carried)
        });
        nodes.collect()
    }

    /// The nodes of a shaft that are not carried by another node.
    pub fn independent_nodes(&self, shaft: usize) -> std::ops::Range<usize> {
        self.shafts[shaft].independent.clone()
    }
}
