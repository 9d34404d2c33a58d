//! The keys of the table `[model]`.

use crate::manifest::schema::key::{
    ANY, BELOW_ONE, Key, Kind, POSITIVE, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{Length, Ratio};

/// Model kinds: the rigid-body tiers, flexible shafts, trains, modes from a file.
const MODEL_KINDS: [&str; 7] = [
    "torsional",
    "translational",
    "tilting",
    "pedestal",
    "flexible",
    "train",
    "modal",
];

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("model")
        .about("Source of the structure, and number of its modes."),
    choice("model.kind", &MODEL_KINDS, r#""flexible""#)
        .about("Kind of model, which sets the free motions of the drive. Rigid shafts: `torsional` (2 degrees of \
                freedom: rotations), `translational` (6: also the radial motion of both gears), `tilting` (12: also \
                axial motion and tilts), `pedestal` (20: also the bearing pedestals). `flexible`: shafts of \
                Timoshenko beams. `train`: any number of shafts and gears, given in [train]. `modal`: the modes in a \
                file."),
    integer("model.modes", 2.0, 1000.0, "12")
        .otherwise("40 with `flexible` and `train`, or fewer if the drive has fewer; all degrees of freedom of a rigid kind")
        .about("Number of modes computed, the lowest ones of the drive. With kind = \"modal\", the file gives the modes."),
    integer("model.retained", 1.0, 1000.0, "20").otherwise("all of `model.modes`")
        .about("Number of computed modes that are kept, the lowest first. The two rigid rotations of a drive given by \
                its drawing must be kept."),
    key("model.mta", Kind::Boolean, ANY, "true").or("false")
        .about("Mode truncation augmentation: replace the omitted modes by their residual flexibility at the mesh. It \
                matters if `retained` is less than `modes`."),
    quantity("model.damping", Ratio, BELOW_ONE, "0.02").or("0.01")
        .about("Modal damping ratio of every elastic mode. Rigid rotations are undamped."),
    key("model.damping_overrides", Kind::List("tables"), ANY, "[{ mode = 7, ratio = 0.02 }]").or("[]")
        .about("Modes with a damping ratio other than `model.damping`, one table per mode."),
    table("model.damping_overrides.*"),
    integer("model.damping_overrides.*.mode", 1.0, 1000.0, "7")
        .about("Number of the mode, counted from 1 in ascending frequency. The rigid rotations come first \
                and stay undamped."),
    quantity("model.damping_overrides.*.ratio", Ratio, BELOW_ONE, "0.02")
        .about("Damping ratio of this mode."),
    key("model.gyroscopic", Kind::Boolean, ANY, "true").or("false")
        .about("Include gyroscopic moments of tilting shafts and gear bodies. They couple tilts about x and y in \
                proportion to speed. Without them, as usual in models of gear rattle, the modes are the modes of the \
                drive at rest and stay uncoupled. They matter if polar inertia times speed approaches transverse \
                inertia times the frequency of a tilting mode. The end inertia is behind a coupling, so it does not \
                tilt and has no gyroscopic moment."),
    key("model.file", Kind::Text, ANY, r#""drive.modal.toml""#)
        .otherwise("none; required with kind = \"modal\"")
        .about("Path of the modal file, relative to the folder of the manifest. Only with kind = \"modal\"."),
    quantity("model.length", Length, POSITIVE, r#""1 mm""#)
        .otherwise("the largest gap of a contact, or static deflection by a [[harmonic_load]]")
        .about("Scale of lengths of an oscillator: the order of magnitude of its motion. Tolerances and displacements that \
                other keys measure in half gaps are measured by it. Only with a modal file without `mesh`."),
];
