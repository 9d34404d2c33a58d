//! `atlas table list`, `show`, `verify` and `clean`.

use std::fs;
use std::path::Path;

use gearatlas::store::{Arrays, CacheKind};
use serde_json::{Value, json};

use crate::made::{inputs, keep, mesh};
use crate::program::{atlas, printed, refused};

/// A folder with a mesh table and a bases one; gives their keys.
fn two() -> (tempfile::TempDir, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let mesh = keep(folder.path(), CacheKind::Mesh, &inputs(), mesh(false));
    let mut arrays = Arrays::new();
    let values = vec![1.0, f64::NAN, -3.0];
    arrays.push("propagator", "1", &[3], values).unwrap();
    let bases = keep(
        folder.path(),
        CacheKind::Bases,
        &json!({ "modes": 80 }),
        arrays,
    );
    (folder, mesh, bases)
}

fn file(folder: &Path, kind: &str, key: &str) -> std::path::PathBuf {
    folder
        .join("tables")
        .join(format!("{kind}-{}.table", &key[..32]))
}

/// Flips a bit in place, as a failing disk would.
fn damage(path: &Path) {
    let mut bytes = fs::read(path).unwrap();
    *bytes.last_mut().unwrap() ^= 4;
    fs::remove_file(path).unwrap();
    fs::write(path, bytes).unwrap();
}

#[test]
fn tables_are_listed() {
    let (folder, mesh, bases) = two();
    let text = printed(folder.path(), &["table", "list"]);
    assert!(
        text.contains(&mesh[..12]) && text.contains(&bases[..12]),
        "{text}"
    );
    assert!(text.contains("stiffness, centre"), "{text}");
    assert!(
        text.ends_with("KiB, in tables\n") && text.contains("\n2 tables, "),
        "{text}"
    );
    let json: Value =
        serde_json::from_str(&printed(folder.path(), &["table", "list", "--json"])).unwrap();
    assert_eq!(json[1]["key"], mesh);
    assert_eq!(json[1]["arrays"][4]["shape"], json!([4, 3, 8, 8]));
    assert_eq!(json[0]["kind"], "bases");
    let length = fs::metadata(file(folder.path(), "bases", &bases))
        .unwrap()
        .len();
    assert_eq!(json[0]["bytes"], length);
    // A folder that is not there has no tables.
    let empty = printed(folder.path(), &["table", "list", "--tables", "none"]);
    assert_eq!(empty, "0 tables, 0 B, in none\n");
    assert_eq!(
        printed(
            folder.path(),
            &["table", "list", "--json", "--tables", "none"]
        ),
        "[]\n"
    );
}

#[test]
fn a_table_is_shown_by_key_and_by_file() {
    let (folder, mesh, bases) = two();
    let text = printed(folder.path(), &["table", "show", &mesh[..8]]);
    for wanted in [
        "kind         mesh",
        &mesh,
        "\n    face_width: 0.02\n",
        "4 × 3 × 8 × 8",
    ] {
        assert!(text.contains(wanted), "`{wanted}` is not in {text}");
    }
    let path = file(folder.path(), "bases", &bases);
    let path = path.to_str().unwrap();
    let text = printed(folder.path(), &["table", "show", path]);
    assert!(
        text.contains("3 (1 not finite)") && text.contains("-3"),
        "{text}"
    );
    let json: Value =
        serde_json::from_str(&printed(folder.path(), &["table", "show", path, "--json"])).unwrap();
    assert_eq!(json["inputs"], json!({ "modes": 80 }));
    assert_eq!(json["arrays"][0]["least"], -3.0);
    assert_eq!(json["arrays"][0]["not_finite"], 1);

    let unknown = refused(folder.path(), &["table", "show", "zz"], 2);
    assert!(
        unknown.starts_with("error: no table `zz` in `tables`"),
        "{unknown}"
    );
    damage(&file(folder.path(), "mesh", &mesh));
    let damaged = refused(folder.path(), &["table", "show", &mesh[..8]], 2);
    assert!(damaged.contains("has damaged data"), "{damaged}");
}

#[test]
fn damage_is_found_and_cleaned_away() {
    let (folder, mesh, bases) = two();
    let folder = folder.path();
    let text = printed(folder, &["table", "verify", "--all"]);
    assert!(text.ends_with("2 tables, all whole\n"), "{text}");
    damage(&file(folder, "mesh", &mesh));
    // The header is whole: a list does not read the data.
    assert!(!printed(folder, &["table", "list"]).contains("unusable"));
    assert!(printed(folder, &["table", "verify", &bases[..6]]).contains("1 table, all whole"));
    for arguments in [
        &["table", "verify", "--all"][..],
        &["table", "verify", &mesh[..6]],
    ] {
        let output = atlas(folder, arguments);
        assert_eq!(output.status.code(), Some(1));
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(
            text.contains("has damaged data") && text.contains("1 not usable"),
            "{text}"
        );
    }
    let text = printed(folder, &["table", "clean"]);
    assert!(
        text.contains("1 table removed") && text.contains(&mesh[..32]),
        "{text}"
    );
    assert!(
        printed(folder, &["table", "clean", "--older-than", "1h"]).starts_with("0 tables removed")
    );
    assert!(printed(folder, &["table", "clean", "--older-than", "0s"]).contains("1 table removed"));
    assert!(printed(folder, &["table", "list"]).starts_with("0 tables"));
}

#[test]
fn clean_all_leaves_other_files_alone() {
    let (folder, ..) = two();
    fs::write(folder.path().join("tables/README.md"), "kept").unwrap();
    let text = printed(folder.path(), &["table", "clean", "--all"]);
    assert!(text.contains("2 tables removed"), "{text}");
    assert_eq!(
        fs::read_dir(folder.path().join("tables")).unwrap().count(),
        1
    );
}

#[test]
fn bad_arguments_end_with_status_2() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["table"][..],
        &["table", "verify"],
        &["table", "verify", "--all", "12"],
        &["table", "show"],
        &["table", "show", "12"],
        &["table", "clean", "--older-than", "3"],
        &["table", "clean", "--older-than", "1d", "--all"],
    ] {
        assert!(!refused(folder.path(), arguments, 2).is_empty());
    }
    fs::write(folder.path().join("file"), "").unwrap();
    let text = refused(folder.path(), &["table", "list", "--tables", "file"], 1);
    assert!(text.contains("a file, not a folder"), "{text}");
}

#[test]
fn the_gears_of_a_manifest_have_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/manifests/quickstart.toml");
    let build = [
        "table",
        "build",
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
    let shown: Value =
        serde_json::from_str(&printed(folder, &["table", "show", file, "--json"])).unwrap();
    assert_eq!(shown["inputs"]["table"]["misalignment"], json!([0.0, 2e-4]));
    // What a manifest has that says nothing of it.
    assert_eq!(shown["inputs"]["table"]["contact"], "Secant");
    assert_eq!(shown["arrays"][4]["name"], "stiffness");
    // A steel spur pair: 10 to 20 N/(mm µm) (ISO 6336-1).
    let width = shown["inputs"]["gears"]["face_width"].as_f64().unwrap();
    let most = shown["arrays"][4]["greatest"].as_f64().unwrap() / width;
    assert!((1e10..2.5e10).contains(&most), "{most:e}");
    let pictures = printed(folder, &["plot", file, "--format", "svg"]);
    assert_eq!(pictures.lines().count(), 3, "{pictures}");
    // Three torques are another table.
    let other = [&build[..], &["--torque", "20 N*m,50 N*m,100 N*m", "--json"]].concat();
    let other: Value = serde_json::from_str(&printed(folder, &other)).unwrap();
    assert_eq!(other[0]["origin"], "computed");
    assert!(printed(folder, &["table", "list"]).contains("\n2 tables"));

    for (arguments, words) in [
        (["--torque", "50 N"], "a unit of force, not a torque"),
        (["--torque", "50 N*m,20 N*m"], "increase"),
        (["--misalignment", "2 mm"], "a unit of length, not an angle"),
        (["--tables", "/dev/null/x"], "a file, not a folder"),
    ] {
        let status = if arguments[0] == "--tables" { 1 } else { 2 };
        let text = refused(folder, &[&build[..3], &arguments].concat(), status);
        assert!(text.contains(words), "{arguments:?}: {text}");
    }
    let modal = concat!(env!("CARGO_MANIFEST_DIR"), "/manifests/basins.toml");
    let text = refused(folder, &["table", "build", modal], 2);
    assert!(text.contains("has no drawing of its gears"), "{text}");
}
