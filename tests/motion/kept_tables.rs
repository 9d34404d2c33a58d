//! Kept tables of closed modes: do they give the bits of new tables, are they found again for every load, gap and speed
//! and for nothing else, are damaged ones refused, and do workers share them?

#![allow(clippy::unwrap_used)]

use crate::{common, place};
use common::Case;
use common::advance::{Events, advance_with, settled};
use gearatlas::model::{Model, Stiffness, TrajectoryState};
use gearatlas::propagate::{ClosedModes, InstructionSet, KeptTables, Kernel, TableError};
use gearatlas::store::{Origin, TableStore};
use gearatlas::sweep::{KernelTables, Prepared};
use gearatlas::topology::CopyRoom;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

const EVENTS: u32 = 99;

/// The same drive with another load and gap.
fn other_load(case: &Case) -> Case {
    let mut case = case.clone();
    case.2.load *= 1.7;
    case.1.half_gap *= 1.3;
    case
}

/// The same drive under another load, at other speeds, and with other excitation.
fn others(case: &Case) -> Vec<Case> {
    let scaled = [0.2, 0.97, 1.0 + 1e-15, 2.0].map(|factor| {
        let mut case = case.clone();
        case.2.speed *= factor;
        case
    });
    let mut shaken = case.clone();
    shaken.1.transmission_error[0].amplitude *= 1.3;
    shaken.1.transmission_error[0].phase += 0.4;
    let more = case.1.transmission_error[0];
    shaken.1.transmission_error.push(more);
    scaled
        .into_iter()
        .chain([shaken, other_load(case)])
        .collect()
}

fn bits<K: Kernel>(kernel: &K, start: &TrajectoryState) -> (Vec<u64>, usize) {
    let mut events = Events::default();
    let (end, _) = advance_with(kernel, start, 20, &mut events);
    let bits = end.state.iter().map(|x| x.to_bits());
    (bits.collect(), events.0.len())
}

/// Tables kept for one load are valid for any other, with the bits of new tables.
#[test]
fn a_kept_table_gives_the_bits_of_a_new_one() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let set = InstructionSet::best();
    for case in [common::six_modes(), common::forty_modes()] {
        let (built, used) = (common::model(&case), common::model(&other_load(&case)));
        let start = settled(&used, 40);
        let fetch = |model: &Model, origin| {
            let fetched = store.systems(model).unwrap();
            assert_eq!(fetched.origin, origin);
            assert!(fetched.file.is_file() && fetched.warnings.is_empty());
            fetched.table
        };
        fetch(&built, Origin::Built);
        let kept = fetch(&used, Origin::Found);
        let new = bits(&ClosedModes::new(&used, EVENTS, set).unwrap(), &start);
        let from_kept = ClosedModes::from_kept(&used, EVENTS, &kept, set).unwrap();
        assert!(new.1 > 10, "{} events", new.1);
        assert_eq!(new, bits(&from_kept, &start));
    }
}

/// Tables are bitwise equal at every speed.
#[test]
fn one_file_serves_every_speed_load_and_excitation() {
    let store = TableStore::open("nowhere");
    for (name, case) in common::drives() {
        let own = common::model(&case);
        let arrays = ClosedModes::arrays(&own).unwrap();
        for other in others(&case) {
            let model = common::model(&other);
            assert_eq!(
                store.systems_path(&model),
                store.systems_path(&own),
                "{name}"
            );
            assert_eq!(ClosedModes::arrays(&model).unwrap(), arrays, "{name}");
        }
    }
}

/// Any change of an operator needs a separate table.
#[test]
fn other_numbers_are_another_table() {
    let store = TableStore::open("nowhere");
    let case = common::six_modes();
    let changes: [fn(&mut Case); 5] = [
        |_| (),
        |case| case.0.frequency[3] *= 1.0 + 1e-15,
        |case| case.0.mesh[4] *= 1.0 + 1e-15,
        |case| case.1.damping *= 1.0 + 1e-15,
        |case| case.1.friction *= 1.0 + 1e-15,
    ];
    let files = changes.map(|change| {
        let mut changed = case.clone();
        change(&mut changed);
        store.systems_path(&common::model(&changed))
    });
    let different = std::collections::BTreeSet::from(files);
    assert_eq!(different.len(), changes.len());
}

/// One flipped bit anywhere gives a warning of one line, and a complete new table.
#[test]
fn a_damaged_table_is_computed_anew() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let model = common::model(&common::two_modes());
    let fetch = || store.systems(&model).unwrap();
    assert_eq!(fetch().origin, Origin::Built);
    let file = store.systems_path(&model);
    let whole = fs::read(&file).unwrap();
    for place in [3, 12, 40, 70, whole.len() / 2, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[place] ^= 4;
        fs::remove_file(&file).unwrap();
        fs::write(&file, damaged).unwrap();
        let fetched = fetch();
        assert_eq!(fetched.origin, Origin::Built, "byte {place}");
        let told = fetched.warnings[0].to_string();
        assert!(
            fetched.warnings.len() == 1 && told.lines().count() == 1,
            "{told}"
        );
        assert!(told.ends_with("; the table is computed again"), "{told}");
        assert_eq!(fs::read(&file).unwrap(), whole);
    }
}

/// Workers that need the same table share it. The table stays in memory until enough other tables have been used.
#[test]
fn workers_share_one_table() {
    let folder = tempfile::tempdir().unwrap();
    let tables = KernelTables::new(TableStore::open(folder.path()));
    let model = common::model(&common::twenty_modes());
    let get = || tables.get(&model).unwrap();
    let found: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..4).map(|_| scope.spawn(get)).collect();
        workers.into_iter().map(|w| w.join().unwrap()).collect()
    });
    assert!(found.iter().all(|table| Arc::ptr_eq(table, &found[0])));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let held = Arc::downgrade(&found[0]);
    drop(found);
    assert!(Arc::ptr_eq(&get(), &held.upgrade().unwrap()));
    for factor in [1.1, 1.2, 1.3, 1.4] {
        let mut other = common::twenty_modes();
        other.1.damping *= factor;
        let other = common::model(&other);
        tables.get(&other).unwrap();
    }
    assert!(
        held.upgrade().is_none(),
        "memory does not grow with the grid"
    );
    get();
    assert!(tables.warnings().is_empty());
    // A folder that cannot exist stops nothing, and gives one warning.
    let file = folder.path().join("a file");
    fs::write(&file, "").unwrap();
    let nowhere = KernelTables::new(TableStore::open(file.join("tables")));
    for _ in 0..2 {
        nowhere.get(&model).unwrap();
    }
    assert_eq!(nowhere.warnings().len(), 1, "{:?}", nowhere.warnings());
}

/// Workers of a node read a separate copy if there is room, equal to the last bit.
#[test]
fn workers_of_a_node_read_their_own_copy() {
    let folder = tempfile::tempdir().unwrap();
    let tables = KernelTables::new(TableStore::open(folder.path()));
    let model = common::model(&common::twenty_modes());
    let get = |tables: &KernelTables| tables.get(&model).unwrap();
    let room = |private_cache| CopyRoom {
        free: None,
        private_cache,
    };
    let [first, second, small] = [0, 0, u64::MAX].map(|cache| tables.on_node(room(cache)));
    let common = get(&tables);
    assert!(Arc::ptr_eq(&common, &get(&small)), "no use for a copy");
    assert!(!common.all().is_empty() && common.bytes() > 10_000);
    for node in [&first, &second] {
        let copy = get(node);
        assert!(!Arc::ptr_eq(&common, &copy) && Arc::ptr_eq(&copy, &get(node)));
        for array in common.all() {
            let [own, copied] = [&common, &copy].map(|table| table.numbers(&array.name).unwrap());
            assert!(own == copied && (own.is_empty() || own.as_ptr() != copied.as_ptr()));
            assert!(
                (copied.as_ptr() as usize).is_multiple_of(64),
                "a cache line"
            );
        }
    }
    assert!(!Arc::ptr_eq(&get(&first), &get(&second)));
}

#[test]
fn a_model_without_tables_has_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let mut case = common::six_modes();
    let mut slope = [0.0; 8];
    (slope[0], slope[1]) = (4e8, 1e7);
    case.1.mesh[0].stiffness = Stiffness::series(slope);
    let refused = store.systems(&common::model(&case));
    assert_eq!(refused.map(|_| ()), Err(TableError::VaryingStiffness));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// `atlas run` keeps one table of closed modes, finds it again, and `atlas show` prints it.
#[test]
fn a_run_keeps_its_table_and_finds_it_again() {
    let place = Place::new(&OSCILLATOR.replace("[run]", "[run]\nkernel = \"closed_modes\""));
    let first = place.whole("a", &[]);
    let files = || -> Vec<PathBuf> {
        let entries = fs::read_dir(place.path("tables")).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    };
    // Two loads and three speeds use one file.
    let [kept] = &files()[..] else {
        panic!("{:?}", files());
    };
    let whole = fs::read(kept).unwrap();
    let mut bytes = whole.clone();
    *bytes.last_mut().unwrap() ^= 1;
    fs::remove_file(kept).unwrap();
    fs::write(kept, bytes).unwrap();
    let show = || place.atlas(&["show", kept.to_str().unwrap()]);
    assert_eq!(status(&show()), 2, "{}", stdout(&show()));
    assert!(stderr(&show()).contains("its checksum does not match"));
    let second = place.whole("b", &["--threads", "2"]);
    let warnings = place.record("b")["warnings"].to_string();
    assert!(
        warnings.contains("the table is computed again"),
        "{warnings}"
    );
    assert!(fs::read(kept).unwrap() == whole && files().len() == 1);
    let poincare = |folder: PathBuf| fs::read(folder.join("poincare.parquet")).unwrap();
    assert_eq!(poincare(first), poincare(second));

    assert_eq!(status(&show()), 0, "{}", stderr(&show()));
    let text = stdout(&show());
    for wanted in [
        "kind         systems",
        "every speed, load, gap and excitation",
        "\n  contacts: ",
        "\ngenerators ",
    ] {
        assert!(text.contains(wanted), "{text}");
    }
    let json = place.atlas(&["show", kept.to_str().unwrap(), "--json"]);
    let json: Value = serde_json::from_str(&stdout(&json)).unwrap();
    assert_eq!(json["inputs"]["modes"], 1, "{json:#}");
    let counts = json["quantities"].as_array().unwrap().iter();
    let count: u64 = counts.map(|own| own["count"].as_u64().unwrap()).sum();
    assert_eq!(json["bytes"], 8 * count);
}

/// The ten speeds of the first example use one file.
#[test]
fn speeds_of_a_grid_share_one_file() {
    let text = include_str!("../../manifests/flex80.toml");
    let job = gearatlas::manifest::parse(text, "m.toml", std::path::Path::new("")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let parts = Prepared::new(TableStore::open(folder.path()));
    let mut periods = std::collections::BTreeSet::new();
    for id in 0..80 {
        let model = parts.model(&job.points.at(id)).unwrap();
        parts.kernels().get(&model).unwrap();
        periods.insert(model.period().to_bits());
    }
    assert_eq!(periods.len(), 10);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
