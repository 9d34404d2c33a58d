//! What the gears of a manifest mesh like, for `atlas check`: contact ratio, backlash, stiffness over the cycle.

use super::point::number;
use crate::gear::Flanks;
use crate::manifest::{PointSpec, StiffnessSpec, StructureSource};
use crate::sweep::{LoadedMesh, build, loaded_mesh};
use serde_json::{Value, json};

/// The mesh of a grid's first point.
pub struct GearMesh {
    /// What the mean load makes of a mesh that is computed from the drawing; a sentence where nothing
    /// can be made.
    pub loaded: Option<Result<LoadedMesh, String>>,
    /// Smallest, mean and largest stiffness \[N/m\], where it is known.
    stiffness: Option<[f64; 3]>,
    /// Transverse contact ratio and overlap ratio of the drawing.
    ratios: Option<[f64; 2]>,
    /// Backlash along the line of action that the drawing leaves \[m\].
    backlash: Option<f64>,
    half_gap: f64,
    load: f64,
}

impl GearMesh {
    /// That of a point.
    pub fn of(point: &PointSpec) -> Self {
        let gears = point.model.source.gears();
        let flanks = gears.as_ref().and_then(|gears| Flanks::new(gears).ok());
        let loaded = match &point.mesh.stiffness {
            StiffnessSpec::Table(spec) => {
                let of_train = matches!(point.model.source, StructureSource::Train(_));
                let structure = of_train
                    .then(|| build::structure(&point.model).ok())
                    .flatten();
                let loaded = loaded_mesh(point, spec, structure.as_ref());
                Some(loaded.map_err(|error| error.to_string()))
            }
            _ => None,
        };
        let stiffness = match &loaded {
            Some(loaded) => loaded.as_ref().ok().map(|mesh| mesh.stiffness),
            None => imposed(&point.mesh.stiffness),
        };
        Self {
            stiffness,
            ratios: flanks.map(|flanks| [flanks.contact_ratio(), flanks.overlap_ratio()]),
            backlash: gears.and_then(|gears| gears.action_backlash().ok()),
            half_gap: point.mesh.half_gap,
            load: point.load,
            loaded,
        }
    }

    /// Head and text of its lines.
    pub fn lines(&self) -> Vec<(String, String)> {
        let mut lines = Vec::new();
        let mut gears = Vec::new();
        if let Some([contact, overlap]) = self.ratios {
            gears.push(if overlap == 0.0 {
                format!("contact ratio {contact:.3}")
            } else {
                format!("contact ratio {contact:.3}, overlap ratio {overlap:.3}")
            });
        }
        if let Some(Ok(loaded)) = &self.loaded {
            gears.push(format!(
                "{:.3} pairs on average at load {}",
                loaded.contact_ratio,
                number(self.load)
            ));
        }
        if let Some(backlash) = self.backlash {
            gears.push(match self.drawn_half_gap() {
                Some(_) => format!(
                    "the drawing gives a backlash of {:.4} µm along the line of action, a half gap of {:.4} µm; half gap used {:.4} µm",
                    1e6 * backlash,
                    0.5e6 * backlash,
                    1e6 * self.half_gap
                ),
                None => format!("the drawing gives no backlash; half gap used {:.4} µm", 1e6 * self.half_gap),
            });
        }
        if !gears.is_empty() {
            lines.push(("gears".to_owned(), gears.join("; ")));
        }
        // A stiffness that is given is told with its segments.
        if let (Some(_), Some([least, mean, most])) = (&self.loaded, self.stiffness) {
            lines.push((
                "stiffness".to_owned(),
                format!(
                    "{least:.4e} minimum, {mean:.4e} mean, {most:.4e} N/m maximum over the mesh cycle"
                ),
            ));
        }
        if let Some(Ok(LoadedMesh {
            course: Some((pieces, [stiffness, turning])),
            ..
        })) = &self.loaded
        {
            lines.push((
                "course".to_owned(),
                format!(
                    "{pieces} pieces; error times length in mesh cycles at most {stiffness:.0e} of the \
                     stiffness, {turning:.0e} of the position of the force"
                ),
            ));
        }
        lines
    }

    /// Half the backlash of the drawing \[m\], where that is more than round-off.
    fn drawn_half_gap(&self) -> Option<f64> {
        self.backlash
            .filter(|backlash| *backlash > 1e-6 * self.half_gap)
            .map(|backlash| 0.5 * backlash)
    }

    /// The same for programs.
    pub fn json(&self) -> Value {
        let loaded = self.loaded.as_ref();
        let course = loaded.and_then(|mesh| mesh.as_ref().ok()?.course);
        json!({
            "contact_ratio": self.ratios.map(|[contact, _]| contact),
            "overlap_ratio": self.ratios.map(|[_, overlap]| overlap),
            "contact_ratio_loaded": self.loaded.as_ref().and_then(|mesh| Some(mesh.as_ref().ok()?.contact_ratio)),
            "drawn_half_gap": self.drawn_half_gap(),
            "half_gap": self.half_gap,
            "stiffness_min": self.stiffness.map(|[least, ..]| least),
            "stiffness_mean": self.stiffness.map(|[_, mean, _]| mean),
            "stiffness_max": self.stiffness.map(|[.., most]| most),
            "course_pieces": course.map(|(pieces, _)| pieces),
            "course_stiffness_error": course.map(|(_, [stiffness, _])| stiffness),
            "course_turning_error": course.map(|(_, [_, turning])| turning),
        })
    }
}

/// Smallest, mean and largest of a stiffness that is given.
fn imposed(stiffness: &StiffnessSpec) -> Option<[f64; 3]> {
    let [least, most] = stiffness.extremes()?;
    Some([least, stiffness.mean()?, most])
}
