//! `atlas table` and `atlas show` of a table.

use std::fs;
use std::path::Path;

use gearatlas::propagate::TableArray;
use gearatlas::store::KernelArrays;
use serde_json::{Value, json};

use crate::made::{inputs, keep, mesh};
use crate::program::{printed, refused};

/// Flips a bit in place, like a failing disk.
fn damage(path: &Path) {
    let mut bytes = fs::read(path).unwrap();
    *bytes.last_mut().unwrap() ^= 4;
    fs::remove_file(path).unwrap();
    fs::write(path, bytes).unwrap();
}

fn json_of(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(folder, arguments)).unwrap()
}

#[test]
fn a_table_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let file = keep(folder, mesh(false));
    let text = printed(folder, &["show", &file]);
    for wanted in [
        "kind         mesh",
        &file,
        "checksum     right",
        "\n    face_width: 0.02\n",
        "\nstiffness           N/m           768",
        "\npattern             N/m             0             –             –\n",
    ] {
        assert!(text.contains(wanted), "`{wanted}` is not in {text}");
    }
    let shown = json_of(folder, &["show", &file, "--json"]);
    assert_eq!(shown["inputs"], inputs());
    assert_eq!(shown["quantities"][7]["name"], "share");
    assert_eq!(shown["quantities"][7]["count"], 3 * 768);
    let key = shown["key"].as_str().unwrap();
    assert!(file.contains(&key[..32]), "{key}");

    let odd = TableArray {
        name: "propagator",
        unit: "1",
        values: [1.0, f64::NAN, -3.0][..].into(),
    };
    let file = keep(folder, KernelArrays::from(vec![odd]));
    let text = printed(folder, &["show", &file]);
    assert!(
        text.contains("kind         systems") && text.contains("-3"),
        "{text}"
    );
    let shown = json_of(folder, &["show", &file, "--json"]);
    let wanted =
        json!({ "name": "propagator", "unit": "1", "count": 3, "least": -3.0, "greatest": 1.0 });
    assert_eq!(shown["quantities"][0], wanted);

    damage(&folder.join(&file));
    let text = refused(folder, &["show", &file], 2);
    assert!(
        text.contains("is cut off or damaged") && text.lines().count() == 1,
        "{text}"
    );
    fs::write(folder.join("m.toml"), "[job]\n").unwrap();
    let text = refused(folder, &["show", "m.toml"], 2);
    assert!(
        text.contains("is not a table file of atlas; give a folder"),
        "{text}"
    );
    let text = refused(folder, &["show", "tables"], 2);
    assert!(text.contains("`atlas show tables/FILE`"), "{text}");
}

#[test]
fn bad_arguments_end_with_status_2() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["table"][..],
        &["table", "none.toml"],
        &["table", "none.toml", "--torque", "x"],
    ] {
        assert!(!refused(folder.path(), arguments, 2).is_empty());
    }
}

#[test]
fn the_gears_of_a_manifest_have_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/manifests/quickstart.toml");
    let build = [
        "table",
        manifest,
        "--misalignment",
        "0 mrad,0.2 mrad",
        "--pattern",
    ];
    let text = printed(folder, &build);
    assert!(text.starts_with("computed  tables/mesh-"), "{text}");
    let again = printed(folder, &build);
    assert_eq!(again, text.replace("computed ", "found    "));
    let file = text.split_whitespace().nth(1).unwrap();
    let shown = json_of(folder, &["show", file, "--json"]);
    assert_eq!(shown["inputs"]["table"]["misalignment"], json!([0.0, 2e-4]));
    // The manifest requests no table, so the table has the default contact law.
    assert_eq!(shown["inputs"]["table"]["contact"], "Secant");
    assert_eq!(shown["quantities"][0]["name"], "stiffness");
    // A steel spur pair: 10 to 20 N/(mm µm) (ISO 6336-1).
    let width = shown["inputs"]["gears"]["face_width"].as_f64().unwrap();
    let most = shown["quantities"][0]["greatest"].as_f64().unwrap() / width;
    assert!((1e10..2.5e10).contains(&most), "{most:e}");
    let pictures = printed(folder, &["plot", file, "--format", "svg"]);
    assert_eq!(pictures.lines().count(), 3, "{pictures}");
    // Three torques give another table.
    let other = [&build[..], &["--torque", "20 N*m,50 N*m,100 N*m", "--json"]].concat();
    assert_eq!(json_of(folder, &other)[0]["origin"], "computed");
    let tables = || {
        let files = fs::read_dir(folder.join("tables")).unwrap();
        let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.ends_with(".table")).count()
    };
    assert_eq!(tables(), 2);

    for (arguments, words) in [
        (["--torque", "50 N"], "a unit of force, not a torque"),
        (["--torque", "50 N*m,20 N*m"], "increase"),
        (["--misalignment", "2 mm"], "a unit of length, not an angle"),
        (["--tables", "/dev/null/x"], "a file, not a folder"),
    ] {
        let status = if arguments[0] == "--tables" { 1 } else { 2 };
        let text = refused(folder, &[&build[..2], &arguments].concat(), status);
        assert!(text.contains(words), "{arguments:?}: {text}");
    }
    let modal = concat!(env!("CARGO_MANIFEST_DIR"), "/manifests/basins.toml");
    let text = refused(folder, &["table", modal], 2);
    assert!(text.contains("has no drawing of its gears"), "{text}");
}
