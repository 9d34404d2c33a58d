//! Tables of dense kernels on disk: do they give the bits of tables just computed, are they
//! found again for every load and gap and for nothing else, and is what is damaged refused?

#![allow(clippy::unwrap_used)]

use crate::{common, place};
use common::Case;
use common::advance::{Events, advance_with, settled};
use gearatlas::model::{Model, TrajectoryState};
use gearatlas::propagate::{
    DenseError, Dyadic, Fused, KeptTables, Kernel, KernelTable, Spectral, TableArray, Volterra,
};
use gearatlas::store::{OperatorFetchError, Origin, TableStore};
use gearatlas::sweep::build::BuildError;
use gearatlas::sweep::{KernelTables, Parts};
use gearatlas::topology::Room;
use place::{OSCILLATOR, Place, status, stderr, stdout};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

const CELLS: u32 = 60;
const RUNS: KernelTable = KernelTable::Runs { cells: CELLS };
const BOTH: [KernelTable; 2] = [KernelTable::Bases, RUNS];

/// The same drive under another load, with another gap.
fn other_load(case: &Case) -> Case {
    let mut case = case.clone();
    case.2.load *= 1.7;
    case.1.half_gap *= 1.3;
    case
}

fn bits<K: Kernel>(kernel: &K, start: &TrajectoryState) -> (Vec<u64>, usize) {
    let mut events = Events::default();
    let (end, _) = advance_with(kernel, start, 20, &mut events);
    (
        end.state.iter().map(|x| x.to_bits()).collect(),
        events.0.len(),
    )
}

/// Tables kept for one load serve any other, to the bits of tables computed for that one.
#[test]
fn a_kept_table_gives_the_bits_of_a_new_one() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    for case in [common::six_modes(), common::forty_modes()] {
        let (built, used) = (common::model(&case), common::model(&other_load(&case)));
        let start = settled(&used, 40);
        let fetch = |model: &Model, origin| {
            BOTH.map(|table| {
                let fetched = store.kernel_table(table, model).unwrap();
                assert_eq!(fetched.origin, origin, "{table:?}");
                assert!(fetched.table.has_file() && fetched.warnings.is_empty());
                fetched.table
            })
        };
        fetch(&built, Origin::Built);
        let [bases, runs] = fetch(&used, Origin::Found);
        let both: [&dyn KeptTables; 2] = [&bases, &runs];
        for (name, new, kept) in [
            (
                "spectral",
                bits(&Spectral::new(&used, CELLS, 99, None).unwrap(), &start),
                bits(
                    &Spectral::of_kept(&used, CELLS, 99, None, &bases).unwrap(),
                    &start,
                ),
            ),
            (
                "fused",
                bits(&Fused::new(&used, CELLS, 99).unwrap(), &start),
                bits(&Fused::of_kept(&used, CELLS, 99, both).unwrap(), &start),
            ),
        ] {
            assert!(new.1 > 10, "{} events", new.1);
            assert_eq!(new, kept, "{name}");
        }
    }
}

/// The same drive at other speeds, with other excitation of as many harmonics.
fn others(case: &Case) -> Vec<Case> {
    let scaled = [0.2, 0.5, 0.97, 1.0 + 1e-15, 2.0].map(|factor| {
        let mut case = case.clone();
        case.2.speed *= factor;
        case
    });
    let mut shaken = case.clone();
    shaken.1.transmission_error[0].amplitude *= 1.3;
    shaken.1.transmission_error[0].phase += 0.4;
    for ripple in &mut shaken.1.torque_ripple {
        ripple.amplitude *= 0.7;
    }
    scaled.into_iter().chain([shaken]).collect()
}

/// Bases of one speed are those of every other, to the last bit, and a kernel that uses them at
/// another speed follows the structured one as one with bases of its own would.
#[test]
fn one_file_serves_every_speed_and_excitation() {
    let store = TableStore::open("nowhere");
    for (name, case) in common::drives() {
        let own = common::model(&case);
        let arrays = Spectral::arrays(&own).unwrap();
        let file = store.kernel_table_path(KernelTable::Bases, &own);
        for other in others(&case) {
            let model = common::model(&other);
            assert_eq!(
                store.kernel_table_path(KernelTable::Bases, &model),
                file,
                "{name}"
            );
            assert_eq!(Spectral::arrays(&model).unwrap(), arrays, "{name}");
            if model.period() != own.period() {
                let runs = |model| store.kernel_table_path(RUNS, model);
                assert_ne!(runs(&model), runs(&own), "{name}");
            }
            let kernel = Spectral::of_kept(&model, CELLS, 1000, None, &arrays).unwrap();
            let exact = Volterra::new(&model, f64::EPSILON, 1000);
            let mut start = settled(&model, 20);
            let mut compared = 0;
            for _ in 0..10 {
                let (mut seen, mut told) = (Events::default(), Events::default());
                let (end, _) = advance_with(&exact, &start, 1, &mut seen);
                let (found, _) = advance_with(&kernel, &start, 1, &mut told);
                let moved: Vec<f64> = start.state.iter().map(|x| x * (1.0 + 1e-9)).collect();
                let beside = TrajectoryState {
                    state: moved,
                    ..start.clone()
                };
                let (beside, _) = advance_with(&exact, &beside, 1, &mut Events::default());
                let gain: f64 = 1e9 * common::state_difference(&model, &beside.state, &end.state);
                if gain < 1e3 {
                    let off = common::state_difference(&model, &found.state, &end.state);
                    assert!(
                        off < 1e-12 * gain.max(1.0),
                        "{name} {}: {off:e} {gain:e}",
                        other.2.speed
                    );
                    assert_eq!(told.0.len(), seen.0.len(), "{name}");
                    compared += 1;
                }
                start = end;
            }
            assert!(compared > 3, "{name} {}: {compared}", other.2.speed);
        }
    }
}

/// Whatever changes an operator has a table of its own.
#[test]
fn other_numbers_are_another_table() {
    let store = TableStore::open("nowhere");
    let case = common::six_modes();
    let file =
        |table: KernelTable, case: &Case| store.kernel_table_path(table, &common::model(case));
    assert_eq!(
        BOTH.map(|table| file(table, &other_load(&case))),
        BOTH.map(|table| file(table, &case))
    );
    let structure: [fn(&mut Case); 5] = [
        |case| case.0.frequency[3] *= 1.0 + 1e-15,
        |case| case.0.mesh[4] *= 1.0 + 1e-15,
        |case| case.1.damping *= 1.0 + 1e-15,
        |case| case.1.friction *= 1.0 + 1e-15,
        |case| {
            let more = case.1.transmission_error[1];
            case.1.transmission_error.push(more);
        },
    ];
    let speed: [fn(&mut Case); 4] = [
        |case| case.2.speed *= 1.0 + 1e-15,
        |case| case.0.torque[3] *= 1.0 + 1e-15,
        |case| case.1.transmission_error[1].phase += 1e-15,
        |case| case.1.torque_ripple[0].amplitude *= 1.0 + 1e-15,
    ];
    let mut files = vec![file(KernelTable::Runs { cells: CELLS + 1 }, &case)];
    files.extend(BOTH.map(|table| file(table, &case)));
    let mut change = |changes: &[fn(&mut Case)], tables: &[KernelTable]| {
        for change in changes {
            let mut changed = case.clone();
            change(&mut changed);
            files.extend(tables.iter().map(|&table| file(table, &changed)));
        }
    };
    change(&structure, &BOTH);
    change(&speed, &[RUNS]);
    let count = files.len();
    files.sort();
    files.dedup();
    assert_eq!(files.len(), count);
}

/// One bit anywhere: one line, and a new table that is whole.
#[test]
fn a_damaged_table_is_computed_anew() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let model = common::model(&common::two_modes());
    let fetch = || store.kernel_table(RUNS, &model).unwrap();
    assert_eq!(fetch().origin, Origin::Built);
    let file = store.kernel_table_path(RUNS, &model);
    let whole = fs::read(&file).unwrap();
    for place in [3, 40, 70, whole.len() / 2, whole.len() - 1] {
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
        assert!(told.ends_with(": it is computed anew"), "{told}");
        assert_eq!(fs::read(&file).unwrap(), whole);
    }
}

/// Tables of another drive, and arrays that were cut, are refused by name.
#[test]
fn tables_of_another_model_are_refused() {
    let (two, six) = (
        common::model(&common::two_modes()),
        common::model(&common::six_modes()),
    );
    let mut arrays = Spectral::arrays(&two).unwrap();
    arrays.extend(Fused::arrays(&two, CELLS).unwrap());
    let of_kept = |model, arrays: &Vec<TableArray>| {
        let both: [&dyn KeptTables; 2] = [arrays, arrays];
        Fused::of_kept(model, CELLS, 9, both).map(|_| ())
    };
    assert_eq!(of_kept(&two, &arrays), Ok(()));
    let refused = of_kept(&six, &arrays);
    assert!(
        matches!(refused, Err(DenseError::Kept { .. })),
        "{refused:?}"
    );
    for (index, array) in arrays.iter().enumerate() {
        // Said about a basis, not used by it.
        if ["touching", "dyadic_bytes"].contains(&array.name) {
            continue;
        }
        for change in [-1, 1] {
            let mut other = arrays.clone();
            let mut values = other[index].values.to_vec();
            values.resize(values.len().saturating_add_signed(change), 0.0);
            other[index].values = values[..].into();
            let refused = of_kept(&two, &other);
            assert_eq!(refused, Err(DenseError::Kept { name: array.name }));
        }
    }
}

/// Workers that want one table get one table, which stays at hand until others were used.
#[test]
fn workers_share_one_table() {
    let folder = tempfile::tempdir().unwrap();
    let tables = KernelTables::new(TableStore::open(folder.path()));
    let model = common::model(&common::twenty_modes());
    let get = || tables.get(KernelTable::Bases, &model).unwrap();
    let found: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..4).map(|_| scope.spawn(get)).collect();
        workers.into_iter().map(|w| w.join().unwrap()).collect()
    });
    assert!(found.iter().all(|table| Arc::ptr_eq(table, &found[0])));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let held = Arc::downgrade(&found[0]);
    drop(found);
    assert!(get().has_file() && Arc::ptr_eq(&get(), &held.upgrade().unwrap()));
    for factor in [1.1, 1.2, 1.3, 1.4] {
        let mut other = common::twenty_modes();
        other.1.damping *= factor;
        let other = common::model(&other);
        tables.get(KernelTable::Bases, &other).unwrap();
    }
    assert!(
        held.upgrade().is_none(),
        "memory does not grow with the grid"
    );
    assert!(get().has_file() && tables.warnings().is_empty());
    // A folder that cannot be is no obstacle, and said once.
    let file = folder.path().join("a file");
    fs::write(&file, "").unwrap();
    let nowhere = KernelTables::new(TableStore::open(file.join("tables")));
    for _ in 0..2 {
        let table = nowhere.get(KernelTable::Bases, &model).unwrap();
        assert!(!table.has_file());
    }
    assert_eq!(nowhere.warnings().len(), 1, "{:?}", nowhere.warnings());
}

/// Workers of a node read a copy of their own where there is room, equal to the last bit.
#[test]
fn workers_of_a_node_read_their_own_copy() {
    let folder = tempfile::tempdir().unwrap();
    let tables = KernelTables::new(TableStore::open(folder.path()));
    let model = common::model(&common::twenty_modes());
    let get = |tables: &KernelTables| tables.get(KernelTable::Bases, &model).unwrap();
    let room = |own_cache| Room {
        free: None,
        own_cache,
    };
    let [first, second, small] = [0, 0, u64::MAX].map(|cache| tables.on_node(room(cache)));
    let common = get(&tables);
    assert!(Arc::ptr_eq(&common, &get(&small)), "no use for a copy");
    for node in [&first, &second] {
        let copy = get(node);
        assert!(!Arc::ptr_eq(&common, &copy) && Arc::ptr_eq(&copy, &get(node)));
        for name in common.names() {
            let [own, copied] = [&common, &copy].map(|table| table.array(name).unwrap().1);
            assert!(own == copied && (own.is_empty() || own.as_ptr() != copied.as_ptr()));
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
    case.1.mesh[0].stiffness = gearatlas::model::Stiffness::series(slope);
    let model: Model = common::model(&case);
    let refused = store.kernel_table(KernelTable::Bases, &model);
    let error = refused.map(|_| ()).unwrap_err();
    assert!(matches!(
        error,
        OperatorFetchError::Dense(DenseError::VaryingStiffness)
    ));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// A refusal names the structured kernel where it fits the model, and says so where it does not.
#[test]
fn advice_is_checked_before_it_is_given() {
    let mut case = common::one_degree();
    case.0 = common::structure(&[0.0], 0.0, &[1.0], &[1.0]);
    case.1.mesh = gearatlas::model::Division::levels(&[4e8], &[]);
    case.1.damping = 4e4;
    let critical = common::model(&case);
    let refused = Spectral::new(&critical, CELLS, 9, None).map(|_| ());
    let told = BuildError::tables(refused.unwrap_err(), &critical).to_string();
    assert!(
        told.contains("nearly parallel")
            && told.contains("or set run.kernel = \"volterra\", which"),
        "{told}"
    );
    // Too slow for either: ten hours a tooth.
    case.2.speed = 1e-5;
    let slow = common::model(&case);
    let refused = Dyadic::new(&slow, CELLS, 9).map(|_| ());
    let told = BuildError::tables(refused.unwrap_err(), &slow).to_string();
    assert!(
        told.contains("does not help") && told.contains("raise the speed"),
        "{told}"
    );
    // Damaged files are no fault of the model.
    let told = BuildError::tables(DenseError::Kept { name: "a" }, &slow).to_string();
    assert!(!told.contains("volterra"), "{told}");
}

/// The size said of dyadic tables is that of the tables built.
#[test]
fn the_dyadic_size_is_known_without_building() {
    for (name, case) in common::drives() {
        let model = common::model(&case);
        let built = Dyadic::new(&model, CELLS, 9).unwrap().bytes();
        assert_eq!(Dyadic::size(&model, CELLS).unwrap(), built, "{name}");
    }
}

/// `atlas run` keeps one table of bases and one of runs a speed, finds them again, and shows them.
#[test]
fn a_run_keeps_its_tables_and_finds_them_again() {
    let manifest = OSCILLATOR.replace("[run]", "[run]\nkernel = \"fused\"");
    assert!(manifest.contains("fused"));
    let place = Place::new(&manifest);
    let first = place.whole("a", &[]);
    let files = || -> Vec<PathBuf> {
        let entries = fs::read_dir(place.path("tables")).unwrap();
        let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files
    };
    let kept = files();
    // Two loads, three speeds: bases once, runs once a speed.
    assert_eq!(kept.len(), 4, "{kept:?}");
    let damaged = &kept[1];
    let mut bytes = fs::read(damaged).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    fs::remove_file(damaged).unwrap();
    fs::write(damaged, bytes).unwrap();
    let verify = place.atlas(&["table", "verify", "--all"]);
    assert_eq!(status(&verify), 1, "{}", stdout(&verify));
    let second = place.whole("b", &["--threads", "2"]);
    let warnings = place.record("b")["warnings"].to_string();
    assert!(warnings.contains("it is computed anew"), "{warnings}");
    assert_eq!(files(), kept);
    let verify = place.atlas(&["table", "verify", "--all"]);
    assert_eq!(status(&verify), 0, "{}", stdout(&verify));
    let poincare = |folder: PathBuf| fs::read(folder.join("poincare.parquet")).unwrap();
    assert_eq!(poincare(first), poincare(second));

    let list = stdout(&place.atlas(&["table", "list"]));
    let lines = |kind| list.lines().filter(|line| line.starts_with(kind)).count();
    assert_eq!((lines("bases "), lines("runs ")), (1, 3), "{list}");
    let key = kept[0].file_stem().unwrap().to_str().unwrap().to_owned();
    let show = place.atlas(&["table", "show", &key]);
    assert_eq!(status(&show), 0, "{}", stderr(&show));
    let text = stdout(&show);
    for said in [
        "every speed, load, gap and excitation",
        "dyadic tables of the same model",
        "condition",
        "rebuilt to",
        "bases",
    ] {
        assert!(text.contains(said), "{text}");
    }
    let json: Value =
        serde_json::from_str(&stdout(&place.atlas(&["table", "show", &key, "--json"]))).unwrap();
    let operators = &json["operators"];
    assert!(
        operators["reconstruction"][0].as_f64().unwrap() < 1e-11,
        "{json:#}"
    );
    assert!(
        operators["dyadic_bytes"].as_u64() > operators["bytes"].as_u64(),
        "{json:#}"
    );
    let key = kept[1].file_stem().unwrap().to_str().unwrap().to_owned();
    let text = stdout(&place.atlas(&["table", "show", &key]));
    assert!(text.contains("the speed of mesh period"), "{text}");
    let clean = place.atlas(&["table", "clean", "--all"]);
    assert!(
        stdout(&clean).contains("4 tables removed"),
        "{}",
        stdout(&clean)
    );
}

/// The ten speeds of the first example use one file.
#[test]
fn speeds_of_a_grid_share_one_file() {
    let text = include_str!("../../manifests/flex80.toml");
    let text = text
        .replace("kernel = \"volterra\"", "kernel = \"spectral\"")
        .replace("[mesh]", "[mesh]\ncoast_flank = \"same_line\"");
    let job = gearatlas::manifest::parse(&text, "m.toml", std::path::Path::new("")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let parts = Parts::new(TableStore::open(folder.path()));
    let mut periods = std::collections::BTreeSet::new();
    for id in 0..80 {
        let point = job.points.at(id);
        let model = parts.model(&point).unwrap();
        parts.kernels().get(KernelTable::Bases, &model).unwrap();
        periods.insert(model.period().to_bits());
    }
    assert_eq!(periods.len(), 10);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
