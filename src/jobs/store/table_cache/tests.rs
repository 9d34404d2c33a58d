//! Tests of damaged, forged and foreign files, byte by byte, and of a store through its functions.

use std::convert::Infallible;
use std::fs;

use super::*;
use serde_json::json;

/// A table of numbers.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Numbers(Vec<f64>);

impl CacheContent for Numbers {
    const KIND: CacheKind = CacheKind::Mesh;

    fn fault(&self) -> Option<&'static str> {
        self.0.is_empty().then_some("there is no number")
    }
}

/// Numbers of another kind.
#[derive(Debug, Serialize, Deserialize)]
struct Others(Vec<f64>);

impl CacheContent for Others {
    const KIND: CacheKind = CacheKind::Systems;
}

fn inputs() -> Value {
    json!({ "teeth": [25, 31], "module": 0.003 })
}

const INPUTS: &str = r#"{"module":0.003,"teeth":[25,31]}"#;

/// Numbers whose bits would change in a conversion or a comparison.
fn numbers() -> Numbers {
    let odd = [f64::NAN, -0.0, f64::MIN_POSITIVE / 4.0, f64::INFINITY, 0.1];
    Numbers(odd.to_vec())
}

fn bits(numbers: &Numbers) -> Vec<u64> {
    numbers.0.iter().map(|value| value.to_bits()).collect()
}

fn file() -> Vec<u8> {
    encode(INPUTS, &numbers()).unwrap()
}

/// The fault of some bytes.
fn fault(bytes: impl Into<Vec<u8>>) -> CacheFault {
    let read = TableFile::of_bytes(bytes.into()).and_then(|file| file.content::<Numbers>());
    read.unwrap_err()
}

/// The fault of a file with a right checksum.
fn forged(rest: &[u8]) -> CacheFault {
    let sum = blake3::hash(rest);
    fault([&file()[..16], sum.as_bytes(), rest].concat())
}

fn fetch(store: &TableStore) -> Fetched<Numbers> {
    let fetched = store.get_or_build(&inputs(), || Ok::<_, Infallible>(numbers()));
    let fetched = fetched.unwrap();
    assert_eq!(bits(&fetched.table), bits(&numbers()));
    fetched
}

#[test]
fn order_and_spaces_do_not_matter_and_bits_do() {
    let a: Value = serde_json::from_str(r#"{"b": [1.0, "x\n"], "a": {"d":1,"c":null}}"#).unwrap();
    assert_eq!(canonical(&a), r#"{"a":{"c":null,"d":1},"b":[1.0,"x\n"]}"#);
    let number = 0.1 + 0.2;
    assert_ne!(canonical(&json!(number)), canonical(&json!(0.3)));
    assert_eq!(canonical(&json!(number)).parse(), Ok(number));
    assert_ne!(canonical(&json!(0.0)), canonical(&json!(-0.0)));
}

#[test]
fn keys_differ_by_kind_and_inputs() {
    let keys = [
        key(CacheKind::Mesh, "{}"),
        key(CacheKind::Systems, "{}"),
        key(CacheKind::Mesh, "[]"),
    ];
    assert!(keys.iter().all(|key| key.len() == 64));
    assert!(keys[0] != keys[1] && keys[0] != keys[2] && keys[1] != keys[2]);
}

#[test]
fn a_table_is_built_once_and_has_every_bit_again() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path().join("deep/tables"));
    let built = fetch(&store);
    assert_eq!(built.origin, Origin::Built);
    assert!(built.warnings.is_empty() && built.file.is_file());
    let unwanted = || -> Result<Numbers, Infallible> { panic!("built twice") };
    let found = store.get_or_build(&inputs(), unwanted).unwrap();
    assert_eq!(found.origin, Origin::Found);
    assert_eq!(bits(&found.table), bits(&numbers()));
    // Other inputs or another kind give another table.
    let other = json!({ "teeth": [25, 32], "module": 0.003 });
    let other = store.get_or_build(&other, || Ok::<_, Infallible>(numbers()));
    assert_eq!(other.unwrap().origin, Origin::Built);
    let other = store.get_or_build(&inputs(), || Ok::<_, Infallible>(Others(Vec::new())));
    assert_eq!(other.unwrap().origin, Origin::Built);
    let count = fs::read_dir(&store.folder).unwrap().count();
    assert_eq!(count, 3, "a temporary file stayed");
}

#[test]
fn a_store_without_a_folder_keeps_nothing() {
    for _ in 0..2 {
        let built = fetch(&TableStore::in_memory());
        assert_eq!(built.origin, Origin::BuiltInMemory);
        assert!(built.warnings.is_empty() && !built.file.exists());
    }
}

#[test]
fn an_error_of_the_builder_is_handed_on_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let result = store.get_or_build(&inputs(), || Err::<Numbers, _>("no such flank"));
    assert_eq!(result.unwrap_err(), "no such flank");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_same_table_has_the_same_bytes() {
    assert_eq!(file(), file());
    let own = TableFile::of_bytes(file()).unwrap();
    assert_eq!(own.header.key(), key(CacheKind::Mesh, INPUTS));
    assert_eq!(own.header.inputs, INPUTS);
}

#[test]
fn any_flipped_bit_is_found() {
    let good = file();
    for at in 0..good.len() {
        for bit in 0..8 {
            let mut bad = good.clone();
            bad[at] ^= 1 << bit;
            assert!(TableFile::of_bytes(bad).is_err(), "byte {at}, bit {bit}");
        }
    }
}

#[test]
fn any_cut_and_any_tail_is_found() {
    let good = file();
    for length in 0..good.len() {
        let fault = fault(&good[..length]);
        assert!(matches!(fault, CacheFault::Checksum), "{length}: {fault}");
        assert!(fault.to_string().contains("cut off"), "{fault}");
    }
    for tail in [1, 64, 4096] {
        let fault = fault([&good[..], &vec![0; tail]].concat());
        assert!(matches!(fault, CacheFault::Checksum), "{tail}: {fault}");
    }
}

#[test]
fn foreign_files_are_told_apart() {
    let magic = fault(*b"PAR1PAR1 and more").to_string();
    assert_eq!(magic, "is not a table file of atlas");
    for foreign in [&b"\x7fELF"[..], b"atlas.svg"] {
        assert!(matches!(fault(foreign), CacheFault::Magic));
    }
    let mut later = file();
    later[12] = 7;
    assert_eq!(
        fault(later).to_string(),
        "has format version 7; this program reads version 2"
    );
}

/// Files with right checksums but wrong contents.
#[test]
fn forged_files_are_refused() {
    let good = file();
    let rest = &good[48..];
    let count = rest.len() - 5 * size_of::<f64>() - 1;
    assert_eq!(rest[count], 5, "the number of numbers");
    let with_count = |bytes: &[u8]| [&rest[..count], bytes, &rest[count + 1..]].concat();
    for (rest, words) in [
        (Vec::new(), "has invalid content"),
        (rest[..count].to_vec(), "has invalid content"),
        (rest[..rest.len() - 1].to_vec(), "has invalid content"),
        ([rest, b"\n"].concat(), "bytes follow the table"),
        (with_count(&[4]), "bytes follow the table"),
        (with_count(&[6]), "has invalid content"),
        // More numbers than any machine can hold.
        (
            with_count(&[255, 255, 255, 255, 255, 255, 255, 255, 255, 1]),
            "has invalid content",
        ),
        ([&rest[..count], &[0]].concat(), "there is no number"),
        // An unknown kind, then another kind.
        ([&[9], &rest[1..]].concat(), "has invalid content"),
        (
            [&[1], &rest[1..]].concat(),
            "contains a systems table, but a mesh table is expected",
        ),
    ] {
        let fault = forged(&rest).to_string();
        assert!(fault.contains(words), "{fault}, not {words}");
        assert!(!fault.contains('\n'), "{fault}");
    }
}

/// The only warning, about an existing file that is refused.
fn refusal(fetched: &Fetched<Numbers>) -> String {
    let text = match &fetched.warnings[..] {
        [warning @ CacheWarning::Refused { .. }] => warning.to_string(),
        other => panic!("{other:?}"),
    };
    assert_eq!(fetched.origin, Origin::Built);
    assert!(!text.contains('\n'), "{text}");
    text
}

#[test]
fn a_bad_file_is_named_and_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    let path = store.path(CacheKind::Mesh, &inputs());
    let good = file();
    // A table of the previous format.
    let mut older = good.clone();
    older[12] = 1;
    let others = encode(INPUTS, &Others(vec![1.0])).unwrap();
    for (bad, words) in [
        (Vec::new(), "is cut off or damaged"),
        (good[..good.len() - 1].to_vec(), "is cut off or damaged"),
        ([&good[..], b"\n"].concat(), "is cut off or damaged"),
        (b"PAR1 or whatever".to_vec(), "is not a table file"),
        (older, "has format version 1"),
        (
            encode("{}", &numbers()).unwrap(),
            "was computed from other inputs",
        ),
        (
            others,
            "contains a systems table, but a mesh table is expected",
        ),
    ] {
        // Written as by a program that ignores the mode of the file.
        _ = fs::remove_file(&path);
        fs::write(&path, bad).unwrap();
        let text = refusal(&fetch(&store));
        assert!(text.contains(words), "{text}");
        assert!(text.ends_with("; the table is computed again"), "{text}");
        assert!(text.contains(path.to_str().unwrap()), "{text}");
        assert_eq!(fs::read(&path).unwrap(), good);
        assert_eq!(fetch(&store).origin, Origin::Found);
    }
}

#[test]
fn nobody_may_write_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let file = fetch(&TableStore::open(folder.path())).file;
    assert_eq!(fs::metadata(file).unwrap().permissions().mode() & 0o222, 0);
}

/// A table in memory does not change when its file does.
#[test]
fn a_file_that_is_cut_down_leaves_the_table_that_was_read() {
    let folder = tempfile::tempdir().unwrap();
    let store = TableStore::open(folder.path());
    fetch(&store);
    let found = fetch(&store);
    fs::set_permissions(&found.file, Permissions::from_mode(0o644)).unwrap();
    let cut = fs::OpenOptions::new().write(true).open(&found.file);
    cut.unwrap().set_len(0).unwrap();
    assert_eq!(bits(&found.table), bits(&numbers()));
    assert!(refusal(&fetch(&store)).contains("is cut off"));
}
