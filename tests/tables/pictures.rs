//! `atlas plot` of a table file.

use std::fs;
use std::path::Path;

use gearatlas::store::KernelArrays;
use serde_json::json;

use crate::made::{keep, mesh};
use crate::program::{printed, refused};

/// Texts of a picture in tables/pictures, with their positions: x, y.
fn texts(folder: &Path, name: &str) -> Vec<(String, f64, f64)> {
    let source = fs::read_to_string(folder.join("tables/pictures").join(name)).unwrap();
    let document = roxmltree::Document::parse(&source).unwrap();
    let nodes = document.descendants().filter(|n| n.has_tag_name("text"));
    let place = |node: roxmltree::Node, axis| node.attribute(axis).unwrap().parse().unwrap();
    nodes
        .map(|n| {
            (
                n.text().unwrap().trim().to_owned(),
                place(n, "x"),
                place(n, "y"),
            )
        })
        .collect()
}

#[track_caller]
fn holds(texts: &[(String, f64, f64)], wanted: &[&str]) {
    for wanted in wanted {
        let found = texts.iter().any(|(text, ..)| text.contains(wanted));
        assert!(found, "`{wanted}` is not among {texts:?}");
    }
}

#[test]
fn a_mesh_table_is_drawn_with_units_and_direct_labels() {
    let folder = tempfile::tempdir().unwrap();
    let file = keep(folder.path(), mesh(true));
    let name = &file["tables/".len()..][.."mesh-".len() + 8];
    let text = printed(folder.path(), &["plot", &file]);
    let pictures = ["mesh", "mesh-misalignment", "sharing", "contact"];
    for picture in pictures {
        for format in ["svg", "png"] {
            let file = format!("tables/pictures/{name}-{picture}.{format}\n");
            assert!(text.contains(&file), "{file} is not in {text}");
        }
    }
    assert_eq!(text.lines().count(), 2 * pictures.len());
    let shown = |picture: &str| texts(folder.path(), &format!("{name}-{picture}.svg"));
    let over_torque = shown("mesh");
    holds(
        &over_torque,
        &[
            "mesh stiffness [MN/m]",
            "transmission error [µm]",
            "load centre",
            "mesh phase",
        ],
    );
    holds(
        &over_torque,
        &["20 N·m", "50 N·m", "200 N·m", "misalignment 0 mrad"],
    );
    // Without misalignment the torque changes only the transmission error.
    let together = over_torque.iter().filter(|t| t.0 == "20 … 200 N·m");
    assert_eq!(together.count(), 2);
    let over_angle = shown("mesh-misalignment");
    holds(
        &over_angle,
        &[
            "0 mrad",
            "0.1 mrad",
            "1 mrad",
            "load centre [mm]",
            "torque 50 N·m",
        ],
    );
    // Names of lines in one panel do not overlap.
    let heights: Vec<f64> = (over_angle.iter())
        .filter(|(text, x, _)| text.ends_with("rad") && *x > 8000.0)
        .map(|(.., y)| *y)
        .collect();
    assert_eq!(heights.len(), 3 * 4);
    for panel in heights.chunks(4) {
        for (i, a) in panel.iter().enumerate() {
            assert!(
                panel[..i].iter().all(|b| (a - b).abs() > 140.0),
                "{panel:?}"
            );
        }
    }
    let sharing = shown("sharing");
    holds(
        &sharing,
        &["pair 0", "pair 1", "load share", "torque 200 N·m"],
    );
    assert!(
        !sharing.iter().any(|(text, ..)| text == "pair 2"),
        "it bears nothing"
    );
    let contact = shown("contact");
    holds(
        &contact,
        &["load [", "N/m]", "position / face width", "mesh phase"],
    );
    holds(
        &contact,
        &[
            "torque 20 N·m, misalignment 0 mrad",
            "torque 200 N·m, misalignment 1 mrad",
        ],
    );
    // The same file gives the same bytes.
    let svg = folder
        .path()
        .join(format!("tables/pictures/{name}-contact.svg"));
    let first = fs::read(&svg).unwrap();
    printed(
        folder.path(),
        &["plot", &file, "--format", "svg", "--quiet"],
    );
    assert_eq!(fs::read(&svg).unwrap(), first);
}

#[test]
fn what_a_table_does_not_have_is_not_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let file = keep(folder.path(), mesh(false));
    let text = printed(folder.path(), &["plot", &file, "--format", "svg"]);
    assert!(text.starts_with("tables/pictures/mesh-"), "{text}");
    assert!(
        text.contains("contact: the table was made without a contact pattern"),
        "{text}"
    );
    let refusal = refused(folder.path(), &["plot", &file, "--what", "lambda"], 2);
    assert!(
        refusal.contains("give a folder that `atlas run`"),
        "{refusal}"
    );
    assert!(refusal.contains("available here: mesh"), "{refusal}");
    let refusal = refused(folder.path(), &["plot", &file, "--what", "contact"], 2);
    assert!(refusal.contains("without a contact pattern"), "{refusal}");
}

#[test]
fn files_that_are_no_mesh_tables_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = keep(folder.path(), KernelArrays::from(Vec::new()));
    let text = refused(folder.path(), &["plot", &file], 2);
    assert!(
        text.contains("contains a systems table, but a mesh table is expected"),
        "{text}"
    );
    // Change the table as another program might.
    let mut table = mesh(false);
    table.misalignment.clear();
    let file = keep(folder.path(), table);
    let text = refused(folder.path(), &["plot", &file], 2);
    assert!(
        text.contains("an axis is too short or does not increase"),
        "{text}"
    );
    fs::write(folder.path().join("m.toml"), json!({}).to_string()).unwrap();
    let text = refused(folder.path(), &["plot", "m.toml"], 2);
    assert!(text.contains("is not a table file of atlas"), "{text}");
}
