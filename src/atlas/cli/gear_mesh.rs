//! The meshes of a manifest's gears, for `atlas check`: contact ratio, backlash, stiffness over the cycle.

use super::point::number;
use crate::gear::Flanks;
use crate::manifest::{PointSpec, StiffnessSpec, StructureSource};
use crate::report::to_digits;
use crate::shaft::MeshLaw;
use crate::sweep::{LoadedMesh, Prepared, loaded_further_meshes, loaded_mesh};
use serde_json::{Value, json};

/// The mesh of a grid's first point.
pub struct GearMesh {
    /// The mesh under the load of the point; `None` if it is not computed from the drawing. An error is a sentence.
    pub loaded: Option<Result<LoadedMesh, String>>,
    /// Smallest, mean and largest stiffness \[N/m\], if known.
    stiffness: Option<[f64; 3]>,
    /// Transverse contact ratio and overlap ratio of the drawing.
    ratios: Option<[f64; 2]>,
    /// Backlash along the line of action from the drawing \[m\].
    backlash: Option<f64>,
    half_gap: f64,
    load: f64,
    /// Further meshes that are computed from the drawing, with the names of their gears.
    further: Vec<([String; 2], LoadedMesh)>,
}

impl GearMesh {
    /// The mesh of a point.
    pub fn of(point: &PointSpec, parts: &Prepared) -> Self {
        let gears = point.model.source.gears();
        let flanks = gears.as_ref().and_then(|gears| Flanks::new(gears).ok());
        let structure =
            if has_drawn_mesh(point) { parts.structure(&point.model).ok() } else { None };
        let structure = structure.as_deref();
        let loaded = match &point.mesh.stiffness {
            StiffnessSpec::Table(spec) => {
                let loaded = loaded_mesh(point, spec, structure, parts.meshes());
                Some(loaded.map_err(|error| error.to_string()))
            }
            _ => None,
        };
        let further =
            structure.map(|structure| loaded_further_meshes(point, structure, parts.meshes()));
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
            // If these meshes cannot be computed, the point fails too, and `check` prints the reason.
            further: further.and_then(Result::ok).unwrap_or_default(),
        }
    }

    /// Label and text of each line about the mesh.
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
        // The line `mesh` already shows a stiffness that the manifest gives.
        if let (Some(_), Some(stiffness)) = (&self.loaded, self.stiffness) {
            lines.push(("stiffness".to_owned(), over_cycle(stiffness)));
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
        let further = self.further.iter().map(|([driver, driven], mesh)| {
            let text = format!(
                "{driver} and {driven}: mean force {} N, {:.3} pairs on average, {}",
                to_digits(mesh.force, 4),
                mesh.contact_ratio,
                over_cycle(mesh.stiffness)
            );
            ("mesh of".to_owned(), text)
        });
        lines.extend(further);
        lines
    }

    /// Half the backlash of the drawing \[m\], if it exceeds round-off.
    fn drawn_half_gap(&self) -> Option<f64> {
        self.backlash
            .filter(|backlash| *backlash > 1e-6 * self.half_gap)
            .map(|backlash| 0.5 * backlash)
    }

    /// The mesh as JSON, for programs.
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
            "further_meshes": self.further.iter().map(further_json).collect::<Vec<_>>(),
        })
    }
}

/// Whether a mesh is computed from the drawing and its mean force needs the structure, because it depends on
/// drag and on the paths of the torque.
fn has_drawn_mesh(point: &PointSpec) -> bool {
    let first = matches!(point.mesh.stiffness, StiffnessSpec::Table(_));
    match &point.model.source {
        StructureSource::Modal(_) => false,
        StructureSource::Rigid(_) | StructureSource::Flexible(_) => first,
        StructureSource::Train(train) => {
            let mut further = train.meshes.iter();
            first || further.any(|mesh| matches!(mesh.law, MeshLaw::Drawn(_)))
        }
    }
}

/// Smallest, mean and largest stiffness over the mesh cycle, in words.
fn over_cycle([least, mean, most]: [f64; 3]) -> String {
    format!("{least:.4e} minimum, {mean:.4e} mean, {most:.4e} N/m maximum over the mesh cycle")
}

fn further_json((gears, mesh): &([String; 2], LoadedMesh)) -> Value {
    let [least, mean, most] = mesh.stiffness;
    json!({
        "gears": gears,
        "force": mesh.force,
        "contact_ratio_loaded": mesh.contact_ratio,
        "flank_error": mesh.flank_error,
        "stiffness_min": least,
        "stiffness_mean": mean,
        "stiffness_max": most,
    })
}

/// Smallest, mean and largest value of a stiffness that the manifest gives \[N/m\].
fn imposed(stiffness: &StiffnessSpec) -> Option<[f64; 3]> {
    let [least, most] = stiffness.extremes()?;
    Some([least, stiffness.mean()?, most])
}
