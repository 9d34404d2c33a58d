//! `[mesh.film]`: the film of oil between the flanks.

use super::backlash::MeshContext;
use super::sliders::{Excluded, exclude, excluded_kernel};
use crate::gear::OilFilm;
use crate::manifest::reader::Section;
use crate::manifest::spec::MeshSpec;
use crate::model::Film;

/// Keys that cannot be combined with a film.
const EXCLUDED: [Excluded<'_>; 2] = [
    excluded_kernel(
        "is a kernel that cannot follow a film of oil",
        "set kernel = \"volterra\" or \"auto\", or remove mesh.film",
    ),
    (
        "",
        "continuation",
        &[],
        "is not available: orbits through a film of oil cannot be followed over a parameter",
        "remove the table, or mesh.film",
    ),
];

/// Reports keys that cannot be combined with the film of a mesh.
pub(super) fn check(root: &Section, mesh: Option<&MeshSpec>) {
    if mesh.is_some_and(|mesh| mesh.film.is_some()) {
        exclude(root, &EXCLUDED, "not with a film of oil");
    }
}

/// Whether there is a film, whose radii come from the drawing of the gears.
pub(super) fn wants_gears(section: &Section) -> bool {
    section.has("film")
}

/// The film; an inner `None` without a film, an outer one if there are faults, which have been reported.
pub(super) fn read(mesh: &Section, mesh_context: MeshContext<'_>) -> Option<Option<Film>> {
    let Some(section) = mesh.child("film")? else {
        return Some(None);
    };
    let viscosity = section.quantity("viscosity");
    let widest = section.quantity("thickness");
    let least = section.quantity("least_thickness");
    let layers = section.integer("layers");
    let (widest, least) = (widest?, least?);
    let refuse = |key: &str, message: String, label: &str, remedy: &'static str| {
        section
            .inconsistent(key, message)
            .label(label)
            .remedy(remedy)
            .fail(section.issues)
    };
    if widest <= least {
        let message = "the film must be thicker where it begins than where the flanks touch";
        return refuse(
            "thickness",
            message.to_owned(),
            "not above least_thickness",
            "raise mesh.film.thickness above mesh.film.least_thickness",
        );
    }
    let Some(gears) = mesh_context.gears else {
        if mesh_context.faulty_drawing || mesh_context.source.is_none() {
            return None;
        }
        let message = "the film of oil needs the radii and the width of the drawing of a pair on parallel axes";
        return refuse(
            "viscosity",
            message.to_owned(),
            "no drawing",
            "describe the gears in [gear], or remove mesh.film",
        );
    };
    let oil = OilFilm {
        viscosity: viscosity?,
        thickness: [widest, least],
        layers: layers?,
    };
    match oil.between(gears) {
        Ok(film) => Some(Some(film)),
        Err(fault) => refuse(
            "viscosity",
            format!("the drawing does not determine the film of oil: {fault}"),
            "no radii of curvature",
            "correct [gear], or remove mesh.film",
        ),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::manifest;
    use std::path::Path;

    const QUICKSTART: &str = include_str!("../../../../manifests/quickstart.toml");
    const MODAL: &str = include_str!("../../../../tests/manifests/modal.toml");

    /// The film of a manifest with these lines of `[mesh.film]`, or the messages.
    fn film(manifest: &str, lines: &str) -> Result<Option<crate::model::Film>, String> {
        let folder = Path::new(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../tests/manifests"
        ));
        let text = format!("{manifest}\n[mesh.film]\n{lines}\n");
        manifest::parse(&text, "test.toml", folder)
            .map(|job| job.points.at(0).mesh.film)
            .map_err(|errors| errors.to_string())
    }

    /// 20/30 teeth of 4 mm and 20°: R = 40 · 60 sin 20°/100 mm.
    #[test]
    fn a_film_has_the_radii_of_the_drawing() {
        let found = film(QUICKSTART, "viscosity = \"20 mPa*s\"")
            .unwrap()
            .unwrap();
        let radius = 24e-3 * 20f64.to_radians().sin();
        let exact = 13.328_65 * 20e-3 * 20e-3 * radius.powf(1.5);
        assert!((found.coefficient / exact - 1.0).abs() < 1e-6);
        assert_eq!((found.thickness, found.layers), ([50e-6, 1e-6], 5));
        let lines =
            "viscosity = 0.1\nlayers = 8\nthickness = \"30 um\"\nleast_thickness = \"2 um\"";
        let found = film(QUICKSTART, lines).unwrap().unwrap();
        assert_eq!((found.thickness, found.layers), ([30e-6, 2e-6], 8));
    }

    #[test]
    fn films_with_faults_are_refused() {
        for (lines, expected) in [
            ("layers = 5", "mesh.film.viscosity"),
            ("viscosity = 0.02\nlayers = 0", "mesh.film.layers"),
            ("viscosity = \"20 mm\"", "viscosity"),
            (
                "viscosity = 0.02\nthickness = \"1 um\"",
                "raise mesh.film.thickness",
            ),
            ("viscosity = 0.02\ndepth = 1", "depth"),
            (
                "viscosity = 0.02\n[continuation]\nstarts = 5",
                "not with a film of oil",
            ),
        ] {
            let found = film(QUICKSTART, lines).unwrap_err();
            assert!(found.contains(expected), "{lines}: {found}");
        }
        let closed_modes = QUICKSTART.replacen("[run] ", "[run]\nkernel = \"closed_modes\" #", 1);
        let found = film(&closed_modes, "viscosity = 0.02").unwrap_err();
        assert!(found.contains("cannot follow a film"), "{found}");
        let found = film(MODAL, "viscosity = 0.02").unwrap_err();
        assert!(
            found.contains("drawing of a pair on parallel axes"),
            "{found}"
        );
    }
}
