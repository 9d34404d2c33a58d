//! Tables of dense kernels on disk: do they give the bits of tables just computed, are they
//! found again for every load and gap and for nothing else, and is what is damaged refused?

#![allow(clippy::unwrap_used)]

mod common;
#[path = "common/place.rs"]
mod place;

use atlas::model::{Model, TrajectoryState};
use atlas::propagate::{DenseError, Dyadic, Fused, KeptKernel, Kernel, Spectral};
use atlas::store::{OperatorFetchError, Origin, TableStore};
use atlas::sweep::KernelTables;
use atlas::sweep::build::BuildError;
use common::Case;
use common::advance::{Events, advance_with, settled};
use place::{OSCILLATOR, Place, status, stderr, stdout};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

const CELLS: u32 = 60;
const BOTH: [KeptKernel; 2] = [KeptKernel::Spectral, KeptKernel::Fused];

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
        for kernel in BOTH {
            let first = store.kernel_tables(kernel, &built, CELLS).unwrap();
            let again = store.kernel_tables(kernel, &used, CELLS).unwrap();
            assert_eq!((first.origin, again.origin), (Origin::Built, Origin::Found));
            assert!(again.table.is_mapped() && again.warnings.is_empty());
            let table = &again.table;
            let (new, kept) = match kernel {
                KeptKernel::Spectral => (
                    bits(&Spectral::new(&used, CELLS, 99, None).unwrap(), &start),
                    bits(
                        &Spectral::of_kept(&used, CELLS, 99, None, table).unwrap(),
                        &start,
                    ),
                ),
                KeptKernel::Fused => (
                    bits(&Fused::new(&used, CELLS, 99).unwrap(), &start),
                    bits(&Fused::of_kept(&used, CELLS, 99, table).unwrap(), &start),
                ),
            };
            assert!(new.1 > 10, "{} events", new.1);
            assert_eq!(new, kept, "{kernel:?}");
        }
    }
}

/// Whatever changes an operator has a table of its own.
#[test]
fn other_numbers_are_another_table() {
    let store = TableStore::open("nowhere");
    let case = common::six_modes();
    let file = |case: &Case, cells: u32| -> PathBuf {
        store.kernel_tables_path(KeptKernel::Spectral, &common::model(case), cells)
    };
    let own = file(&case, CELLS);
    assert_eq!(file(&other_load(&case), CELLS), own);
    let changes: [fn(&mut Case); 8] = [
        |case| case.2.speed *= 1.0 + 1e-15,
        |case| case.0.frequency[3] *= 1.0 + 1e-15,
        |case| case.0.torque[3] *= 1.0 + 1e-15,
        |case| case.0.mesh[4] *= 1.0 + 1e-15,
        |case| case.1.damping *= 1.0 + 1e-15,
        |case| case.1.friction *= 1.0 + 1e-15,
        |case| case.1.transmission_error[1].phase += 1e-15,
        |case| case.1.torque_ripple[0].amplitude *= 1.0 + 1e-15,
    ];
    let mut files = vec![own, file(&case, CELLS + 1)];
    for change in changes {
        let mut changed = case.clone();
        change(&mut changed);
        files.push(file(&changed, CELLS));
    }
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
    let fetch = || {
        store
            .kernel_tables(KeptKernel::Fused, &model, CELLS)
            .unwrap()
    };
    assert_eq!(fetch().origin, Origin::Built);
    let file = store.kernel_tables_path(KeptKernel::Fused, &model, CELLS);
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
    let arrays = Fused::new(&two, CELLS, 9).unwrap().arrays();
    assert!(Fused::of_kept(&two, CELLS, 9, &arrays).is_ok());
    let refused = Fused::of_kept(&six, CELLS, 9, &arrays).map(|_| ());
    assert!(
        matches!(refused, Err(DenseError::Kept { .. })),
        "{refused:?}"
    );
    for (index, array) in arrays.iter().enumerate() {
        // Said about a basis, not used by it.
        if array.name == "touching" {
            continue;
        }
        for change in [-1, 1] {
            let mut other = arrays.clone();
            match change {
                -1 => drop(other[index].values.pop()),
                _ => other[index].values.push(0.0),
            }
            let refused = Fused::of_kept(&two, CELLS, 9, &other).map(|_| ());
            assert_eq!(refused, Err(DenseError::Kept { name: array.name }));
        }
    }
}

/// Workers that want one table get one table; nobody using it, it is let go.
#[test]
fn workers_share_one_table() {
    let folder = tempfile::tempdir().unwrap();
    let tables = KernelTables::new(TableStore::open(folder.path()));
    let model = common::model(&common::twenty_modes());
    let get = || tables.get(KeptKernel::Spectral, &model, CELLS).unwrap();
    let found: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..4).map(|_| scope.spawn(get)).collect();
        workers.into_iter().map(|w| w.join().unwrap()).collect()
    });
    assert!(found.iter().all(|table| Arc::ptr_eq(table, &found[0])));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let gone = Arc::downgrade(&found[0]);
    drop(found);
    assert!(gone.upgrade().is_none());
    assert!(get().is_mapped() && tables.warnings().is_empty());
    // A folder that cannot be is no obstacle, and said once.
    let file = folder.path().join("a file");
    fs::write(&file, "").unwrap();
    let nowhere = KernelTables::new(TableStore::open(file.join("tables")));
    for _ in 0..2 {
        let table = nowhere.get(KeptKernel::Spectral, &model, CELLS).unwrap();
        assert!(!table.is_mapped());
    }
    assert_eq!(nowhere.warnings().len(), 1, "{:?}", nowhere.warnings());
}

#[test]
fn a_model_without_tables_has_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let mut case = common::six_modes();
    let mut slope = [0.0; 8];
    (slope[0], slope[1]) = (4e8, 1e7);
    case.1.mesh[0].stiffness = atlas::model::Stiffness::series(slope);
    let model: Model = common::model(&case);
    let refused = store.kernel_tables(KeptKernel::Spectral, &model, CELLS);
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
    case.1.mesh = atlas::model::Division::levels(&[4e8], &[]);
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
        told.contains("does not fit either") && told.contains("raise the speed"),
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

/// `atlas run` keeps one table a speed, finds it again, and shows it.
#[test]
fn a_run_keeps_a_table_a_speed_and_finds_it_again() {
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
    // Two loads, three speeds.
    assert_eq!(kept.len(), 3, "{kept:?}");
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
    assert_eq!(list.matches("\nfused ").count(), 3, "{list}");
    let key = kept[0].file_stem().unwrap().to_str().unwrap().to_owned();
    let show = place.atlas(&["table", "show", &key]);
    assert_eq!(status(&show), 0, "{}", stderr(&show));
    let text = stdout(&show);
    for said in [
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
    let clean = place.atlas(&["table", "clean", "--all"]);
    assert!(
        stdout(&clean).contains("3 tables removed"),
        "{}",
        stdout(&clean)
    );
}
