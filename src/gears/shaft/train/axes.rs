//! Where do two gears meet in space, and along which directions?
//!
//! At the pitch point P the pitch surfaces roll on each other along the pitch line: the
//! axis direction for spur gears, the line from the apex of both cones through P for bevel gears.
//! m is the unit normal of that line in the plane of the axes, from the first gear to the
//! second. t is across that plane, in the direction of the first gear's motion at P. Drive flanks touch along
//! `n = cos α t + sin α m`. Coast flanks touch along `cos α t − sin α m`, mirrored about the plane of
//! the axes; their deflection is counted as that of the drive flanks. In a ring P is beyond the axis of the gear
//! inside. m points away from the ring's axis if the ring is the second gear, and towards it if the ring is the first.

use super::TrainError;
use crate::gear::FaceOverhang;
use nalgebra::{Rotation3, Vector3};

/// Axes with a sine of their angle below this are parallel.
const PARALLEL: f64 = 1e-9;

/// Part of the module by which the pitch circles of bevel gears may miss each other.
const TOUCHING: f64 = 0.01;

/// An axis with the frame of its shaft.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    origin: Vector3<f64>,
    /// Unit vectors x, y, z; z along the axis. For an axis along (0, 0, 1) these are the global unit vectors.
    frame: [Vector3<f64>; 3],
}

impl Axis {
    pub fn new(origin: [f64; 3], direction: [f64; 3]) -> Self {
        let along = Vector3::from(direction).normalize();
        let turn = Rotation3::rotation_between(&Vector3::z(), &along).unwrap_or_else(|| {
            Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
        Self {
            origin: Vector3::from(origin),
            frame: [turn * Vector3::x(), turn * Vector3::y(), along],
        }
    }

    /// Unit vector along the axis.
    pub fn along(&self) -> Vector3<f64> {
        self.frame[2]
    }

    /// The point at a position on the axis.
    pub fn at(&self, place: f64) -> Vector3<f64> {
        self.origin + self.along() * place
    }

    /// The point at a position on the axis, displaced along x and y.
    pub fn offset_point(&self, place: f64, [x, y]: [f64; 2]) -> Vector3<f64> {
        self.at(place) + self.frame[0] * x + self.frame[1] * y
    }

    /// The unit vectors x, y, z of the shaft's frame.
    pub fn components(&self) -> [[f64; 3]; 3] {
        self.frame.map(Into::into)
    }

    /// Components of a vector in the shaft's frame.
    pub fn local(&self, vector: Vector3<f64>) -> [f64; 3] {
        self.frame.map(|unit| unit.dot(&vector))
    }
}

/// A gear in space.
#[derive(Debug, Clone)]
pub(super) struct PlacedGear {
    pub name: String,
    pub axis: Axis,
    /// Position of its middle on the axis \[m\].
    pub at: f64,
    pub teeth: u32,
    /// Whether its teeth point towards its axis.
    pub internal: bool,
    /// Pitch radius \[m\].
    pub radius: f64,
    pub module: f64,
    pub width: f64,
}

impl PlacedGear {
    fn centre(&self) -> Vector3<f64> {
        self.axis.at(self.at)
    }

    /// Number of teeth, negative for internal ones.
    fn signed_teeth(&self) -> f64 {
        if self.internal { -f64::from(self.teeth) } else { f64::from(self.teeth) }
    }
}

/// Where two gears mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct PitchPoint {
    /// P \[m\].
    pub point: Vector3<f64>,
    /// Along the pitch line.
    pub pitch_line: Vector3<f64>,
    /// m, from the first gear to the second.
    pub across: Vector3<f64>,
    /// t for a first gear that rotates right-handed about its axis.
    pub forward: Vector3<f64>,
    /// Sign of the second gear's speed about its axis for a positive speed of the first one.
    pub sense: i64,
    /// Relative position of gears on parallel axes; `None` for bevel gears.
    pub parallel: Option<ParallelPlacement>,
}

/// Relative position of two gears on parallel axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParallelPlacement {
    /// Distance of the axes \[m\].
    pub centre_distance: f64,
    /// Width of the common face \[m\].
    pub width: f64,
    /// Length of each face beyond the common face, along the axis of the first gear.
    pub overhang: [FaceOverhang; 2],
    /// Whether the axes have the same direction.
    pub alike: bool,
}

impl PitchPoint {
    /// The pitch point of two gears.
    pub fn of(gears: [&PlacedGear; 2]) -> Result<Self, TrainError> {
        let [one, two] = gears.map(|gear| gear.axis.along());
        let internal = gears.iter().filter(|gear| gear.internal).count();
        let parallel = one.cross(&two).norm() < PARALLEL;
        let [few, many] = if gears[1].internal { gears } else { [gears[1], gears[0]] };
        let fits = internal == 0 || (internal == 1 && parallel && many.teeth > few.teeth);
        if !fits {
            return Err(TrainError::NotInside {
                gears: gears.map(|gear| gear.name.clone()),
            });
        }
        if parallel { Self::spur(gears) } else { Self::bevel(gears) }
    }

    fn spur(gears: [&PlacedGear; 2]) -> Result<Self, TrainError> {
        let names = || gears.map(|gear| gear.name.clone());
        let [first, second] = gears;
        let along = first.axis.along();
        let apart = second.centre() - first.centre();
        let axial = apart.dot(&along);
        let radial = apart - along * axial;
        let distance = radial.norm();
        if distance < TOUCHING * first.module {
            return Err(TrainError::OneAxis { gears: names() });
        }
        let gap = axial.abs() - 0.5 * (first.width + second.width);
        if gap > 0.0 {
            return Err(TrainError::FacesApart {
                gears: names(),
                gap,
            });
        }
        let lower = (-0.5 * first.width).max(axial - 0.5 * second.width);
        let upper = (0.5 * first.width).min(axial + 0.5 * second.width);
        let apart = radial / distance;
        let [z1, z2] = gears.map(PlacedGear::signed_teeth);
        let reach = distance * z1 / (z1 + z2);
        let inside = first.internal || second.internal;
        let alike = along.dot(&second.axis.along()) > 0.0;
        Ok(Self {
            point: first.centre() + apart * reach + along * (0.5 * (lower + upper)),
            pitch_line: along,
            across: if inside { -apart } else { apart },
            forward: along.cross(&(apart * reach.signum())),
            sense: if alike == inside { 1 } else { -1 },
            parallel: Some(ParallelPlacement {
                centre_distance: distance,
                width: upper - lower,
                overhang: [(0.0, first.width), (axial, second.width)].map(|(middle, width)| {
                    FaceOverhang {
                        before: lower - (middle - 0.5 * width),
                        behind: middle + 0.5 * width - upper,
                    }
                }),
                alike,
            }),
        })
    }

    fn bevel(gears: [&PlacedGear; 2]) -> Result<Self, TrainError> {
        let names = || gears.map(|gear| gear.name.clone());
        let axes = gears.map(|gear| gear.axis.along());
        let normal = axes[0].cross(&axes[1]).normalize();
        let [one, two] = gears.map(PlacedGear::centre);
        let distance = (two - one).dot(&normal).abs();
        let allowed = TOUCHING * gears[0].module;
        if distance > allowed {
            return Err(TrainError::SkewAxes {
                gears: names(),
                distance,
            });
        }
        // The points of each pitch circle in the plane of the axes; the closest two points touch.
        let points = [0, 1].map(|index| {
            let outward = normal.cross(&axes[index]);
            [1.0, -1.0].map(|side| (outward * side, gears[index]))
        });
        let at =
            |(outward, gear): (Vector3<f64>, &PlacedGear)| gear.centre() + outward * gear.radius;
        let pairs = points[0]
            .iter()
            .flat_map(|a| points[1].iter().map(move |b| (*a, *b)));
        let miss = |(a, b): &(_, _)| (at(*a) - at(*b)).norm();
        let nearest = pairs.min_by(|a, b| miss(a).total_cmp(&miss(b)));
        let Some((a, b)) = nearest.filter(|pair| miss(pair) <= allowed) else {
            return Err(TrainError::PitchCircles {
                gears: names(),
                apart: nearest.map_or(f64::NAN, |pair| miss(&pair)),
            });
        };
        let point = (at(a) + at(b)) * 0.5;
        // The apex: one + λ axes[0] = two + μ axes[1].
        let cross = axes[0].cross(&axes[1]);
        let apex = one + axes[0] * ((two - one).cross(&axes[1]).dot(&cross) / cross.norm_squared());
        let pitch_line = (point - apex).normalize();
        let across = (a.0 - pitch_line * a.0.dot(&pitch_line)).normalize();
        let [forward, second] = [axes[0].cross(&a.0), axes[1].cross(&b.0)];
        Ok(Self {
            point,
            pitch_line,
            across,
            forward,
            sense: if forward.dot(&second) > 0.0 { 1 } else { -1 },
            parallel: None,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn gear(origin: [f64; 3], direction: [f64; 3], teeth: u32) -> PlacedGear {
        PlacedGear {
            name: format!("z{teeth}"),
            axis: Axis::new(origin, direction),
            at: 0.0,
            teeth,
            internal: false,
            radius: 0.5 * 2e-3 * f64::from(teeth),
            module: 2e-3,
            width: 10e-3,
        }
    }

    #[test]
    fn spur_gears_roll_the_other_way_round() {
        let [a, b] = [
            gear([0.0; 3], [0.0, 0.0, 1.0], 20),
            gear([0.0, 0.05, 0.002], [0.0, 0.0, 2.0], 30),
        ];
        let pitch_point = PitchPoint::of([&a, &b]).unwrap();
        assert!((pitch_point.point - Vector3::new(0.0, 0.02, 0.001)).norm() < 1e-15);
        assert!((pitch_point.across - Vector3::y()).norm() < 1e-15);
        assert!((pitch_point.forward + Vector3::x()).norm() < 1e-15);
        assert_eq!(pitch_point.sense, -1);
        let turned = gear([0.0, 0.05, 0.002], [0.0, 0.0, -1.0], 30);
        assert_eq!(PitchPoint::of([&a, &turned]).unwrap().sense, 1);
    }

    /// A planet of 20 teeth inside a ring of 60: contact is beyond the planet's axis, both rotate in the same
    /// direction, and the planet pushes outwards.
    #[test]
    fn gears_roll_in_a_ring() {
        let along = [0.0, 0.0, 1.0];
        let planet = gear([0.04, 0.0, 0.0], along, 20);
        let ring = PlacedGear {
            internal: true,
            ..gear([0.0; 3], along, 60)
        };
        let pitch_point = PitchPoint::of([&planet, &ring]).unwrap();
        assert!((pitch_point.point - Vector3::new(0.06, 0.0, 0.0)).norm() < 1e-15);
        assert!((pitch_point.across - Vector3::x()).norm() < 1e-15);
        assert!((pitch_point.forward - Vector3::y()).norm() < 1e-15);
        assert_eq!(pitch_point.sense, 1);
        // If the ring drives, contact is at the same point, and the ring pushes the planet inwards.
        let pitch_point = PitchPoint::of([&ring, &planet]).unwrap();
        assert!((pitch_point.point - Vector3::new(0.06, 0.0, 0.0)).norm() < 1e-15);
        assert!((pitch_point.across + Vector3::x()).norm() < 1e-15);
        assert!((pitch_point.forward - Vector3::y()).norm() < 1e-15);
        let small = PlacedGear {
            internal: true,
            ..gear([0.0; 3], along, 20)
        };
        for gears in [[&planet, &small], [&ring, &ring]] {
            let error = PitchPoint::of(gears).unwrap_err();
            assert!(matches!(error, TrainError::NotInside { .. }));
        }
    }

    #[test]
    fn bevel_gears_touch_along_a_line_through_the_apex() {
        // Axes at right angles through the origin: pitch radii 20 and 30 mm.
        let a = gear([0.0, 0.0, -0.03], [0.0, 0.0, 1.0], 20);
        let b = gear([0.02, 0.0, 0.0], [1.0, 0.0, 0.0], 30);
        let pitch_point = PitchPoint::of([&a, &b]).unwrap();
        assert!((pitch_point.point - Vector3::new(0.02, 0.0, -0.03)).norm() < 1e-15);
        assert!((pitch_point.pitch_line - Vector3::new(2.0, 0.0, -3.0).normalize()).norm() < 1e-12);
        assert!(pitch_point.across.dot(&pitch_point.pitch_line).abs() < 1e-15);
        assert!(pitch_point.across.x > 0.0 && pitch_point.across.z > 0.0);
        // At P the first gear moves along +y. So does the second one for positive ω about +x:
        // ω x × (−0.03 z) = 0.03 ω y.
        assert!((pitch_point.forward - Vector3::y()).norm() < 1e-12);
        assert_eq!(pitch_point.sense, 1);
    }

    #[test]
    fn gears_that_cannot_mesh_are_told() {
        let a = gear([0.0; 3], [0.0, 0.0, 1.0], 20);
        let far = gear([0.05, 0.0, 0.02], [0.0, 0.0, 1.0], 30);
        let error = PitchPoint::of([&a, &far]).unwrap_err();
        assert!(matches!(error, TrainError::FacesApart { gap, .. } if (gap - 0.01).abs() < 1e-12));
        let skew = gear([0.02, 0.01, 0.03], [1.0, 0.0, 0.0], 30);
        let error = PitchPoint::of([&a, &skew]).unwrap_err();
        assert!(
            matches!(error, TrainError::SkewAxes { distance, .. } if (distance - 0.01).abs() < 1e-12)
        );
        let off = gear([0.02, 0.0, 0.035], [1.0, 0.0, 0.0], 30);
        let error = PitchPoint::of([&a, &off]).unwrap_err();
        assert!(
            matches!(error, TrainError::PitchCircles { apart, .. } if (apart - 0.005).abs() < 1e-12)
        );
        let same = gear([0.0, 0.0, 0.001], [0.0, 0.0, 1.0], 30);
        assert!(matches!(
            PitchPoint::of([&a, &same]).unwrap_err(),
            TrainError::OneAxis { .. }
        ));
    }
}
