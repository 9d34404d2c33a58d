use super::*;
use crate::propagate::KernelSetting;

#[test]
fn paths_are_unique_and_their_parents_known() {
    for schema in [MANIFEST, MODAL_FILE, HOUSING_FILE] {
        for (i, key) in all(schema).enumerate() {
            let twice = all(schema).take(i).any(|k| k.path == key.path);
            assert!(!twice, "{}", key.path);
            if let Some((parent, _)) = key.path.rsplit_once('.') {
                assert!(all(schema).any(|k| k.path == parent), "{}", key.path);
            }
        }
    }
}

#[test]
fn indices_and_shafts_find_their_patterns() {
    let path = |text: &str| find(MANIFEST, text).map(|key| key.path);
    assert_eq!(
        path("excitation.torque_ripple.3.order"),
        Some("excitation.torque_ripple.*.order")
    );
    assert_eq!(
        path("shafts.wheel.diameter"),
        Some("shafts.<shaft>.diameter")
    );
    assert_eq!(path("shafts.wheel.span"), Some("shafts.span"));
    assert_eq!(
        path("shafts.pinion.bearings.axial.1"),
        Some("shafts.bearings.axial.*")
    );
    assert_eq!(path("shafts.wheel.density"), None);
    assert_eq!(path("gear.bore.1"), Some("gear.bore"));
    assert_eq!(path("gear.module.1"), None);
    assert_eq!(path("shafts.third.span"), None);
    assert_eq!(path("mesh"), Some("mesh"));
}

#[test]
fn the_nearest_name_is_near() {
    let names = ["half_gap", "stiffness", "friction"];
    assert_eq!(nearest("half_gpa", &names), Some("half_gap"));
    assert_eq!(nearest("Half-Gap", &names), Some("half_gap"));
    assert_eq!(nearest("gap", &names), None);
    assert_eq!(nearest("colour", &names), None);
}

#[test]
fn ranges_read_as_words() {
    let any = find(MANIFEST, "excitation.transmission_error.*.phase")
        .unwrap()
        .bounds;
    assert_eq!(
        find(MANIFEST, "mesh.friction").unwrap().bounds.words(),
        "at least 0 and less than 1"
    );
    assert_eq!(
        find(MANIFEST, "mesh.half_gap").unwrap().bounds.words(),
        "greater than 0"
    );
    assert_eq!(any.words(), "");
    assert!(!any.contain(f64::NAN) && !any.contain(f64::INFINITY));
}

/// Every example must be accepted by the program.
#[test]
fn examples_are_accepted() {
    use crate::manifest::diagnostic::Issues;
    use crate::manifest::reader;
    use crate::manifest::tree;
    let mut checked = 0;
    for key in all(MANIFEST)
        .chain(all(MODAL_FILE))
        .chain(all(HOUSING_FILE))
    {
        let issues = Issues::default();
        let source = issues.add_source("example".to_owned(), format!("x = {}", key.example));
        if key.example.is_empty() {
            assert!(matches!(key.kind, Kind::Table), "{}", key.path);
            continue;
        }
        let tree = tree::parse(source, &issues);
        let node = &tree.entry("x").unwrap().node;
        let given = reader::Given {
            issues: &issues,
            node,
            path: key.path,
            spec: key,
        };
        match key.kind {
            Kind::Quantity(_) => {
                given.quantity();
            }
            Kind::Integer => {
                given.integer();
            }
            _ => {}
        }
        let found = issues.found.borrow();
        assert!(found.is_empty(), "{}: {found:?}", key.path);
        checked += 1;
    }
    assert!(checked > 80, "{checked}");
}

#[test]
fn every_kernel_can_be_chosen() {
    let names: Vec<&str> = KernelSetting::SETTINGS
        .iter()
        .map(|(name, _)| *name)
        .collect();
    let key = find(MANIFEST, "run.kernel").expect("a key");
    assert!(matches!(key.kind, Kind::Choice(choices) if choices == names));
    for (name, settings) in KernelSetting::SETTINGS {
        for setting in settings {
            let path = format!("run.{setting}");
            assert!(find(MANIFEST, &path).is_some(), "{name}: {path}");
        }
    }
}
