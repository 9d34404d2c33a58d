//! `[model]`.

use crate::manifest::schema::key::{
    ANY, BELOW_ONE, Key, Kind, choice, integer, key, quantity, table,
};
use crate::units::Dimension::Ratio;

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
        .about("Where the structure comes from, and how many of its modes are kept."),
    choice("model.kind", &MODEL_KINDS, r#""flexible""#)
        .about("What of the drive may move. Rigid shafts: `torsional` (2 degrees of freedom, rotations), \
                `translational` (6, and the radial motion of both gears), `tilting` (12, and axial motion \
                and tilts), `pedestal` (20, and the bearing pedestals). `flexible`: shafts of Timoshenko \
                beams. `train`: any number of shafts and gears, as [train] describes them. `modal`: the modes of a \
                file."),
    integer("model.modes", 2.0, 1000.0, "12")
        .otherwise("40 with `flexible` and `train`, or as many as there are; all degrees of freedom of a rigid kind")
        .about("How many of the lowest modes of the assembled drive are computed. The modal kind has \
                those of its file."),
    integer("model.retained", 1.0, 1000.0, "20").otherwise("all of `model.modes`")
        .about("How many of the computed modes are kept, the lowest first. Both rigid rotations of a \
                drawn drive must stay."),
    key("model.mta", Kind::Boolean, ANY, "true").or("false")
        .about("Mode truncation augmentation: whether the modes left out return as the residual \
                flexibility that the mesh feels. It matters where `retained` is less than `modes`."),
    quantity("model.damping", Ratio, BELOW_ONE, "0.02").or("0.01")
        .about("Modal damping ratio of every elastic mode. Rigid rotations have none."),
    key("model.damping_overrides", Kind::List("tables"), ANY, "[{ mode = 7, ratio = 0.02 }]").or("[]")
        .about("Modes whose damping ratio is not `model.damping`, a table each."),
    table("model.damping_overrides.*"),
    integer("model.damping_overrides.*.mode", 1.0, 1000.0, "7")
        .about("Number of the mode, counted from 1 in ascending frequency. The rigid rotations come first \
                and stay undamped."),
    quantity("model.damping_overrides.*.ratio", Ratio, BELOW_ONE, "0.02")
        .about("Damping ratio of this mode."),
    key("model.gyroscopic", Kind::Boolean, ANY, "true").or("false")
        .about("Whether tilting shafts and gear bodies have gyroscopic moments, which couple tilts about x and y in \
                proportion to speed. By default they have none, as usual in models of gear rattle: the modes are \
                those of the drive at rest and stay uncoupled. It matters where polar inertia times speed comes \
                near transverse inertia times the frequency of a tilting mode. The end inertia, behind a \
                coupling, does not tilt and has none."),
    key("model.file", Kind::Text, ANY, r#""drive.modal.toml""#)
        .otherwise("none; required with kind = \"modal\"")
        .about("Path of the modal file, relative to the folder of the manifest. Only with kind = \"modal\"."),
];
