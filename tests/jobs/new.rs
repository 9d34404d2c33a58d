//! `atlas new`: every template is a separate valid manifest with the requested name.

use crate::program::{atlas, printed};
use std::fs;

#[test]
fn every_template_is_a_job_of_its_own() {
    for template in [
        "pair",
        "drawing",
        "train",
        "planetary",
        "wind-turbine",
        "idle-rattle",
        "clutch",
    ] {
        let folder = tempfile::tempdir().unwrap();
        let said = printed(&folder, &["new", "my-drive", "--from", template]);
        assert_eq!(
            said,
            "my-drive.toml\nNext: atlas check my-drive.toml, then atlas run my-drive.toml\n"
        );
        let text = fs::read_to_string(folder.path().join("my-drive.toml")).unwrap();
        assert!(text.starts_with("# my-drive:"), "{text}");
        assert!(text.contains("name = \"my-drive\"") && !text.contains("manifests/"));
        let output = atlas(&folder, &["check", "my-drive.toml"]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        assert!(
            String::from_utf8(output.stdout)
                .unwrap()
                .contains("my-drive")
        );
    }
}

#[test]
fn files_stay_and_names_are_those_of_jobs() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str]| {
        let output = atlas(&folder, arguments);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refused(&["new", "../case"]).contains("cannot name a results folder"));
    fs::write(folder.path().join("mine.toml"), "mine").unwrap();
    assert!(refused(&["new", "mine"]).contains("already exists"));
    assert_eq!(fs::read(folder.path().join("mine.toml")).unwrap(), b"mine");
    printed(&folder, &["new", "mine", "--overwrite"]);
    // The name of the file does as well.
    printed(&folder, &["new", "other.toml"]);
    assert!(folder.path().join("other.toml").exists());
}
